//! Fibre at close range: light meets it at a known offset from its axis, as in path tracing (Chiang 2016, also in the
//! renderers pbrt and Mitsuba).
//!
//! Averaged over all offsets, the result equals that of the distant fibre, except for the angle of the cross-section:
//! the eye's angle θo instead of θd. On the cone of a smooth fibre, both angles agree. With θo, no light is lost or
//! gained at any angle.

use super::azimuthal::{Logistic, wrapped};
use super::optics::Section;
use super::{Angles, Fibre, PATHS, SCATTERED};
use core::array::from_fn;
use core::f64::consts::{PI, TAU};

/// Intersection of an eye ray with a fibre.
#[derive(Clone, Copy, Debug)]
pub struct FibreHit<'a> {
    fibre: &'a Fibre,
    scale: f64,
    logistic: Logistic,
    to: (f64, f64),
    /// Exit azimuths of the paths, relative to the eye.
    ends: [f64; 3],
    /// Share of the light on each path, for each colour.
    shares: [[f64; 3]; PATHS + 1],
    /// Probability of sampling each path.
    chances: [f64; PATHS + 1],
}

/// Sampled direction of incident light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledDirection {
    /// Sine and cosine of θi.
    pub from: (f64, f64),
    /// Azimuth of the light, relative to the eye.
    pub phi: f64,
    /// Light scattered from the sampled direction, times cos θi, divided by the probability density of the sample.
    pub weight: [f64; 3],
}

impl<'a> FibreHit<'a> {
    /// Creates an intersection with a fibre of azimuthal roughness `scale`, radians.
    ///
    /// * `sigma`: absorption per radius, 0 or more
    /// * `offset`: distance from the axis divided by the radius, −1..=1, positive towards increasing azimuths
    /// * `to`: sine and cosine of θo
    pub fn new(fibre: &'a Fibre, scale: f64, sigma: [f64; 3], offset: f64, to: (f64, f64)) -> Self {
        let section = Section { medulla: fibre.medulla, ..Section::new(fibre.eta, to.1) };
        let gamma = libm::asin(offset.clamp(-1.0, 1.0));
        let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
        let (reflected, chord) = (section.fresnel(cos), section.chord(sin));
        let within = (1.0 - reflected) * (1.0 - reflected);
        let remains = sigma.map(|sigma| libm::exp(-sigma * chord));
        let (unscattered, scattered) = (section.unscattered(sin), section.scattered(sin, cos));
        let through = remains.map(|remains| remains * unscattered);
        let shares = [
            [reflected; 3],
            through.map(|t| within * t),
            through.map(|t| within * reflected * t * t),
            through.map(|t| section.rest(reflected, t)),
            remains.map(|t| scattered * t * t),
        ];
        let sums = shares.map(|of| of.iter().sum::<f64>());
        let whole: f64 = sums.iter().sum();
        let ends = from_fn(|p| wrapped(section.deviation(p as u32, gamma) + p as f64 * PI));
        Self { fibre, scale, logistic: Logistic::new(scale), to, ends, shares, chances: sums.map(|sum| sum / whole) }
    }

    /// Returns the probability density with which path `p` scatters into directions of light. It is the path's lobe
    /// about the cone times its distribution about the exit azimuth.
    fn spread(&self, p: usize, from: (f64, f64), phi: f64) -> f64 {
        let along = self.fibre.path_along(p as u32, &Angles { from, to: self.to, phi });
        along * self.ends.get(p).map_or(1.0 / TAU, |end| self.logistic.density(wrapped(phi - end)))
    }

    /// Returns the light scattered towards the eye from a direction, times cos θi, for each colour. Also returns the
    /// probability density of sampling that direction, per steradian.
    pub fn value(&self, from: (f64, f64), phi: f64) -> ([f64; 3], f64) {
        let (mut sum, mut chance) = ([0.0; 3], 0.0);
        for p in 0..=SCATTERED {
            let spread = self.spread(p, from, phi);
            chance += self.chances[p] * spread;
            for (sum, share) in sum.iter_mut().zip(self.shares[p]) {
                *sum += share * spread;
            }
        }
        (sum, chance)
    }

    /// Samples a direction from four uniform numbers in 0..1.
    pub fn sample(&self, [path, around, height, turn]: [f64; 4]) -> SampledDirection {
        let (mut p, mut left) = (0, path);
        while p < SCATTERED && left >= self.chances[p] {
            left -= self.chances[p];
            p += 1;
        }
        let sin_i = if p == SCATTERED {
            // Coordinate of a point that is uniformly distributed over the unit disc.
            height.sqrt() * libm::cos(TAU * turn)
        } else {
            let spread = self.fibre.spread(p as u32);
            let (sin_o, cos_o) = spread.tilted(self.to);
            let v = spread.variance();
            // d'Eon's lobe is a distribution about a direction, and depends only on the cosine to it.
            let height = height.max(1e-300);
            let cos = 1.0 + v * libm::log(height + (1.0 - height) * libm::exp(-2.0 / v));
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            (-cos * sin_o + sin * libm::cos(TAU * turn) * cos_o).clamp(-1.0, 1.0)
        };
        let from = (sin_i, (1.0 - sin_i * sin_i).max(0.0).sqrt());
        let phi = match self.ends.get(p) {
            Some(end) => wrapped(end + sample_logistic(self.scale, around)),
            None => TAU * around - PI,
        };
        let (value, chance) = self.value(from, phi);
        SampledDirection { from, phi, weight: if chance > 0.0 { value.map(|x| x / chance) } else { [0.0; 3] } }
    }
}

/// Samples [`logistic`] from a uniform number in 0..1.
fn sample_logistic(scale: f64, even: f64) -> f64 {
    let below = 1.0 / (1.0 + libm::exp(PI / scale));
    let share = (below + even * (1.0 - 2.0 * below)).clamp(1e-300, 1.0 - 1e-16);
    (-scale * libm::log(1.0 / share - 1.0)).clamp(-PI, PI)
}
