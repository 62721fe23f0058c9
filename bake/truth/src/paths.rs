//! Path tracing of light between hairs. Fibres scatter as in [`pelage_formats::meaning::scattering::near`], the mesh
//! surface by Lambert's law, below gloss if it has any.
//!
//! A light of colour 1 causes an irradiance of π, so that a white surface facing it has radiance 1, as in the lighting
//! equation. Without an environment map, every path that leaves the scene meets ambient light: a uniform sky whose
//! radiance is ka times the key light's colour.
//!
//! A fibre's absorption gives dense fur its colour ([`pelage_formats::meaning::scattering::colour::absorption`]). Light
//! enters and leaves a strand at the same point, because strands are thin compared with their surroundings.

use super::gloss::GlossyPoint;
use super::lighting::{Sample, TrueLight, bare_normal, frame, vector};
use super::scattering::TrueScattering;
use super::sky::TrueSky;
use super::tracer::{Hit, RayOrigin};
use glam::DVec3;
use pelage_bake::noise::{hash, uniform};
use pelage_formats::meaning::scattering::Angles;
use pelage_formats::meaning::scattering::near;
use std::f64::consts::{PI, TAU};

/// Number of bounces before Russian roulette, which ends paths of little weight at random without bias.
const MIN_BOUNCES: u32 = 4;
/// Maximum albedo of the mesh surface.
const MAX_SURFACE_ALBEDO: f64 = 0.98;

/// Scattering at a hit point.
enum Scatterer<'a> {
    Hair {
        hit: near::FibreHit<'a>,
        tip: DVec3,
        to_eye: DVec3,
    },
    /// `gloss`: glossy point, and the share of the surface that is bare there.
    Skin {
        albedo: DVec3,
        normal: DVec3,
        gloss: Option<(GlossyPoint, f64)>,
    },
}

