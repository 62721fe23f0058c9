//! Yang 2006, eq. (3), evaluated where a ray hits. Implemented from the paper, independently of the runtime's code.
//!
//! Light of a hair: ka · γ(h) · C + (kd · C · sin^pd(T, L) + ks · sin^ps(T, H)) · Attenu_Back · V. T is the direction
//! of the strand, h its exact height as a fraction of the fur's height. V is the visibility of the light past all
//! strands and the mesh surface: 0 or 1 for one point of the light.
//!
//! **Furred surface.** Between the hairs, the undercoat is visible: hair of the roots' colour, too short to be seen
//! singly, which the bake paints as layer 0. Each sample of the undercoat is lit as the root of a random strand of the
//! tile, so that the mean over samples is the mean over strands. Where the groom thins hair out or shortens it to zero,
//! bare surface is visible in proportion. Without an undercoat, pale surface would be visible through the fur, unlike
//! in any package.
//!
//! **Bare surface** follows Lambert's law with the same constants, so that it is as bright as the fur beside it: ka · C
//! + kd · C · max(N·L, 0) · V. Glossy surface mirrors a share F of that light, and 1 − F enters it.

use super::disc;
use super::gloss::GlossyPoint;
use super::scattering::TrueScattering;
use super::sky::TrueSky;
use super::tracer::{Hit, RayOrigin, Tracer};
use glam::{DVec2, DVec3, Vec3};
use pelage_bake::noise::{hash, uniform};
use pelage_bake::stages::simulate::Strands;
use pelage_bake::strands::{PosedMesh, PosedVertex};
use pelage_formats::Shading;
use pelage_formats::meaning::tile_axes_f64;
use std::f64::consts::PI;

/// A light of a ray-traced picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TrueLight {
    /// Distant light with one direction everywhere.
    Directional {
        /// Direction towards the light, of any length above 0.
        towards_light_ws: Vec3,
        /// Linear RGB.
        color: Vec3,
    },
    /// Light at one position. It does not fall off with distance.
    Point {
        /// Position in world space, metres.
        position_ws: Vec3,
        /// Linear RGB.
        color: Vec3,
    },
}

impl TrueLight {
    pub(super) fn color(&self) -> DVec3 {
        match *self {
            Self::Directional { color, .. } | Self::Point { color, .. } => color.as_dvec3(),
        }
    }

    /// Returns the unit direction from a point towards the middle of the light, and its distance, metres.
    pub(super) fn direction_and_distance(&self, point_ws: DVec3) -> (DVec3, f64) {
        match *self {
            Self::Directional { towards_light_ws, .. } => {
                (towards_light_ws.as_dvec3().normalize_or(DVec3::Y), f64::INFINITY)
            }
            Self::Point { position_ws, .. } => {
                let way = position_ws.as_dvec3() - point_ws;
                (way.normalize_or(DVec3::Y), way.length())
            }
        }
    }
}

/// Lighting of fur and surface.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueLighting {
    /// Light that casts shadows; ambient light has its colour.
    pub key: TrueLight,
    /// Width of a penumbra divided by the distance from the occluder, 0..: the key light is a disc of that size. Each
    /// sample's shadow ray goes to a random point of the disc. The equation uses the direction to its centre.
    pub penumbra: f64,
    /// Further lights. They cast shadows of strands only if `fill_shadows` is set.
    pub fill: Vec<TrueLight>,
    /// Whether ambient light fades towards the roots: γ.
    pub ambient_attenuation: bool,
    /// Whether light fades on the side of the body away from the light: Attenu_Back.
    pub back_attenuation: bool,
    /// Whether strands cast shadows from the key light.
    pub hair_shadows: bool,
    /// Whether strands cast shadows from the fill lights. The mesh surface never does.
    pub fill_shadows: bool,
    /// Whether the mesh surface casts shadows from the key light.
    pub skin_shadows: bool,
    /// Whether highlights on bare surface are compressed, for pictures that show nothing else.
    ///
    /// If F is more than 1, the light is divided by 1 + L (F − 1) / F, so that a white surface is at most 1. L is the
    /// strongest channel of the light. F is that of all lights together when they shine from straight above.
    pub rolled_off: bool,
    /// Scattering between hairs, traced along light paths; replaces Yang's equation. Attenuations, and constants other
    /// than ka, are then unused.
    pub scattering: Option<TrueScattering>,
    /// Environment map; replaces ambient light. Strands and mesh surface cast shadows from it.
    pub sky: Option<TrueSky>,
}

