//! Light that goes on from hair to hair: paths from the eye, along which fibres scatter as [`pelage_formats::meaning::scattering::near`] has it and skin
//! as Lambert's law has it.
//!
//! A light of colour 1 brings an irradiance of π, so that a white surface square to it has radiance 1, as the lighting equation has it. Ambient light is
//! an even sky of radiance ka times the key light's colour, where there is no other: what leaves all there is meets it.
//!
//! A fibre absorbs as much as makes a deep coat of its colour ([`colour::absorption`]). Light enters a strand and leaves it at one place: it is thin
//! against all that is about it.

use super::lighting::{Sample, TrueLight, frame, vector};
use super::scattering::TrueScattering;
use super::sky::TrueSky;
use super::tracer::{Hit, Start};
use glam::DVec3;
use pelage_bake::noise::{hash, uniform};
use pelage_formats::meaning::scattering::near;
use pelage_formats::meaning::scattering::{Angles, colour};
use std::f64::consts::{PI, TAU};

/// Bounces after which paths that carry little end by chance, so that the mean stays right.
const SURE_BOUNCES: u32 = 4;
/// Most of the light that skin gives back.
const MOST_OF_SKIN: f64 = 0.98;

/// Where light is scattered.
enum Met<'a> {
    Hair { hit: near::Hit<'a>, tip: DVec3, to_eye: DVec3 },
    Skin { albedo: DVec3, normal: DVec3 },
}

impl Sample<'_> {
    /// Linear RGB that leaves `hit` at `place_ws` towards the eye along all paths. `shadow_rays` counts those to the lights, and those that go on.
    pub(super) fn path(
        &self,
        scattering: &TrueScattering,
        hit: &Hit,
        place_ws: DVec3,
        to_eye: DVec3,
        shadow_rays: &mut u64,
    ) -> DVec3 {
        let ambient = vector(self.material.dry.ambient) * self.lighting.key.color();
        let (mut sum, mut left) = (DVec3::ZERO, DVec3::ONE);
        let (mut hit, mut place, mut to_eye) = (*hit, place_ws, to_eye);
        for bounce in 0..scattering.bounces() {
            let draw = |what: u64| f64::from(uniform(hash(self.seed, 0xb0c5 + u64::from(bounce)), what));
            let start = match hit {
                Hit::Hair { strand, .. } => Start { strand: Some(strand), triangle: None },
                Hit::Skin { triangle, .. } => Start { strand: None, triangle: Some(triangle) },
            };
            let met = self.met(scattering, &hit, to_eye, place);
            for (i, light) in std::iter::once(&self.lighting.key).chain(&self.lighting.fill).enumerate() {
                *shadow_rays += 1;
                let aside = [draw(10), draw(11)];
                let (way, seen) = self.seen_light(light, i == 0, place, start, aside);
                if seen {
                    sum += left * met.value(way) * light.color() * PI;
                }
            }
            if let Some(sky) = &self.lighting.sky {
                *shadow_rays += 1;
                sum += left * self.seen_sky(sky, &met, place, start, [draw(13), draw(14)]);
            }
            let (way, weight) = met.draw(std::array::from_fn(|i| draw(i as u64)));
            left *= weight;
            if left.max_element() <= 0.0 {
                break;
            }
            *shadow_rays += 1;
            let Some((next, distance)) = self.tracer.first_from(place, way, start) else {
                sum += left
                    * self.lighting.sky.as_ref().map_or(ambient, |sky| {
                        // The sky's own directions have brought the rest of it.
                        let (ours, other) = (met.likely(way), sky.likely(way));
                        sky.radiance(way) * (ours / (ours + other))
                    });
                break;
            };
            if bounce >= SURE_BOUNCES {
                let stays = left.max_element().min(0.95);
                if draw(12) >= stays {
                    break;
                }
                left /= stays;
            }
            place += way * distance;
            (hit, to_eye) = (next, -way);
        }
        sum
    }

    /// Direction of a light from a place, drawn from its disc where it is the key light, and whether it is seen.
    fn seen_light(&self, light: &TrueLight, key: bool, place: DVec3, start: Start, aside: [f64; 2]) -> (DVec3, bool) {
        let (axis, distance) = light.seen_from(place);
        let way = if key { self.on_disc(axis, aside.into()) } else { axis };
        let skin = key && self.lighting.skin_shadows;
        let hair = if key { self.lighting.hair_shadows } else { self.lighting.fill_shadows };
        (way, self.tracer.is_lit(place, way, distance / axis.dot(way), start, (hair, skin)))
    }

    /// What is scattered to the eye of the sky's light from one of the directions that it has drawn, weighed against what scattering draws (Veach and Guibas 1995, the
    /// balance heuristic).
    fn seen_sky(&self, sky: &TrueSky, met: &Met<'_>, place: DVec3, start: Start, even: [f64; 2]) -> DVec3 {
        let Some((way, likely)) = sky.draw(even) else { return DVec3::ZERO };
        let value = met.value(way);
        if value.max_element() <= 0.0 || !self.tracer.is_lit(place, way, f64::INFINITY, start, (true, true)) {
            return DVec3::ZERO;
        }
        value * sky.radiance(way) / (likely + met.likely(way))
    }

    fn met<'a>(&self, scattering: &'a TrueScattering, hit: &Hit, to_eye: DVec3, place: DVec3) -> Met<'a> {
        match *hit {
            Hit::Hair { point, share, strand } => {
                let of = scattering.of_strand(strand);
                let points = &self.tracer.curves.points;
                let (a, b) = (&points[point], &points[point + 1]);
                let (from, to) = (a.position_ws.as_dvec3(), b.position_ws.as_dvec3());
                let tip = (to - from).normalize_or(DVec3::Y);
                let color = a.color.as_dvec3().lerp(b.color.as_dvec3(), share);
                let sigma = colour::absorption(color.to_array(), of.scale);
                let sin = tip.dot(to_eye).clamp(-1.0, 1.0);
                let across = (to_eye - tip * sin).normalize_or(tip.any_orthonormal_vector());
                let out = place - from.lerp(to, share);
                let normal = (out - tip * out.dot(tip)).normalize_or(across);
                let offset = -normal.dot(tip.cross(across));
                let angles = (sin, (1.0 - sin * sin).max(0.0).sqrt());
                let hit = near::Hit::new(&of.fibre, of.scale, sigma, offset, angles);
                Met::Hair { hit, tip, to_eye }
            }
            Hit::Skin { triangle, weights, front } => {
                let skin = &self.tracer.skin;
                let base = skin.base_color(triangle, weights).truncate().as_dvec3();
                let normal = frame(skin, triangle, weights)[0] * if front { 1.0 } else { -1.0 };
                // Below hair lies the undercoat: a mat of it, of the roots' colour.
                let (coat, wetness) = self.undercoat(triangle, weights);
                let [dry, wet] = self.material.root_colors;
                let albedo = base * DVec3::ONE.lerp(dry.lerp(wet, wetness), coat);
                Met::Skin { albedo: albedo.clamp(DVec3::ZERO, DVec3::splat(MOST_OF_SKIN)), normal }
            }
        }
    }
}

