//! What a fibre absorbs, from its pigments or from the colour that a coat of such fibres is to have.

use core::f64::consts::PI;

/// What a fibre absorbs a radius, red, green and blue, for each unit of eumelanin: black at 8, brown at 1.3, blond at 0.3 (d'Eon 2011, as Chiang 2016 has it).
pub const EUMELANIN: [f64; 3] = [0.419, 0.697, 1.37];
/// The same of pheomelanin, which makes hair red.
pub const PHEOMELANIN: [f64; 3] = [0.187, 0.4, 1.05];
/// The darkest colour that is told from black: a fibre that absorbs without bound has no number.
pub const DARKEST: f64 = 1e-3;

/// What a fibre with so much of both pigments absorbs a radius.
///
/// * `eumelanin`, `pheomelanin`: 0 or more
pub fn of_pigments(eumelanin: f64, pheomelanin: f64) -> [f64; 3] {
    core::array::from_fn(|i| eumelanin.max(0.0) * EUMELANIN[i] + pheomelanin.max(0.0) * PHEOMELANIN[i])
}

/// What fibres absorb a radius of which a deep coat has that colour under light from all sides, once light has gone from hair to hair (Chiang 2016, section 4.2).
///
/// * `color`: linear, 0..=1; what is less than [`DARKEST`] is that
/// * `around`: scale of the logistic distribution around the fibre, radians
pub fn absorption(color: [f64; 3], around: f64) -> [f64; 3] {
    let depth = depth(around);
    color.map(|c| {
        let root = libm::log(c.clamp(DARKEST, 1.0)) / depth;
        root * root
    })
}

/// The colour of a deep coat of fibres that absorb so much a radius: the inverse of [`absorption`].
pub fn color(absorption: [f64; 3], around: f64) -> [f64; 3] {
    let depth = depth(around);
    absorption.map(|sigma| libm::exp(-depth * sigma.max(0.0).sqrt()))
}

/// How fast a deep coat darkens with the root of what its fibres absorb a radius, by their roughness around: a fit of Chiang 2016.
///
/// * `around`: scale of the logistic distribution around the fibre, radians
pub fn depth(around: f64) -> f64 {
    let b = roughness(around);
    5.969 + b * (-0.215 + b * (2.532 + b * (-10.73 + b * (5.574 + b * 0.245))))
}

/// Scale of the logistic distribution of a roughness that looks even from 0 to 1 (Chiang 2016, eq. 8).
pub fn scale_of(roughness: f64) -> f64 {
    let b = roughness.clamp(0.0, 1.0);
    libm::sqrt(PI / 8.0) * (0.265 * b + 1.194 * b * b + 5.372 * libm::pow(b, 22.0))
}

/// The inverse of [`scale_of`], 0..=1.
pub fn roughness(scale: f64) -> f64 {
    inverse(scale_of, scale)
}

/// The roughness along a fibre for which the renderers pbrt-4 and Mitsuba 3 spread light by so many radians, a standard deviation (Chiang 2016, eq. 7), 0..=1.
pub fn roughness_along(deviation: f64) -> f64 {
    inverse(|b| 0.726 * b + 0.812 * b * b + 3.7 * libm::pow(b, 20.0), deviation)
}

/// Where in 0..=1 a growing function has that value.
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
