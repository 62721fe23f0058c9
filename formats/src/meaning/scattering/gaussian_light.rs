//! Scattering of a light that is a spherical Gaussian about a direction (after Xu 2011); a sky is a sum of such lights.
//!
//! A spherical Gaussian is exactly a Gaussian of θ times one of φ. Around the fibre, the light and each path are cosine
//! series in n φ, and their products are integrated in closed form. The paper fits the paths by Gaussians instead,
//! which fails where glints meet (η′ near 2). Along the fibre, a 24-point quadrature covers the overlap of lobe and
//! light.

use super::azimuthal::{Logistic, legendre};
use super::longitudinal::{Spread, i0e};
use super::{Angles, AzimuthalScattering, Fibre, FibreSection, SCATTERED};
use core::array::from_fn;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use glam::DVec3;

/// Light of radiance exp(κ (ω · ω_j − 1)) from each direction ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianLight {
    /// ω_j, a unit vector towards the light's centre.
    pub towards: DVec3,
    /// κ; 0 for uniform light, 1/σ² for a standard deviation of σ radians.
    pub sharpness: f64,
}

impl GaussianLight {
    /// Returns the radiance from a direction, a unit vector.
    pub fn radiance(&self, from: DVec3) -> f64 {
        libm::exp(self.sharpness * (from.dot(self.towards) - 1.0))
    }

    /// Returns the integral of the radiance over all directions.
    pub fn integral(&self) -> f64 {
        let k = self.sharpness;
        if k < 1e-9 { 2.0 * TAU } else { TAU * -libm::expm1(-2.0 * k) / k }
    }
}

/// Number of terms of the cosine series: enough for lights and glints of 8 degrees or more.
pub(super) const TERMS: usize = 49;
/// Half-width of the interval of integration over light inclinations, in standard deviations of the product of lobe and
/// light.
const REACH: f64 = 5.0;

/// Fibre with the data precomputed for Gaussian lights.
#[derive(Clone, Debug)]
pub struct BroadlyLitFibre {
    fibre: Fibre,
    /// Factor on each term of a cosine series due to azimuthal roughness.
    rough: [f64; TERMS],
}

impl BroadlyLitFibre {
    /// Prepares a fibre.
    pub fn new(fibre: &Fibre) -> Self {
        let rough = match fibre.around {
            AzimuthalScattering::Smooth(_) => [1.0; TERMS],
            AzimuthalScattering::Rough(scale) => from_fn(|n| cosine_of_logistic(scale, n)),
        };
        Self { fibre: *fibre, rough }
    }

    /// Returns the fibre.
    pub(super) fn fibre(&self) -> &Fibre {
        &self.fibre
    }

    /// Returns the factor on term `n` of a cosine series due to roughness, for a bundle with azimuthal standard
    /// deviation `width`, radians.
    pub(super) fn kept(&self, n: usize, width: f64) -> f64 {
        let around = n as f64 * width;
        self.rough[n] * if width > 0.0 { libm::exp(-0.5 * around * around) } else { 1.0 }
    }

    /// Returns the integral of [`Fibre::scatter`] over the directions of the light, for each colour: the light that the
    /// fibre sends to the eye.
    ///
    /// * `sigma`: absorption of the fibre per radius, 0 or more
    /// * `tip`, `eye`: unit vectors
    pub fn scatter(&self, sigma: [f64; 3], tip: DVec3, light: &GaussianLight, eye: DVec3) -> [f64; 3] {
        let middle = Angles::between(tip, light.towards, eye);
        let [theta_j, theta_o] = [middle.from, middle.to].map(|(sin, cos)| libm::atan2(sin, cos));
        let mut sum = [0.0; 3];
        for p in 0..self.fibre.path_count() {
            let (from, to) = window(&self.fibre.spread(p as u32), theta_j, theta_o, light.sharpness);
            let (centre, half) = (0.5 * (from + to), 0.5 * (to - from).max(0.0));
            for (x, weight) in legendre() {
                let theta = centre + half * x;
                let (sin, cos) = (libm::sin(theta), libm::cos(theta).max(0.0));
                let angles = Angles { from: (sin, cos), ..middle };
                let sharpness = light.sharpness * cos * middle.from.1;
                let near = libm::exp(light.sharpness * (libm::cos(theta - theta_j) - 1.0));
                let along = weight * half * cos * near * self.fibre.path_along(p as u32, &angles);
                if along > 0.0 {
                    let section = self.fibre.section(if p == SCATTERED { angles.to.1 } else { angles.cos_d() });
                    let around = self.around(&section, p, sigma, sharpness, middle.phi);
                    for (sum, around) in sum.iter_mut().zip(around) {
                        *sum += along * around;
                    }
                }
            }
        }
        sum
    }