impl Met<'_> {
    /// What is scattered to the eye of light from a direction, a steradian, its cosine applied.
    fn value(&self, way: DVec3) -> DVec3 {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let angles = Angles::between(*tip, way, *to_eye);
                // The fibre has the azimuth of the light from the eye's.
                hit.value(angles.from, -angles.phi).0.into()
            }
            Self::Skin { albedo, normal } => *albedo * (normal.dot(way).max(0.0) / PI),
        }
    }

    /// How likely [`Self::draw`] takes a direction, a steradian.
    fn likely(&self, way: DVec3) -> f64 {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let angles = Angles::between(*tip, way, *to_eye);
                hit.value(angles.from, -angles.phi).1
            }
            Self::Skin { normal, .. } => normal.dot(way).max(0.0) / PI,
        }
    }

    /// A direction that light may come from, and what is scattered from there over how likely it was drawn.
    fn draw(&self, even: [f64; 4]) -> (DVec3, DVec3) {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let drawn = hit.draw(even);
                let across = (*to_eye - *tip * tip.dot(*to_eye)).normalize_or(tip.any_orthonormal_vector());
                let around = across * libm::cos(drawn.phi) + tip.cross(across) * libm::sin(drawn.phi);
                let way = (*tip * drawn.from.0 + around * drawn.from.1).normalize_or(around);
                (way, drawn.weight.into())
            }
            Self::Skin { albedo, normal } => {
                let (side, up) = normal.any_orthonormal_pair();
                let (radius, turn) = (even[0].sqrt(), TAU * even[1]);
                let flat = side * (radius * libm::cos(turn)) + up * (radius * libm::sin(turn));
                ((flat + *normal * (1.0 - even[0]).max(0.0).sqrt()).normalize_or(*normal), *albedo)
            }
        }
    }
}

#[cfg(test)]
#[path = "paths_tests.rs"]
mod tests;
