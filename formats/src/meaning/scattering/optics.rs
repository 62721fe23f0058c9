//! Optics of a smooth dielectric cylinder: refraction, reflection and absorption (Marschner 2003, section 4), and
//! scattering by a core in it (after Yan 2015).

use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// Minimum cosine of the difference angle θd, because lobes are divided by its square. Light closer to the fibre's
/// direction is treated as if it had this cosine.
pub const LEAST_COS_D: f64 = 0.1;

/// Medulla: core of a fibre that scatters light evenly in all directions (after the double cylinder of Yan 2015).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Medulla {
    /// Radius of the medulla divided by that of the fibre, [`Medulla::RATIO`]; 0 for none.
    pub ratio: f32,
    /// Scattering coefficient per radius of the fibre, [`Medulla::SCATTERING`]. A medulla that scatters mostly forward,
    /// with a mean cosine g, counts as 1 − g times its coefficient.
    pub scattering: f32,
}

impl Medulla {
    /// No medulla.
    pub const NONE: Self = Self { ratio: 0.0, scattering: 0.0 };
    /// Range of the ratio of radii.
    pub const RATIO: RangeInclusive<f32> = 0.0..=0.95;
    /// Range of the scattering coefficient.
    pub const SCATTERING: RangeInclusive<f32> = 0.0..=10.0;

    /// Returns whether the medulla scatters any light.
    pub fn scatters(&self) -> bool {
        self.ratio > 0.0 && self.scattering > 0.0
    }
}

/// Cross-section of a fibre for light at one difference angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Section {
    /// Index of refraction, above 1.
    pub eta: f64,
    /// Cosine of the difference angle θd, [`LEAST_COS_D`]..=1.
    pub cos_d: f64,
    /// Effective index of refraction in the normal plane of the fibre: η′ = √(η² − sin²θd) / cos θd.
    pub across: f64,
    /// Cosine of the refracted inclination θt: angle inside the fibre between ray and normal plane.
    pub cos_t: f64,
    /// Medulla of the fibre.
    pub medulla: Medulla,
}

impl Section {
    /// Creates the cross-section of a fibre of refractive index `eta`, above 1, without medulla, for light at the
    /// difference angle with cosine `cos_d`, clamped to at least [`LEAST_COS_D`].
    pub fn new(eta: f64, cos_d: f64) -> Self {
        let cos_d = cos_d.clamp(LEAST_COS_D, 1.0);
        let under = (eta * eta - (1.0 - cos_d * cos_d)).max(0.0).sqrt();
        Self { eta, cos_d, across: under / cos_d, cos_t: under / eta, medulla: Medulla::NONE }
    }

    /// Returns the reflectance for unpolarised light, 0..=1. `cos_gamma` is the cosine of the angle of incidence in the
    /// normal plane of the fibre. Light from inside has the same reflectance.
    pub fn fresnel(&self, cos_gamma: f64) -> f64 {
        // Use the angle of incidence in space. With the angle in the normal plane, the component polarised along that
        // plane would need another effective index. This would give it another angle of refraction.
        let c = self.cos_d * cos_gamma;
        let t = (1.0 - (1.0 - c * c) / (self.eta * self.eta)).max(0.0).sqrt();
        let of = |a: f64, b: f64| if a + b > 0.0 { (a - b) / (a + b) } else { 1.0 };
        let (s, p) = (of(c, self.eta * t), of(self.eta * c, t));
        0.5 * (s * s + p * p)
    }

    /// Returns sine and cosine of the angle of refraction in the normal plane; `sin_gamma` is the sine of the angle of
    /// incidence there.
    pub fn refracted(&self, sin_gamma: f64) -> (f64, f64) {
        let sin = (sin_gamma / self.across).clamp(-1.0, 1.0);
        (sin, (1.0 - sin * sin).max(0.0).sqrt())
    }

    /// Returns the path length of one crossing of the fibre, in radii.
    pub fn chord(&self, sin_gamma: f64) -> f64 {
        2.0 * self.refracted(sin_gamma).1 / self.cos_t
    }

    /// Returns the share of light that one crossing of the fibre does not scatter in the medulla.
    pub fn unscattered(&self, sin_gamma: f64) -> f64 {
        let (from_axis, ratio) = (self.refracted(sin_gamma).0, f64::from(self.medulla.ratio));
        let square = ratio * ratio - from_axis * from_axis;
        let chord = 2.0 * square.max(0.0).sqrt() / self.cos_t;
        libm::exp(-f64::from(self.medulla.scattering) * chord)
    }

    /// Returns the share of the light that the medulla scatters at any crossing, without absorption.
    pub fn scattered(&self, sin_gamma: f64, cos_gamma: f64) -> f64 {
        let (reflected, left) = (self.fresnel(cos_gamma), self.unscattered(sin_gamma));
        // At grazing incidence, no light enters.
        if reflected * left >= 1.0 { 0.0 } else { (1.0 - reflected) * (1.0 - left) / (1.0 - reflected * left) }
    }

    /// Returns the share of the light that leaves after two or more internal reflections. `reflected` is the
    /// reflectance; `through` is the share of light that remains after a crossing, neither absorbed nor scattered.
    pub fn rest(&self, reflected: f64, through: f64) -> f64 {
        let within = (1.0 - reflected) * (1.0 - reflected);
        let again = reflected * through;
        // At grazing incidence, no light enters.
        if again >= 1.0 { 0.0 } else { within * reflected * reflected * through * through * through / (1.0 - again) }
    }

    /// Returns the share of the light that leaves on path `p` (0: reflected, 1: transmitted, 2: reflected once inside),
    /// without the absorption exp(−σ p chord).
    pub fn share(&self, p: u32, cos_gamma: f64) -> f64 {
        let f = self.fresnel(cos_gamma);
        let left = self.unscattered((1.0 - cos_gamma * cos_gamma).max(0.0).sqrt());
        match p {
            0 => f,
            1 => (1.0 - f) * (1.0 - f) * left,
            _ => (1.0 - f) * (1.0 - f) * f * left * left,
        }
    }
}
