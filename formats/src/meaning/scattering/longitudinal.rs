//! Longitudinal scattering: the distribution of light about the cone to which a smooth fibre would confine it.

use core::f64::consts::PI;

/// Shift and width of a path's longitudinal lobe, as in Marschner 2003.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Shift of the lobe due to the tilt of the cuticle scales, in radians of the half angle.
    pub shift: f64,
    /// Standard deviation, radians of the half angle, above 0.
    pub width: f64,
}

/// Returns the density at `x` of the normal distribution with mean 0 and standard deviation `width`.
pub fn gaussian(width: f64, x: f64) -> f64 {
    libm::exp(-0.5 * (x / width) * (x / width)) / (width * libm::sqrt(2.0 * PI))
}

impl Spread {
    /// Returns Marschner's lobe: a Gaussian of the half angle. It is halved, because the outgoing angle changes twice
    /// as much as the half angle. As published, without this factor ½, a fibre without absorption would return twice
    /// the light.
    pub fn by_half_angle(&self, theta_i: f64, theta_o: f64) -> f64 {
        0.5 * gaussian(self.width, 0.5 * (theta_i + theta_o) - self.shift)
    }

    /// Returns d'Eon's lobe, which conserves energy: ∫ M cos θi dθi = 1 for every θo, so that a fibre without
    /// absorption is as bright as its uniform surroundings. The tilt rotates the outgoing cone.
    ///
    /// * arguments: sine and cosine of θi and of θo, the inclinations to the normal plane of the fibre
    pub fn conserving(&self, (sin_i, cos_i): (f64, f64), (sin_o, cos_o): (f64, f64)) -> f64 {
        let (sin_o, cos_o) = self.tilted((sin_o, cos_o));
        let v = self.variance();
        let (a, b) = (cos_i * cos_o / v, sin_i * sin_o / v);
        i0e(a) * libm::exp(a - b - 1.0 / v) / (v * -libm::expm1(-2.0 / v))
    }
}

impl Spread {
    /// Returns sine and cosine of the outgoing inclination, rotated by the tilt. A tilt of the half angle by α rotates
    /// the inclination by 2 α.
    pub fn tilted(&self, (sin_o, cos_o): (f64, f64)) -> (f64, f64) {
        let (sin, cos) = (libm::sin(2.0 * self.shift), libm::cos(2.0 * self.shift));
        (sin_o * cos - cos_o * sin, (cos_o * cos + sin_o * sin).abs())
    }

    /// Returns the variance of the outgoing angle about its cone.
    pub fn variance(&self) -> f64 {
        4.0 * self.width * self.width
    }
}

/// Returns exp(−x) I₀(x) for x ≥ 0, the modified Bessel function of the first kind (Abramowitz and Stegun 9.8.1 and
/// 9.8.2); accurate to 5e-7, never overflows.
pub fn i0e(x: f64) -> f64 {
    let polynomial = |of: &[f64], t: f64| of.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if x <= 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        let of = [1.0, 3.515_622_9, 3.089_942_4, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
        return libm::exp(-x) * polynomial(&of, t);
    }
    let of = [
        0.398_942_28,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    polynomial(&of, 3.75 / x) / x.sqrt()
}
