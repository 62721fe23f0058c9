//! What a fibre does to light that comes from all around it, or goes there: numbers instead of a table.

use super::optics::LEAST_COS_D;
use super::{Fibre, PATHS};
use core::array::from_fn;
use core::f64::consts::PI;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// What is absorbed a radius where mean lengths are right.
pub const REFERENCE_SIGMA: f64 = 0.5;
/// Angles that the numbers are fitted at, and azimuths of each.
const ROWS: usize = 24;
const PHIS: usize = 48;

/// Numbers of a fibre that tables need not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Means {
    /// How far aside of the fibre's middle light falls on it that is reflected within: mean of the square, over that of the radius, 0..=1. How far it goes each
    /// time it crosses the fibre follows ([`Means::left`]): light reflected once within (TRT) crosses it twice, and all other light is taken to cross it
    /// three times. Of light gone through (TT) the tables know it by the azimuth.
    pub aside: f32,
    /// The share of light that goes on, on the far side of the fibre, without absorption, of R, TT, TRT and all other light: the first, and the second times
    /// (1 − cos θ)², and the third times (1 − cos θ)⁴, of the light's angle θ to the plane across the fibre.
    pub on: [[f32; PATHS]; 3],
    /// The share that comes back, the same way.
    pub back: [[f32; PATHS]; 3],
}

/// Squares of 1 / cos θt and of 1 / η′ of light at an angle of that cosine to the plane across the fibre.
fn bent(cos_theta: f64, eta: f64) -> [f64; 2] {
    let cos = cos_theta.max(LEAST_COS_D);
    let (square, per_eta) = (cos * cos, 1.0 / (eta * eta));
    let slant = 1.0 / (1.0 - (1.0 - square) * per_eta);
    [slant, square * per_eta * slant]
}

/// 1, (1 − cos θ)² and its square.
fn basis(cos_theta: f64) -> DVec3 {
    let u = 1.0 - cos_theta.max(LEAST_COS_D);
    DVec3::new(1.0, u * u, u * u * u * u)
}

impl Means {
    /// Share of light that was reflected within more than once, of all that was reflected within and comes out.
    pub fn often(&self) -> f64 {
        let of = |path: usize| f64::from(self.on[0][path] + self.back[0][path]);
        of(3) / (of(2) + of(3)).max(1e-6)
    }

    /// Those of a fibre: fitted by least squares, the shares so that none is lost without absorption.
    pub fn new(fibre: &Fibre) -> Self {
        let phis: Vec<f64> = (0..PHIS).map(|i| PI * i as f64 / (PHIS - 1) as f64).collect();
        // Of TRT: sum of squares of how far aside it falls in, by their light, and of light.
        let (mut asides, mut light) = (0.0, 0.0);
        let mut matrix = DMat3::ZERO;
        let mut sums = [[DVec3::ZERO; PATHS]; 2];
        for row in 0..ROWS {
            let cos = LEAST_COS_D + (1.0 - LEAST_COS_D) * row as f64 / (ROWS - 1) as f64;
            let section = fibre.section(cos);
            let mut sides = [[0.0; PATHS]; 2];
            for p in 0..3 {
                let ways = section.mean_ways(p, &phis, REFERENCE_SIGMA);
                let [back, on] = halves(&ways.iter().map(|way| way.light).collect::<Vec<_>>());
                (sides[0][p as usize], sides[1][p as usize]) = (on, back);
                if p == 2 {
                    for way in ways {
                        let [slant, per_across] = bent(cos, fibre.eta);
                        // Directions along the fibre are few.
                        let weight = way.light * cos;
                        asides += weight * (1.0 - way.length * way.length / (16.0 * slant)) / per_across;
                        light += weight;
                    }
                }
            }
            for side in &mut sides {
                side[3] = PI * section.rest(0.0);
            }
            let all: f64 = sides.as_flattened().iter().sum();
            let at = basis(cos);
            matrix += DMat3::from_cols(at * at.x, at * at.y, at * at.z);
            for (sum, share) in sums.as_flattened_mut().iter_mut().zip(sides.as_flattened()) {
                *sum += at * (share / all);
            }
        }
        // All shares have one basis, which has the constant: that their sum is 1 outlives the fit.
        let solved = sums.map(|of| of.map(|sum| matrix.inverse() * sum));
        let numbers = |of: [DVec3; PATHS]| from_fn(|k| from_fn(|p| of[p][k] as f32));
        Self {
            aside: if light > 0.0 { (asides / light).clamp(0.0, 1.0) as f32 } else { 0.0 },
            on: numbers(solved[0]),
            back: numbers(solved[1]),
        }
    }

    /// What a fibre that absorbs `sigma` a radius leaves of light that crosses it once, where θd has that cosine.
    pub fn left(&self, cos_d: f64, eta: f64, sigma: f64) -> f64 {
        let [slant, per_across] = bent(cos_d, eta);
        libm::exp(-2.0 * sigma * (slant * (1.0 - f64::from(self.aside) * per_across)).sqrt())
    }

    /// Of light at an angle of that cosine to the plane across the fibre, the share that goes on and the share that comes back, where `sigma` is absorbed a radius.
    pub fn sides(&self, cos_theta: f64, eta: f64, sigma: [f64; 3]) -> [[f64; 3]; 2] {
        let at = basis(cos_theta);
        [&self.on, &self.back].map(|of| {
            let share = |p: usize| DVec3::from_array(from_fn(|k| f64::from(of[k][p]))).dot(at);
            sigma.map(|sigma| {
                let left = self.left(cos_theta, eta, sigma);
                share(0) + left * (share(1) + left * (share(2) + left * share(3)))
            })
        })
    }

    /// What is wrong with it, if anything is: numbers that no fibre has.
    pub fn fault(&self) -> Option<String> {
        if !(0.0..=1.0).contains(&self.aside) {
            return Some(format!("aside is {}, expected 0 to 1", self.aside));
        }
        let of = [("on", &self.on), ("back", &self.back)];
        let all = of.into_iter().flat_map(|(name, of)| of.as_flattened().iter().map(move |x| (name, x)));
        let outside = all.into_iter().find(|(_, x)| !(-10.0..=10.0).contains(*x));
        outside.map(|(name, found)| format!("{name} holds {found}, expected -10 to 10"))
    }
}

/// Integrals of an even function of φ over the half of the turn about φ = 0, and over the other half, from its values evenly from 0 to π.
fn halves(values: &[f64]) -> [f64; 2] {
    let step = PI / (values.len() - 1) as f64;
    let at = |phi: f64| {
        let place = phi / step;
        let below = (place as usize).min(values.len() - 2);
        values[below] + (values[below + 1] - values[below]) * (place - below as f64)
    };
    // Trapezia over both quarters, each of as many as there are values.
    let pieces = values.len();
    let quarter = |from: f64| {
        let width = 0.5 * PI / pieces as f64;
        (0..pieces)
            .map(|i| 0.5 * width * (at(from + width * i as f64) + at(from + width * (i + 1) as f64)))
            .sum::<f64>()
    };
    [2.0 * quarter(0.0), 2.0 * quarter(0.5 * PI)]
}
