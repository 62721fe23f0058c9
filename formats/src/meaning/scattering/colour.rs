//! Absorption of a fibre, from its pigments or from the desired colour of fur made of such fibres.

use super::optics::Medulla;
use core::f64::consts::PI;

/// Absorption per radius, for red, green and blue, per unit of eumelanin. Hair is black with 8 units, brown with 1.3,
/// blond with 0.3 (d'Eon 2011, as in Chiang 2016).
pub const EUMELANIN: [f64; 3] = [0.419, 0.697, 1.37];
/// Absorption per radius, for red, green and blue, per unit of pheomelanin, which makes hair red.
pub const PHEOMELANIN: [f64; 3] = [0.187, 0.4, 1.05];
/// Darkest colour value that is distinguished from black, which would need infinite absorption.
pub const DARKEST: f64 = 1e-3;

/// Returns the absorption per radius of a fibre that contains the given units of pigment.
///
/// * `eumelanin`, `pheomelanin`: 0 or more
pub fn of_pigments(eumelanin: f64, pheomelanin: f64) -> [f64; 3] {
    core::array::from_fn(|i| eumelanin.max(0.0) * EUMELANIN[i] + pheomelanin.max(0.0) * PHEOMELANIN[i])
}

/// Returns the absorption per radius at which deep fur has colour `color` under light from all sides, after scattering
/// between hairs (Chiang 2016, section 4.2).
///
/// * `color`: linear, 0..=1; clamped to at least [`DARKEST`]
/// * `around`: scale of the azimuthal logistic distribution, radians
pub fn absorption(color: [f64; 3], around: f64) -> [f64; 3] {
    absorption_at(color, depth(around))
}

/// Returns the same as [`absorption`] for a fibre of known [`depth`], which is expensive to compute.
pub fn absorption_at(color: [f64; 3], depth: f64) -> [f64; 3] {
    color.map(|c| {
        let root = libm::log(c.clamp(DARKEST, 1.0)) / depth;
        root * root
    })
}

/// Returns the colour of deep fur, given the absorption of its fibres per radius. Inverse of the function
/// [`absorption`].
pub fn color(absorption: [f64; 3], around: f64) -> [f64; 3] {
    let depth = depth(around);
    absorption.map(|sigma| libm::exp(-depth * sigma.max(0.0).sqrt()))
}

/// Returns the factor that relates the darkening of deep fur to the square root of the absorption per radius. It
/// depends on the azimuthal roughness; the function is a fit of Chiang 2016.
///
/// * `around`: scale of the azimuthal logistic distribution, radians
pub fn depth(around: f64) -> f64 {
    let b = roughness(around);
    5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))))
}

/// Returns the factor on [`absorption`] that keeps the colour of deep fur although the fibres have a medulla, which
/// returns more light; 1 for no medulla.
///
/// * `around`: scale of the azimuthal logistic distribution, radians
pub fn medulla_absorption(medulla: &Medulla, around: f64) -> f64 {
    let [ratio, scattering] = [medulla.ratio, medulla.scattering].map(f64::from);
    // Share of the light that is scattered.
    let scattered = (1.6 * ratio).min(0.91) * -libm::expm1(-1.9 * ratio * scattering);
    let depth = depth(around);
    1.0 + scattered / (1.0 + scattered) * (depth * depth - 20.5) / 7.0
}

/// Returns the scale of the logistic distribution, radians, for a perceptually uniform roughness, 0..=1 (Chiang 2016,
/// eq. 8).
pub fn scale_of(roughness: f64) -> f64 {
    let b = roughness.clamp(0.0, 1.0);
    libm::sqrt(PI / 8.0) * (0.265 * b + 1.194 * b * b + 5.372 * libm::pow(b, 22.0))
}

/// Returns the roughness for a scale, 0..=1. Inverse of [`scale_of`].
pub fn roughness(scale: f64) -> f64 {
    inverse(scale_of, scale)
}

/// Returns the longitudinal roughness, 0..=1, at which the renderers pbrt-4 and Mitsuba 3 spread light by a standard
/// deviation of `deviation` radians (Chiang 2016, eq. 7).
pub fn roughness_along(deviation: f64) -> f64 {
    inverse(|b| 0.726 * b + 0.812 * b * b + 3.7 * libm::pow(b, 20.0), deviation)
}

/// Returns the argument in 0..=1 at which the increasing function `of` has the value `value`.
fn inverse(of: impl Fn(f64) -> f64, value: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if of(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