impl Sample<'_> {
    /// Returns the linear RGB radiance from `hit` at `place_ws` towards the eye, over all paths. Adds the rays to the
    /// lights and the continued paths to `shadow_rays`.
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
            let pair = |what: u64| {
                let (seed, number) = self.of_pixel;
                even_pair(hash(hash(seed, 0xb0c5 + u64::from(bounce)), what), number)
            };
            let start = match hit {
                Hit::Hair { strand, .. } => RayOrigin { strand: Some(strand), triangle: None },
                Hit::Skin { triangle, .. } => RayOrigin { strand: None, triangle: Some(triangle) },
            };
            let met = self.scatterer_at(scattering, &hit, to_eye, place);
            for (i, light) in std::iter::once(&self.lighting.key).chain(&self.lighting.fill).enumerate() {
                // Beside an environment map, the key light is black.
                let power = light.color() * PI;
                if power == DVec3::ZERO {
                    continue;
                }
                *shadow_rays += 1;
                let (way, seen) = self.light_visibility(light, i == 0, place, start, || pair(0));
                if seen {
                    sum += left * met.value_of_light(way) * power;
                }
            }
            if let Some(sky) = &self.lighting.sky {
                *shadow_rays += 1;
                sum += left * self.sky_contribution(sky, &met, place, start, pair(1));
            }
            let (way, weight) = {
                let ([path, around], [height, turn]) = (pair(2), pair(3));
                met.sample([path, around, height, turn])
            };
            left *= weight;
            if left.max_element() <= 0.0 {
                break;
            }
            *shadow_rays += 1;
            let Some((next, distance)) = self.tracer.first_hit_from(place, way, start) else {
                sum += left
                    * self.lighting.sky.as_ref().map_or(ambient, |sky| {
                        // Balance heuristic: samples of the sky contribute the remaining weight.
                        let (ours, (radiance, other)) = (met.pdf(way), sky.radiance_and_pdf(way));
                        radiance * (ours / (ours + other))
                    });
                break;
            };
            if bounce >= MIN_BOUNCES {
                let stays = left.max_element().min(0.95);
                if f64::from(uniform(hash(self.seed, 0xb0c5 + u64::from(bounce)), 12)) >= stays {
                    break;
                }
                left /= stays;
            }
            place += way * distance;
            (hit, to_eye) = (next, -way);
        }
        sum
    }

    /// Returns the direction from a point to a light, and the light's visibility. For the key light the direction is to
    /// a random point of its disc.
    fn light_visibility(
        &self,
        light: &TrueLight,
        key: bool,
        place: DVec3,
        start: RayOrigin,
        aside: impl FnOnce() -> [f64; 2],
    ) -> (DVec3, bool) {
        let (axis, distance) = light.direction_and_distance(place);
        let way = if key { self.on_disc(axis, aside().into()) } else { axis };
        let skin = key && self.lighting.skin_shadows;
        let hair = if key { self.lighting.hair_shadows } else { self.lighting.fill_shadows };
        (way, self.tracer.is_lit(place, way, distance / axis.dot(way), start, (hair, skin)))
    }

    /// Returns the light of one sampled sky direction that is scattered to the eye. It is weighted against samples of
    /// the scattering by the balance heuristic (Veach and Guibas 1995).
    fn sky_contribution(
        &self,
        sky: &TrueSky,
        met: &Scatterer<'_>,
        place: DVec3,
        start: RayOrigin,
        even: [f64; 2],
    ) -> DVec3 {
        let Some((way, radiance, likely)) = sky.sample(even) else { return DVec3::ZERO };
        let value = met.value(way);
        if value.max_element() <= 0.0 || !self.tracer.is_lit(place, way, f64::INFINITY, start, (true, true)) {
            return DVec3::ZERO;
        }
        value * radiance / (likely + met.pdf(way))
    }

    fn scatterer_at<'a>(
        &self,
        scattering: &'a TrueScattering,
        hit: &Hit,
        to_eye: DVec3,
        place: DVec3,
    ) -> Scatterer<'a> {
        match *hit {
            Hit::Hair { point, share, strand } => {
                let of = scattering.of_strand(strand);
                let points = &self.tracer.curves.points;
                let (a, b) = (&points[point], &points[point + 1]);
                let (from, to) = (a.position_ws.as_dvec3(), b.position_ws.as_dvec3());
                let tip = (to - from).normalize_or(DVec3::Y);
                let color = a.color.as_dvec3().lerp(b.color.as_dvec3(), share);
                let sigma = of.absorption(color);
                let sin = tip.dot(to_eye).clamp(-1.0, 1.0);
                let across = (to_eye - tip * sin).normalize_or(tip.any_orthonormal_vector());
                let out = place - from.lerp(to, share);
                let normal = (out - tip * out.dot(tip)).normalize_or(across);
                let offset = -normal.dot(tip.cross(across));
                let angles = (sin, (1.0 - sin * sin).max(0.0).sqrt());
                let hit = near::FibreHit::new(&of.fibre, of.scale, sigma, offset, angles);
                Scatterer::Hair { hit, tip, to_eye }
            }
            Hit::Skin { triangle, weights, front } => {
                let skin = &self.tracer.skin;
                let base = skin.base_color(triangle, weights);
                let [base, hair_base] = [base, skin.hair_base(triangle, base)].map(|c| c.truncate().as_dvec3());
                // The undercoat is the surface below hair: a matte layer of the roots' colour.
                let (coat, wetness) = self.undercoat(triangle, weights);
                let hair_normal = frame(skin, triangle, weights)[0];
                let normal = bare_normal(skin, triangle, weights).lerp(hair_normal, coat).normalize_or(hair_normal);
                let normal = normal * if front { 1.0 } else { -1.0 };
                let [dry, wet] = self.material.root_colors;
                let roots = dry.lerp(wet, wetness);
                let albedo = base * DVec3::ONE.lerp(roots, coat) + (hair_base - base) * roots * coat;
                let albedo = albedo.clamp(DVec3::ZERO, DVec3::splat(MAX_SURFACE_ALBEDO));
                let gloss = skin.material(triangle).gloss.filter(|_| coat < 1.0);
                let gloss = gloss.map(|of| (GlossyPoint::new(&of, base, normal, to_eye), 1.0 - coat));
                Scatterer::Skin { albedo, normal, gloss }
            }
        }
    }
}

