//! Gloss of bare surface: the GGX distribution with Smith's height-correlated shadowing (Walter 2007, Heitz 2014) and
//! Schlick's Fresnel term.

use glam::DVec3;
use pelage_formats::Gloss;
use std::f64::consts::{PI, TAU};

/// Glossy point of a surface, and the direction to its eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlossyPoint {
    /// Reflectance at normal incidence.
    f0: DVec3,
    metalness: f64,
    /// Squared width of the distribution.
    alpha_squared: f64,
    normal: DVec3,
    to_eye: DVec3,
}

impl GlossyPoint {
    /// Returns the point with base colour `base`. `normal` is on the side of the eye.
    pub(super) fn new(of: &Gloss, base: DVec3, normal: DVec3, to_eye: DVec3) -> Self {
        let metalness = f64::from(of.metalness);
        let f0 = DVec3::splat(of.reflectance.into()).lerp(base, metalness);
        Self { f0, metalness, alpha_squared: f64::from(of.roughness).powi(4), normal, to_eye }
    }

    fn fresnel(&self, cosine: f64) -> DVec3 {
        self.f0 + (DVec3::ONE - self.f0) * (1.0 - cosine).clamp(0.0, 1.0).powi(5)
    }

    /// Returns the share of light from direction `way` that enters the surface and is scattered below it.
    pub(super) fn enters(&self, way: DVec3) -> DVec3 {
        let half = (way + self.to_eye).normalize_or(self.normal);
        (DVec3::ONE - self.fresnel(way.dot(half))) * self.scattering()
    }

    /// Returns the share of the light inside the surface that is not absorbed at once, as in metals.
    pub(super) fn scattering(&self) -> f64 {
        1.0 - self.metalness
    }

    /// Returns the reflection of light from direction `way` to the eye, per steradian, cosine included.
    pub(super) fn value(&self, way: DVec3) -> DVec3 {
        self.with_width(way, self.alpha_squared)
    }

    /// Returns the same for a light without size, which counts as one of [`Gloss::OF_LIGHTS`].
    pub(super) fn value_of_light(&self, way: DVec3) -> DVec3 {
        self.with_width(way, self.alpha_squared + f64::from(Gloss::OF_LIGHTS))
    }

    fn with_width(&self, way: DVec3, alpha_squared: f64) -> DVec3 {
        let (light, eye) = (self.normal.dot(way), self.normal.dot(self.to_eye));
        if light <= 0.0 || eye <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (way + self.to_eye).normalize_or(self.normal);
        let a = alpha_squared.min(1.0);
        let masked = |cosine: f64| (a + (1.0 - a) * cosine * cosine).sqrt();
        let shadowing = 0.5 / (light * masked(eye) + eye * masked(light));
        self.fresnel(way.dot(half)) * (distribution(self.normal.dot(half), a) * shadowing * light)
    }

    /// Returns the probability density with which [`Self::sample`] chooses the direction `way`, per steradian.
    pub(super) fn pdf(&self, way: DVec3) -> f64 {
        let half = (way + self.to_eye).normalize_or(self.normal);
        let cosine = self.normal.dot(half);
        if cosine <= 0.0 {
            return 0.0;
        }
        distribution(cosine, self.alpha_squared) * cosine / (4.0 * half.dot(self.to_eye)).max(1e-9)
    }

    /// Samples the direction of light that a facet mirrors to the eye. It may be below the surface.
    pub(super) fn sample(&self, even: [f64; 2]) -> DVec3 {
        let squared = (1.0 - even[0]) / (1.0 + (self.alpha_squared - 1.0) * even[0]);
        let (sin, turn) = ((1.0 - squared).max(0.0).sqrt(), TAU * even[1]);
        let (side, up) = self.normal.any_orthonormal_pair();
        let half = side * (sin * libm::cos(turn)) + up * (sin * libm::sin(turn)) + self.normal * squared.sqrt();
        half * (2.0 * half.dot(self.to_eye)) - self.to_eye
    }
}

/// Returns the GGX distribution of facet normals, per steradian. `cosine`: between facet and surface.
fn distribution(cosine: f64, alpha_squared: f64) -> f64 {
    let spread = 1.0 - cosine * cosine * (1.0 - alpha_squared);
    alpha_squared / (PI * spread * spread)
}