impl TrueLighting {
    /// Returns the lighting of the papers: one light, with all shadows and attenuations.
    pub fn of(key: TrueLight) -> Self {
        Self {
            key,
            penumbra: 0.0,
            fill: Vec::new(),
            ambient_attenuation: true,
            back_attenuation: true,
            hair_shadows: true,
            fill_shadows: true,
            skin_shadows: true,
            rolled_off: false,
            scattering: None,
            sky: None,
        }
    }
}

/// Shading constants and root directions of a tile, for dry and for wet hair.
pub(super) struct TileShading {
    pub(super) dry: Shading,
    pub(super) wet: Shading,
    /// Root directions of dry and of wet hair, in the tile's frame.
    pub(super) roots: [Vec<DVec3>; 2],
    /// Colour of the undercoat, dry and wet.
    pub(super) root_colors: [DVec3; 2],
}

/// Returns the directions of all strands of a tile at their roots, unit length, in the tile's frame.
pub(super) fn root_directions(strands: &Strands) -> Vec<DVec3> {
    let direction = |i: usize| match strands.points[strands.range(i)] {
        [root, next, ..] => (next - root).as_dvec3().try_normalize(),
        _ => None,
    };
    (0..strands.len()).filter_map(direction).collect()
}

/// A light sample: scene, lighting, and seed of its random numbers.
pub(super) struct Sample<'a> {
    pub(super) tracer: &'a Tracer,
    pub(super) material: &'a TileShading,
    pub(super) lighting: &'a TrueLighting,
    /// Seed of all random numbers of this sample.
    pub(super) seed: u64,
    /// Seed of the pixel, and number of the sample in it.
    pub(super) of_pixel: (u64, u32),
}

/// Properties of a hair at the shaded point.
struct HairSample {
    color: DVec3,
    tangent: DVec3,
    height: f64,
    normal: DVec3,
    wet: bool,
}

