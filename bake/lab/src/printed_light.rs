//! Scattering of a spherical Gaussian light by a fibre in the published form (after Xu 2011): Gaussians approximate the
//! exact distribution around the fibre.
//!
//! R is a sum of powers of cos(φ/2), and TT one Gaussian about π. TRT has two Gaussians about its caustics and one
//! between them; from η′ = 2 on, only one is left. The form is here for measurement only; pelage does not render with
//! it.

use crate::least_squares::least_squares;
use glam::DVec3;
use pelage_formats::meaning::scattering::gaussian_light::GaussianLight;
use pelage_formats::meaning::scattering::longitudinal::i0e;
use pelage_formats::meaning::scattering::optics::LEAST_COS_D;
use pelage_formats::meaning::scattering::{Angles, AzimuthalScattering, Fibre, FibreSection};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Number of values of cos θd at which the paths are fitted.
const SECTIONS: usize = 96;
/// Number of powers of cos(φ/2), from 0.
const POWERS: usize = 7;
/// Number of azimuths at which R is fitted, and over which R times the light is integrated.
const AZIMUTHS: usize = 256;
/// Range of η′ beyond 2 over which the caustics fade out.
const FADES: f64 = 0.3;

/// Circular Gaussian: strength · exp(κ (cos(φ − μ) − 1)).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct CircularGaussian {
    strength: f64,
    middle: f64,
    sharpness: f64,
}

impl CircularGaussian {
    /// Returns the integral of the Gaussian times exp(κ (cos(φ − δ) − 1)).
    fn integral(&self, sharpness: f64, delta: f64) -> f64 {
        let (a, b) = (self.sharpness, sharpness);
        let both = (a * a + b * b + 2.0 * a * b * libm::cos(self.middle - delta)).max(0.0).sqrt();
        self.strength * TAU * i0e(both) * libm::exp(both - a - b)
    }
}

/// Returns the integral of exp(κ (cos φ − 1)) over all azimuths, where κ is `sharpness`.
fn full_integral(sharpness: f64) -> f64 {
    TAU * i0e(sharpness)
}

