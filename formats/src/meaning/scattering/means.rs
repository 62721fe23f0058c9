//! Scattering of light that arrives from all directions, or leaves in all directions: a few numbers instead of a table.

use super::optics::LEAST_COS_D;
use super::{Fibre, PATHS};
use core::array::from_fn;
use core::f64::consts::PI;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Absorption per radius at which mean path lengths are exact.
pub const REFERENCE_SIGMA: f64 = 0.5;
/// Number of inclinations in the fit.
const ROWS: usize = 24;
/// Number of azimuths for each inclination in the fit.
const PHIS: usize = 48;

/// Properties of a fibre that need no table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FibreMeans {
    /// Mean squared offset from the axis, in squared radii, at which internally reflected light enters the fibre,
    /// 0..=1. It determines the length of each crossing ([`FibreMeans::transmittance`]). Light reflected once inside
    /// (TRT) or scattered by the medulla crosses twice; all further light is assumed to cross three times. The length
    /// of transmitted light (TT) is in the tables, by azimuth.
    pub aside: f32,
    /// Share of light that continues on the far side of the fibre, without absorption, for R, TT, TRT and all further
    /// light. Each row holds the coefficients of one basis function: 1, (1 − cos θ)² and (1 − cos θ)⁴, where θ is the
    /// light's inclination to the normal plane. Light that the medulla scatters counts as TRT.
    pub on: [[f32; PATHS]; 3],
    /// Share of light that returns on the near side, in the same form as `on`.
    pub back: [[f32; PATHS]; 3],
}

/// Returns 1 / cos² θt and 1 / η′² for light whose inclination to the normal plane has the cosine `cos_theta`.
fn bent(cos_theta: f64, eta: f64) -> [f64; 2] {
    let cos = cos_theta.max(LEAST_COS_D);
    let (square, per_eta) = (cos * cos, 1.0 / (eta * eta));
    let slant = 1.0 / (1.0 - (1.0 - square) * per_eta);
    [slant, square * per_eta * slant]
}

/// Returns the basis functions of the fit: 1, (1 − cos θ)² and (1 − cos θ)⁴.
fn basis(cos_theta: f64) -> DVec3 {
    let u = 1.0 - cos_theta.max(LEAST_COS_D);
    DVec3::new(1.0, u * u, u * u * u * u)
}

impl FibreMeans {
    /// Returns the share of light reflected inside more than once, relative to all internally reflected light that
    /// leaves.
    pub fn multiple_reflection_share(&self) -> f64 {
        let of = |path: usize| f64::from(self.on[0][path] + self.back[0][path]);
        of(3) / (of(2) + of(3)).max(1e-6)
    }

    /// Fits the properties of a fibre by least squares. Without absorption the shares sum to 1.
    pub fn new(fibre: &Fibre) -> Self {
        let phis: Vec<f64> = (0..PHIS).map(|i| PI * i as f64 / (PHIS - 1) as f64).collect();
        // For TRT and scattered light: the sum of squared entry offsets, weighted by light, and the sum of light.
        let (mut asides, mut light) = (0.0, 0.0);
        let mut matrix = DMat3::ZERO;
        let mut sums = [[DVec3::ZERO; PATHS]; 2];
        for row in 0..ROWS {
            let cos = LEAST_COS_D + (1.0 - LEAST_COS_D) * row as f64 / (ROWS - 1) as f64;
            let section = fibre.section(cos);
            let mut sides = [[0.0; PATHS]; 2];
            for p in 0..3 {
                let ways = section.mean_contributions(p, &phis, REFERENCE_SIGMA);
                let [back, on] = halves(&ways.iter().map(|way| way.light).collect::<Vec<_>>());
                (sides[0][p as usize], sides[1][p as usize]) = (on, back);
                if p == 2 {
                    for way in ways.into_iter().chain([section.mean_scattered(REFERENCE_SIGMA); PHIS]) {
                        let [slant, per_across] = bent(cos, fibre.eta);
                        // Weight by solid angle: directions close to the fibre's direction are few.
                        let weight = way.light * cos;
                        asides += weight * (1.0 - way.length * way.length / (16.0 * slant)) / per_across;
                        light += weight;
                    }
                }
            }
            for side in &mut sides {
                side[2] += PI * section.scattered(0.0);
                side[3] = PI * section.rest(0.0);
            }
            let all: f64 = sides.as_flattened().iter().sum();
            let at = basis(cos);
            matrix += DMat3::from_cols(at * at.x, at * at.y, at * at.z);
            for (sum, share) in sums.as_flattened_mut().iter_mut().zip(sides.as_flattened()) {
                *sum += at * (share / all);
            }
        }
        // All shares use the same basis, which contains a constant, so the fit preserves their sum of 1.
        let solved = sums.map(|of| of.map(|sum| matrix.inverse() * sum));
        let numbers = |of: [DVec3; PATHS]| from_fn(|k| from_fn(|p| of[p][k] as f32));
        Self {
            aside: if light > 0.0 { (asides / light).clamp(0.0, 1.0) as f32 } else { 0.0 },
            on: numbers(solved[0]),
            back: numbers(solved[1]),
        }
    }

    /// Returns the share of light that remains after one crossing of a fibre that absorbs `sigma` per radius; `cos_d`
    /// is cos θd.
    pub fn transmittance(&self, cos_d: f64, eta: f64, sigma: f64) -> f64 {
        let [slant, per_across] = bent(cos_d, eta);
        libm::exp(-2.0 * sigma * (slant * (1.0 - f64::from(self.aside) * per_across)).sqrt())
    }

    /// Returns the share of light that continues and the share that returns, for each colour. `cos_theta` is the cosine
    /// of the light's inclination to the normal plane; `sigma` is the absorption per radius.
    pub fn sides(&self, cos_theta: f64, eta: f64, sigma: [f64; 3]) -> [[f64; 3]; 2] {
        let at = basis(cos_theta);
        [&self.on, &self.back].map(|of| {
            let share = |p: usize| DVec3::from_array(from_fn(|k| f64::from(of[k][p]))).dot(at);
            sigma.map(|sigma| {
                let left = self.transmittance(cos_theta, eta, sigma);
                share(0) + left * (share(1) + left * (share(2) + left * share(3)))
            })
        })
    }

    /// Returns an error message if a value is out of its valid range.
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

/// Returns the integrals of an even function of φ over the half turn centred at φ = 0, and over the opposite half.
/// `values` are samples at evenly spaced φ from 0 to π.
fn halves(values: &[f64]) -> [f64; 2] {
    let step = PI / (values.len() - 1) as f64;
    let at = |phi: f64| {
        let place = phi / step;
        let below = (place as usize).min(values.len() - 2);
        values[below] + (values[below + 1] - values[below]) * (place - below as f64)
    };
    // The function is even, so each half turn is twice a quarter turn. Each quarter turn is integrated by the
    // trapezoidal rule, with as many intervals as there are values.
    let pieces = values.len();
    let quarter = |from: f64| {
        let width = 0.5 * PI / pieces as f64;
        (0..pieces)
            .map(|i| 0.5 * width * (at(from + width * i as f64) + at(from + width * (i + 1) as f64)))
            .sum::<f64>()
    };
    [2.0 * quarter(0.0), 2.0 * quarter(0.5 * PI)]
}