impl Sample<'_> {
    /// Returns the linear RGB radiance from `hit` at `place_ws` towards the eye. Adds to `shadow_rays`.
    pub(super) fn light(&self, hit: &Hit, place_ws: DVec3, to_eye: DVec3, shadow_rays: &mut u64) -> DVec3 {
        if let Some(scattering) = &self.lighting.scattering {
            return self.path(scattering, hit, place_ws, to_eye, shadow_rays);
        }
        match *hit {
            Hit::Hair { point, share, strand } => {
                let points = &self.tracer.curves.points;
                let (a, b) = (&points[point], &points[point + 1]);
                let hair = HairSample {
                    color: a.color.as_dvec3().lerp(b.color.as_dvec3(), share),
                    tangent: (b.position_ws.as_dvec3() - a.position_ws.as_dvec3()).normalize_or_zero(),
                    height: f64::from(a.height) + f64::from(b.height - a.height) * share,
                    normal: a.normal_ws.as_dvec3().lerp(b.normal_ws.as_dvec3(), share).normalize_or_zero(),
                    wet: self.tracer.curves.wet[strand as usize],
                };
                let start = RayOrigin { strand: Some(strand), triangle: None };
                let visible = self.visibility(place_ws, start, shadow_rays);
                self.hair(&hair, place_ws, to_eye, visible, start)
            }
            Hit::Skin { triangle, weights, front } => {
                self.skin(triangle, weights, front, place_ws, to_eye, shadow_rays)
            }
        }
    }

    fn skin(
        &self,
        triangle: usize,
        weights: DVec3,
        front: bool,
        place_ws: DVec3,
        to_eye: DVec3,
        shadow_rays: &mut u64,
    ) -> DVec3 {
        let skin = &self.tracer.skin;
        let base = skin.base_color(triangle, weights);
        let [base, hair_base] = [base, skin.hair_base(triangle, base)].map(|c| c.truncate().as_dvec3());
        let [normal, tangent, bitangent] = frame(skin, triangle, weights);
        let side = if front { 1.0 } else { -1.0 };
        let start = RayOrigin { strand: None, triangle: Some(triangle) };
        let visible = self.visibility(place_ws, start, shadow_rays);
        let bare_normal = bare_normal(skin, triangle, weights) * side;
        let gloss = skin.material(triangle).gloss.map(|of| GlossyPoint::new(&of, base, bare_normal, to_eye));
        let bare = self.bare(base, bare_normal, gloss, place_ws, visible, start);
        if !self.has_undercoat(triangle) {
            return bare;
        }
        let (coat, wetness) = self.undercoat(triangle, weights);
        let wet = self.random(2) < wetness;
        let roots = &self.material.roots[usize::from(wet)];
        let root = roots[((self.random(3) * roots.len() as f64) as usize).min(roots.len() - 1)];
        let undercoat = HairSample {
            color: hair_base * self.material.root_colors[usize::from(wet)],
            tangent: tangent * root.x + bitangent * root.y + normal * root.z,
            height: 0.0,
            normal: normal * side,
            wet,
        };
        bare.lerp(self.hair(&undercoat, place_ws, to_eye, visible, start), coat)
    }

    fn has_undercoat(&self, triangle: usize) -> bool {
        self.tracer.skin.material(triangle).furred && !self.material.roots[0].is_empty()
    }

    /// Returns the fraction of a surface point that the undercoat covers, and the wet fraction of that, 0..=1.
    pub(super) fn undercoat(&self, triangle: usize, weights: DVec3) -> (f64, f64) {
        if !self.has_undercoat(triangle) {
            return (0.0, 0.0);
        }
        let skin = &self.tracer.skin;
        let groom = skin.groom(triangle, weights).as_dvec2();
        let corners = skin.corners(triangle).map(|c| if c.fur_height_m > 0.0 { 1.0 } else { 0.0 });
        let coat = weights.dot(DVec3::from(corners)) * groom.x;
        (coat, if self.material.roots[1].is_empty() { 0.0 } else { groom.y })
    }

    fn hair(&self, hair: &HairSample, place_ws: DVec3, to_eye: DVec3, visible: f64, start: RayOrigin) -> DVec3 {
        let k = if hair.wet { &self.material.wet } else { &self.material.dry };
        let lighting = self.lighting;
        let floor = if lighting.ambient_attenuation { f64::from(k.ambient_floor) } else { 1.0 };
        let gamma = floor + (1.0 - floor) * hair.height;
        let mut sum = vector(k.ambient) * gamma * hair.color * self.ambient();
        let past_strands = |light: &TrueLight| {
            let (towards, distance) = light.direction_and_distance(place_ws);
            f64::from(self.tracer.is_lit(place_ws, towards, distance, start, (lighting.fill_shadows, false)))
        };
        let fills = lighting.fill.iter().map(|light| (light, past_strands(light)));
        let sky = self.sample_sky(place_ws, start);
        let sky = sky.iter().map(|(light, visible)| (light, *visible));
        for (light, visible) in std::iter::once((&lighting.key, visible)).chain(fills).chain(sky) {
            let (towards, _) = light.direction_and_distance(place_ws);
            let half = (towards + to_eye).normalize_or_zero();
            let sine = |to: DVec3| (1.0 - hair.tangent.dot(to).powi(2)).clamp(0.0, 1.0).sqrt();
            let diffuse = vector(k.diffuse) * hair.color * sine(towards).powf(f64::from(k.diffuse_exponent));
            let specular = vector(k.specular) * sine(half).powf(f64::from(k.specular_exponent));
            let back = if lighting.back_attenuation {
                (hair.normal.dot(towards) / f64::from(k.back_light_range).max(1e-4) + 1.0).clamp(0.0, 1.0)
            } else {
                1.0
            };
            sum += (diffuse + specular) * back * visible * light.color();
        }
        sum
    }

    /// Returns the ambient light.
    fn ambient(&self) -> DVec3 {
        if self.lighting.sky.is_some() { DVec3::ZERO } else { self.lighting.key.color() }
    }

    /// Returns a light in one random direction that represents the environment map, and its visibility, 1 or 0.
    fn sample_sky(&self, place_ws: DVec3, start: RayOrigin) -> Option<(TrueLight, f64)> {
        let sky = self.lighting.sky.as_ref()?;
        let (way, radiance, likely) = sky.sample([self.random(4), self.random(5)])?;
        // A light of colour 1 causes an irradiance of π.
        let color = (radiance / (likely * std::f64::consts::PI)).as_vec3();
        let visible = self.tracer.is_lit(place_ws, way, f64::INFINITY, start, (true, true));
        Some((TrueLight::Directional { towards_light_ws: way.as_vec3(), color }, f64::from(visible)))
    }

    fn bare(
        &self,
        color: DVec3,
        normal: DVec3,
        gloss: Option<GlossyPoint>,
        place_ws: DVec3,
        visible: f64,
        start: RayOrigin,
    ) -> DVec3 {
        let k = &self.material.dry;
        let key = self.lighting.key;
        let mut full = vector(k.ambient) * self.ambient();
        // A sample of the mirrored directions estimates the share of ambient light that is mirrored.
        let mirrored = gloss.map(|point| {
            let way = point.sample([self.random(6), self.random(7)]);
            (point, way, point.value(way) / point.pdf(way).max(1e-12))
        });
        let (mut sum, mut mirrored) = match mirrored {
            Some((point, way, share)) => {
                let lit =
                    share.max_element() > 0.0 && self.tracer.is_lit(place_ws, way, f64::INFINITY, start, (true, true));
                let sky = self.lighting.sky.as_ref().map_or(full, |sky| vector(k.diffuse) * sky.radiance(way));
                let mirrored = if lit { share * sky } else { DVec3::ZERO };
                (full * (DVec3::ONE - share) * point.scattering(), mirrored)
            }
            None => (full, DVec3::ZERO),
        };
        let sky = self.sample_sky(place_ws, start);
        let sky = sky.iter().map(|(light, visible)| (light, *visible));
        let lights = std::iter::once((&key, visible)).chain(self.lighting.fill.iter().map(|l| (l, 1.0))).chain(sky);
        // The sky, which is last, is mirrored above.
        let without_size = 1 + self.lighting.fill.len();
        for (i, (light, visible)) in lights.enumerate() {
            let way = light.direction_and_distance(place_ws).0;
            let light = vector(k.diffuse) * light.color();
            let enters = gloss.map_or(DVec3::ONE, |point| point.enters(way));
            sum += light * enters * normal.dot(way).max(0.0) * visible;
            if let Some(point) = gloss.filter(|_| i < without_size) {
                mirrored += light * point.value_of_light(way) * (visible * PI);
            }
            full += light;
        }
        let full = full.max_element();
        let rolled = if self.lighting.rolled_off && full > 1.0 { sum.max_element() * (full - 1.0) / full } else { 0.0 };
        let scattered = color * sum / (1.0 + rolled);
        if !self.lighting.rolled_off {
            return scattered + mirrored;
        }
        // Highlights fill the range that the scattered light leaves.
        scattered + mirrored / (1.0 + mirrored.max_element()) * (DVec3::ONE - scattered).max(DVec3::ZERO)
    }

    /// Returns the visibility of the point of the key light that this sample chose: 1 or 0.
    fn visibility(&self, place_ws: DVec3, start: RayOrigin, shadow_rays: &mut u64) -> f64 {
        let past = (self.lighting.hair_shadows, self.lighting.skin_shadows);
        if past == (false, false) {
            return 1.0;
        }
        *shadow_rays += 1;
        let (axis, distance) = self.lighting.key.direction_and_distance(place_ws);
        let way = self.on_disc(axis, DVec2::new(self.random(0), self.random(1)));
        let reach = distance / axis.dot(way);
        f64::from(self.tracer.is_lit(place_ws, way, reach, start, past))
    }

    /// Returns the direction to a point of the key light's disc, whose centre is along `axis`. `even`: two uniform
    /// numbers in 0..1 that select the point.
    pub(super) fn on_disc(&self, axis: DVec3, even: DVec2) -> DVec3 {
        let (side, up) = axis.any_orthonormal_pair();
        let on_disc = disc(even) * (0.5 * self.lighting.penumbra);
        (axis + side * on_disc.x + up * on_disc.y).normalize_or(axis)
    }

    /// Returns the random number with index `what` of this sample, uniform in 0..1.
    fn random(&self, what: u64) -> f64 {
        f64::from(uniform(hash(self.seed, 0x71a5), what))
    }
}

/// Returns normal, tangent and bitangent of the mesh surface at a point, world space, unit length.
pub(super) fn frame(skin: &PosedMesh, triangle: usize, weights: DVec3) -> [DVec3; 3] {
    let corners = skin.corners(triangle);
    let sum = |of: [DVec3; 3]| of[0] * weights.x + of[1] * weights.y + of[2] * weights.z;
    let normal = sum(corners.map(|c| c.normal_ws)).normalize_or(corners[0].normal_ws);
    let [tangent, across] = tile_axes_f64(normal, sum(corners.map(|c| c.tangent_ws)), 1.0);
    let handed = across.dot(corners[0].bitangent_ws);
    [normal, tangent, if handed < 0.0 { -across } else { across }]
}

/// Returns the normal by which bare surface is lit at a point, world space, unit length.
pub(super) fn bare_normal(skin: &PosedMesh, triangle: usize, weights: DVec3) -> DVec3 {
    let [a, b, c] = skin.corners(triangle).map(PosedVertex::bare_normal_ws);
    (a * weights.x + b * weights.y + c * weights.z).normalize_or(a)
}

pub(super) fn vector(k: [f32; 3]) -> DVec3 {
    Vec3::from(k).as_dvec3()
}