impl Scatterer<'_> {
    /// Returns the scattering towards the eye of light from direction `way`, per steradian, cosine included.
    fn value(&self, way: DVec3) -> DVec3 {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let angles = Angles::between(*tip, way, *to_eye);
                // The fibre expects the azimuth of the light relative to the eye's.
                hit.value(angles.from, -angles.phi).0.into()
            }
            Self::Skin { gloss, .. } => {
                self.below_gloss(way) + gloss.map_or(DVec3::ZERO, |(point, bare)| point.value(way) * bare)
            }
        }
    }

    /// Returns the same as [`Self::value`] for a light, whose highlight has the size of the light.
    fn value_of_light(&self, way: DVec3) -> DVec3 {
        match self {
            Self::Skin { gloss: Some((point, bare)), .. } => self.below_gloss(way) + point.value_of_light(way) * *bare,
            _ => self.value(way),
        }
    }

    /// Returns the scattering below a glossy surface, per steradian, cosine included; 0 for hair.
    fn below_gloss(&self, way: DVec3) -> DVec3 {
        let Self::Skin { albedo, normal, gloss } = self else { return DVec3::ZERO };
        let enters = gloss.map_or(DVec3::ONE, |(point, bare)| DVec3::ONE.lerp(point.enters(way), bare));
        *albedo * enters * (normal.dot(way).max(0.0) / PI)
    }

    /// Returns the probability density with which [`Self::sample`] chooses the direction `way`, per steradian.
    fn pdf(&self, way: DVec3) -> f64 {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let angles = Angles::between(*tip, way, *to_eye);
                hit.value(angles.from, -angles.phi).1
            }
            Self::Skin { normal, gloss, .. } => {
                let below = normal.dot(way).max(0.0) / PI;
                gloss.map_or(below, |(point, _)| below.midpoint(point.pdf(way)))
            }
        }
    }

    /// Samples a direction of incoming light. Returns it, and its scattering divided by its probability density.
    fn sample(&self, even: [f64; 4]) -> (DVec3, DVec3) {
        match self {
            Self::Hair { hit, tip, to_eye } => {
                let drawn = hit.sample(even);
                let across = (*to_eye - *tip * tip.dot(*to_eye)).normalize_or(tip.any_orthonormal_vector());
                let around = across * libm::cos(drawn.phi) + tip.cross(across) * libm::sin(drawn.phi);
                let way = (*tip * drawn.from.0 + around * drawn.from.1).normalize_or(around);
                (way, drawn.weight.into())
            }
            Self::Skin { gloss: Some((point, _)), .. } if even[2] < 0.5 => {
                let way = point.sample([even[0], even[1]]);
                (way, self.value(way) / self.pdf(way).max(1e-12))
            }
            Self::Skin { albedo, normal, gloss } => {
                let (side, up) = normal.any_orthonormal_pair();
                let (radius, turn) = (even[0].sqrt(), TAU * even[1]);
                let flat = side * (radius * libm::cos(turn)) + up * (radius * libm::sin(turn));
                let way = (flat + *normal * (1.0 - even[0]).max(0.0).sqrt()).normalize_or(*normal);
                (way, if gloss.is_some() { self.value(way) / self.pdf(way).max(1e-12) } else { *albedo })
            }
        }
    }
}

/// Returns point `number` of a sequence that covers the unit square evenly: Sobol' points with Owen's scrambling, by
/// hashes (Burley 2020). Sequences of different seeds are independent.
fn even_pair(seed: u64, number: u32) -> [f64; 2] {
    // Permutes the bits so that each depends on the lower ones only.
    let permuted = |mut x: u32, seed: u32| {
        x = x.wrapping_add(seed);
        for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
            x ^= x.wrapping_mul(factor);
        }
        x
    };
    let seeds = [0, 1].map(|i| hash(seed, i));
    let number = permuted(number.reverse_bits(), seeds[0] as u32).reverse_bits();
    // Second dimension: Pascal's triangle modulo 2 as a matrix.
    let mut second = number;
    for (shift, mask) in [(1, 0x5555_5555), (2, 0x3333_3333), (4, 0x0f0f_0f0f), (8, 0x00ff_00ff), (16, 0xffff)] {
        second ^= (second >> shift) & mask;
    }
    [(number, seeds[1] as u32), (second, (seeds[1] >> 32) as u32)]
        .map(|(x, seed)| f64::from(permuted(x, seed).reverse_bits()) / 4_294_967_296.0)
}

#[cfg(test)]
#[path = "paths_tests.rs"]
mod tests;