/// Returns the κ for which [`full_integral`] is `light`; 0 if there is none.
fn sharpness_of(light: f64) -> f64 {
    if light >= TAU || light.is_nan() {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if full_integral(middle) > light { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Fitted azimuthal distribution of the light scattered by a section of a fibre.
#[derive(Clone, Copy, Debug, Default)]
struct FittedSection {
    reflected: [f64; POWERS],
    through: CircularGaussian,
    within: [CircularGaussian; 3],
}

impl FittedSection {
    fn new(section: &FibreSection, width: f64, sigma: f64) -> Self {
        let light = |p: u32, phi: f64| {
            let mut sum = 0.0;
            section.contributions(p, phi, &mut |way| sum += way.attenuated(sigma));
            sum
        };
        let all = |p: u32| {
            // Sums over equal steps integrate periodic functions accurately.
            let steps = 4 * AZIMUTHS;
            let at = |i: usize| light(p, TAU * (i as f64 + 0.5) / steps as f64 - PI);
            (0..steps).map(at).sum::<f64>() * TAU / steps as f64
        };
        let through = {
            let (strength, all) = (light(1, PI), all(1));
            let sharpness = sharpness_of(all / strength.max(1e-300));
            CircularGaussian { strength, middle: PI, sharpness }
        };
        Self { reflected: powers(|phi| light(0, phi)), through, within: fit_trt(section, width, light(2, 0.0), all(2)) }
    }

    /// Returns the integral of path `p` times exp(κ (cos(φ − δ) − 1)).
    fn integral(&self, p: u32, sharpness: f64, delta: f64) -> f64 {
        match p {
            0 => {
                let at = |i: usize| {
                    let phi = TAU * (i as f64 + 0.5) / AZIMUTHS as f64 - PI;
                    let half = libm::cos(0.5 * phi);
                    let sum = self.reflected.iter().rev().fold(0.0, |sum, c| sum * half + c);
                    sum * libm::exp(sharpness * (libm::cos(phi - delta) - 1.0))
                };
                (0..AZIMUTHS).map(at).sum::<f64>() * TAU / AZIMUTHS as f64
            }
            1 => self.through.integral(sharpness, delta),
            _ => self.within.iter().map(|bump| bump.integral(sharpness, delta)).sum(),
        }
    }
}

/// Fits powers of cos(φ/2) by least squares.
fn powers(of: impl Fn(f64) -> f64) -> [f64; POWERS] {
    let phi = |i: usize| PI * (i as f64 + 0.5) / AZIMUTHS as f64;
    let power = |k: usize| (0..AZIMUTHS).map(|i| libm::pow(libm::cos(0.5 * phi(i)), k as f64)).collect();
    let found = least_squares((0..POWERS).map(power).collect(), (0..AZIMUTHS).map(|i| of(phi(i))).collect());
    std::array::from_fn(|k| found[k])
}

/// Fits TRT in its three regimes. `middle` is its light towards azimuth 0, `all` its light towards all azimuths.
fn fit_trt(section: &FibreSection, width: f64, middle: f64, all: f64) -> [CircularGaussian; 3] {
    let across = section.section.across;
    let sharp = 1.0 / (width * width);
    let one = |sharpness: f64| {
        [
            CircularGaussian { strength: all / full_integral(sharpness), middle: 0.0, sharpness },
            CircularGaussian::default(),
            CircularGaussian::default(),
        ]
    };
    if let Some((_, turned)) = section.section.caustic() {
        let at = turned.abs();
        let wide = (1.0 / (at * at)).min(1e6);
        let shared = 1.0 - libm::exp(sharp * (libm::cos(at) - 1.0));
        let between = middle * shared * shared;
        let strength = (all - between * full_integral(wide)) / (2.0 * full_integral(sharp));
        if strength < 0.0 {
            return one(wide);
        }
        return [
            CircularGaussian { strength, middle: at, sharpness: sharp },
            CircularGaussian { strength, middle: -at, sharpness: sharp },
            CircularGaussian { strength: between, middle: 0.0, sharpness: wide },
        ];
    }
    let spread = sharpness_of(all / middle.max(1e-300));
    let share = ((across - 2.0) / FADES).clamp(0.0, 1.0);
    let deviation = |sharpness: f64| 1.0 / sharpness.max(1e-6).sqrt();
    let mixed = width + (deviation(spread) - width) * share;
    one(1.0 / (mixed * mixed))
}

/// Smooth fibre with a given absorption per radius, and the fitted distributions of its light for all difference
/// angles.
#[derive(Clone, Debug)]
pub struct PrintedLight {
    fibre: Fibre,
    sections: Vec<FittedSection>,
}

impl PrintedLight {
    /// Fits a fibre. A rough fibre is treated as a smooth one with glints of the same width.
    pub fn new(fibre: &Fibre, sigma: f64) -> Self {
        let width = match fibre.around {
            AzimuthalScattering::Smooth(glint) => glint.width,
            AzimuthalScattering::Rough(scale) => scale * PI / 3.0_f64.sqrt(),
        };
        let section = |i: usize| {
            let cos_d = LEAST_COS_D + (1.0 - LEAST_COS_D) * i as f64 / (SECTIONS - 1) as f64;
            FittedSection::new(&fibre.section(cos_d), width, sigma)
        };
        Self { fibre: *fibre, sections: (0..SECTIONS).map(section).collect() }
    }

    /// Returns the light that the fibre scatters to the eye by R, TT and TRT.
    pub fn scatter(&self, tip: DVec3, light: &GaussianLight, eye: DVec3) -> f64 {
        const STEPS: usize = 64;
        let middle = Angles::between(tip, light.towards, eye);
        let [theta_j, theta_o] = [middle.from, middle.to].map(|(sin, cos)| libm::atan2(sin, cos));
        let mut sum = 0.0;
        for p in 0..3 {
            let spread = self.fibre.spread(p);
            let lobe = 1.0 / spread.variance();
            let both = lobe + light.sharpness;
            let centre = ((2.0 * spread.shift - theta_o) * lobe + theta_j * light.sharpness) / both;
            let [from, to] = [-5.0, 5.0].map(|far| (centre + far / both.sqrt()).clamp(-FRAC_PI_2, FRAC_PI_2));
            let step = (to - from).max(0.0) / STEPS as f64;
            for i in 0..STEPS {
                let theta = from + step * (i as f64 + 0.5);
                let (sin, cos) = (libm::sin(theta), libm::cos(theta).max(0.0));
                let angles = Angles { from: (sin, cos), ..middle };
                let near = libm::exp(light.sharpness * (libm::cos(theta - theta_j) - 1.0));
                let along = step * cos * near * self.fibre.path_along(p, &angles);
                let place = (angles.cos_d() - LEAST_COS_D) / (1.0 - LEAST_COS_D) * (SECTIONS - 1) as f64;
                let place = place.clamp(0.0, (SECTIONS - 1) as f64);
                let below = (place as usize).min(SECTIONS - 2);
                let share = place - below as f64;
                let sharpness = light.sharpness * cos * middle.from.1;
                let [a, b] = [below, below + 1].map(|i| self.sections[i].integral(p, sharpness, middle.phi));
                sum += along * (a + (b - a) * share);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_formats::meaning::scattering::azimuthal::GlintShape;
    use pelage_formats::meaning::scattering::gaussian_light::BroadlyLitFibre;

    #[test]
    fn published_gaussian_light_is_accurate_for_broad_lights_and_separate_glints() {
        let glint = GlintShape { width: 15_f64.to_radians(), ..GlintShape::default() };
        let fibre = Fibre { around: AzimuthalScattering::Smooth(glint), ..Fibre::default() };
        let (printed, exact) = (PrintedLight::new(&fibre, 0.2), BroadlyLitFibre::new(&fibre));
        let light = GaussianLight { towards: DVec3::new(0.6, 0.1, 0.8).normalize(), sharpness: 1.0 };
        for eye in [DVec3::X, DVec3::new(-1.0, 0.2, 0.0), DVec3::new(0.3, 0.3, -1.0)] {
            let eye = eye.normalize();
            let found = printed.scatter(DVec3::Y, &light, eye);
            let expected = exact.scatter([0.2; 3], DVec3::Y, &light, eye)[0];
            // The published form has no paths with more than one internal reflection.
            assert!((found / expected - 1.0).abs() < 0.12, "{eye}: {found}, {expected}");
        }
        let sharp = sharpness_of(full_integral(30.0));
        assert!((sharp - 30.0).abs() < 1e-6, "{sharp}");
    }
}