    /// Returns the integral, over the azimuth φ, of the light of path `p` times exp(κ (cos(φ − δ) − 1)), where κ is
    /// `sharpness` and δ is `delta`.
    fn around(&self, section: &FibreSection, p: usize, sigma: [f64; 3], sharpness: f64, delta: f64) -> [f64; 3] {
        let light = cosines_of_gaussian(sharpness, delta);
        match p {
            3 => return sigma.map(|sigma| TAU * light[0] * section.rest(sigma)),
            SCATTERED => return sigma.map(|sigma| TAU * light[0] * section.scattered(sigma)),
            _ => {}
        }
        // A bundle that leaves at azimuth φ contributes its own light multiplied by the incident light's series at φ.
        let mut sum = [0.0; 3];
        section.for_each_bundle(p as u32, &mut |phi, width, way| {
            let mut met = 0.0;
            let (mut before, mut now, twice) = (libm::cos(phi), 1.0, 2.0 * libm::cos(phi));
            for (n, light) in light.iter().enumerate() {
                met += light * self.kept(n, width) * now;
                (before, now) = (now, twice * now - before);
            }
            for (sum, sigma) in sum.iter_mut().zip(sigma) {
                *sum += way.attenuated(sigma) * met;
            }
        });
        // A truncated cosine series may be slightly negative where the light is zero.
        sum.map(|sum| sum.max(0.0))
    }
}

/// Returns the range of light inclinations, radians, in which a lobe and the light about `theta_j` overlap. Both are
/// nearly Gaussian, and so is their product.
pub(super) fn window(spread: &Spread, theta_j: f64, theta_o: f64, sharpness: f64) -> (f64, f64) {
    let lobe = 1.0 / spread.variance();
    let whole = lobe + sharpness;
    let middle = ((2.0 * spread.shift - theta_o) * lobe + theta_j * sharpness) / whole;
    let reach = REACH / whole.sqrt();
    let within = |theta: f64| theta.clamp(-FRAC_PI_2, FRAC_PI_2);
    (within(middle - reach), within(middle + reach))
}

/// Returns the integral of the logistic distribution of scale `scale` times cos(n x).
fn cosine_of_logistic(scale: f64, n: usize) -> f64 {
    // Integrate one half, in parts about as wide as the scale but narrow enough for the cosine.
    let parts = libm::ceil(PI / scale.min(1.0)).clamp(4.0, 400.0) as usize;
    let half = 0.5 * PI / parts as f64;
    let logistic = Logistic::new(scale);
    let of_part = |k: usize| {
        let at = |(x, weight): &(f64, f64)| {
            let x = half * (2.0 * k as f64 + 1.0 + x);
            weight * half * logistic.density(x) * libm::cos(n as f64 * x)
        };
        legendre().iter().map(at).sum::<f64>()
    };
    2.0 * (0..parts).map(of_part).sum::<f64>()
}

/// Returns exp(κ (cos(φ − δ) − 1)) as a cosine series in n φ, for integrands that are even in φ. Its terms are exp(−κ)
/// I₀(κ) and 2 exp(−κ) I_n(κ) cos(n δ).
pub(super) fn cosines_of_gaussian(sharpness: f64, delta: f64) -> [f64; TERMS] {
    let mut terms = [0.0; TERMS];
    // Ratios of neighbouring Bessel functions, by downward recurrence from an order where they are negligible.
    let last = 2 * TERMS;
    let mut ratio = 0.0;
    let mut ratios = [0.0; TERMS];
    for n in (1..=last).rev() {
        ratio = if sharpness > 0.0 { 1.0 / (2.0 * n as f64 / sharpness + ratio) } else { 0.0 };
        if n < TERMS {
            ratios[n] = ratio;
        }
    }
    let mut bessel = i0e(sharpness);
    terms[0] = bessel;
    for n in 1..TERMS {
        bessel *= ratios[n];
        terms[n] = 2.0 * bessel * libm::cos(n as f64 * delta);
    }
    terms
}
