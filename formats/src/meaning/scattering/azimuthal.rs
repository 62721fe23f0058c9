//! Scattering around a fibre: light paths through its cross-section that leave in a given direction (Marschner 2003,
//! section 4.2).
//!
//! Absorption is applied separately: each contribution has its share of light and its path length, so that one
//! evaluation serves every colour.

use super::longitudinal::gaussian;
use super::optics::Section;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// Contribution of a light path through the fibre, as seen from one azimuth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathContribution {
    /// Light per radian, without absorption.
    pub light: f64,
    /// Path length within the fibre, in fibre radii.
    pub length: f64,
}

impl PathContribution {
    /// Returns the remaining light if the fibre absorbs `sigma` per radius.
    pub fn attenuated(&self, sigma: f64) -> f64 {
        self.light * libm::exp(-sigma * self.length)
    }
}

/// Shape of glints. They replace the caustics of internally reflected light, which are infinitely bright in a perfectly
/// smooth fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlintShape {
    /// Standard deviation of each glint, radians (10 to 25 degrees in Marschner 2003).
    pub width: f64,
    /// Strength. With 1, glints have exactly the light of the caustics that they replace.
    pub scale: f64,
    /// Width of the range of η′, starting at 2, in which the glints fade out. At η′ = 2, the two caustics meet and
    /// vanish.
    pub fade: f64,
}

impl Default for GlintShape {
    fn default() -> Self {
        Self { width: 10_f64.to_radians(), scale: 1.0, fade: 0.3 }
    }
}

/// Maximum share of the light through the cross-section that is concentrated into a glint.
const MOST_BUNDLED: f64 = 0.5;
/// Number of Gauss quadrature points for each half of the cross-section.
const RULE: usize = 24;

/// Wraps a fibre's azimuthal angle to −π..=π.
pub fn wrapped(phi: f64) -> f64 {
    phi - TAU * libm::round(phi / TAU)
}

impl Section {
    /// Returns the azimuthal deflection of light that enters at angle `gamma` and leaves on path `p`, radians: 2 p γt −
    /// 2 γ. It is relative to the exit at `gamma` = 0.
    pub fn deviation(&self, p: u32, gamma: f64) -> f64 {
        let (sin, cos) = self.refracted(libm::sin(gamma));
        2.0 * f64::from(p) * libm::atan2(sin, cos) - 2.0 * gamma
    }

    /// Returns the derivative of [`Section::deviation`] with respect to the entry angle.
    fn deviation_slope(&self, p: u32, gamma: f64) -> f64 {
        let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
        2.0 * f64::from(p) * cos / (self.across * self.across - sin * sin).max(1e-12).sqrt() - 2.0
    }

    /// Returns the contribution of path `p` for light that enters at angle `gamma`.
    fn contribution(&self, p: u32, gamma: f64) -> PathContribution {
        let (sin, cos) = (libm::sin(gamma), libm::cos(gamma).max(0.0));
        let bundled = self.deviation_slope(p, gamma).abs().max(1e-6);
        PathContribution { light: 0.5 * self.share(p, cos) * cos / bundled, length: f64::from(p) * self.chord(sin) }
    }

    /// Returns the light reflected at the surface (R) towards azimuth `phi`, −π..=π.
    pub fn reflected(&self, phi: f64) -> f64 {
        let half = libm::cos(0.5 * wrapped(phi)).max(0.0);
        0.25 * half * self.fresnel(half)
    }

    /// Returns the contribution of light transmitted through the fibre (TT) towards azimuth `phi`; zero beyond the
    /// maximum deflection.
    pub fn transmitted(&self, phi: f64) -> PathContribution {
        let aside = PI - wrapped(phi).abs();
        match self.root(1, -aside, [0.0, FRAC_PI_2]) {
            Some(gamma) => self.contribution(1, gamma),
            None => PathContribution::default(),
        }
    }

    /// Returns up to three contributions of light reflected once inside (TRT) towards azimuth `phi`, for a smooth
    /// fibre. They are infinite at the caustics.
    pub fn reflected_inside(&self, phi: f64) -> impl Iterator<Item = PathContribution> + '_ {
        let phi = wrapped(phi).abs();
        let caustic = self.caustic().map_or(0.0, |(gamma, _)| gamma);
        let found = [
            self.root(2, phi, [0.0, caustic]),
            self.root(2, phi, [caustic, FRAC_PI_2]),
            // The third contribution comes from the other half of the cross-section.
            self.root(2, -phi, [caustic, FRAC_PI_2]),
        ];
        // A ray through the centre belongs to both halves, but counts once.
        let is_middle = found[1] == Some(0.0) && found[2] == Some(0.0);
        let of_halves = if is_middle { &found[..2] } else { &found[..] };
        let gammas: [Option<f64>; 3] = core::array::from_fn(|i| of_halves.get(i).copied().flatten());
        gammas.into_iter().flatten().map(|gamma| self.contribution(2, gamma))
    }

    /// Returns the caustic of internally reflected light, in the half with positive angles: entry angle and deflection.
    /// `None` if η′ is 2 or more.
    pub fn caustic(&self) -> Option<(f64, f64)> {
        let under = (4.0 - self.across * self.across) / 3.0;
        (under > 0.0).then(|| {
            let gamma = libm::asin(under.min(1.0).sqrt());
            (gamma, self.deviation(2, gamma))
        })
    }

    /// Returns the entry angle between `from` and `to`, within 0..=π/2, at which the deflection on path `p` is
    /// `turned`, if there is one. The deflection must be monotone between them.
    fn root(&self, p: u32, turned: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let off = |gamma: f64| self.deviation(p, gamma) - turned;
        let (mut low, mut high) = (from, to);
        let (at_low, at_high) = (off(low), off(high));
        if at_low == 0.0 && to > from {
            return Some(low);
        }
        if at_low * at_high > 0.0 || to <= from {
            return None;
        }
        let rises = at_high > at_low;
        let mut gamma = 0.5 * (low + high);
        for _ in 0..60 {
            let found = off(gamma);
            if (found > 0.0) == rises {
                high = gamma;
            } else {
                low = gamma;
            }
            // Do a Newton step if it stays in the bracket, else bisect.
            let next = gamma - found / self.deviation_slope(p, gamma);
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - gamma).abs() < 1e-15 {
                return Some(next);
            }
            gamma = next;
        }
        Some(gamma)
    }

    /// Returns up to four contributions of light reflected once inside (TRT) towards azimuth `phi`. The caustics are
    /// spread into `glints`.
    pub fn glinting(&self, phi: f64, glints: Option<&Glints>) -> impl Iterator<Item = PathContribution> + '_ {
        let phi = wrapped(phi);
        let kept = glints.map_or(1.0, |glints| glints.remaining(phi));
        // A contribution that is removed completely may be infinite: avoid 0 times infinity, which is NaN.
        let own = self
            .reflected_inside(phi)
            .map(move |way| PathContribution { light: if kept > 0.0 { way.light * kept } else { 0.0 }, ..way });
        let spread = glints.map(|glints| {
            let about =
                gaussian(glints.width, wrapped(phi - glints.phi)) + gaussian(glints.width, wrapped(phi + glints.phi));
            PathContribution { light: glints.light * about, length: glints.length }
        });
        own.chain(spread)
    }

    /// Returns the glints of this section, or `None` if it has none. Their light is the light removed around the
    /// caustics, multiplied by the scale of `glint`.
    pub fn glints(&self, glint: &GlintShape) -> Option<Glints> {
        let (gamma, phi, share) = match self.caustic() {
            Some((gamma, phi)) => (gamma, phi, 1.0),
            None => {
                let t = ((self.across - 2.0) / glint.fade.max(1e-9)).clamp(0.0, 1.0);
                (0.0, 0.0, 1.0 - t * t * (3.0 - 2.0 * t))
            }
        };
        if share <= 0.0 {
            return None;
        }
        let length = 2.0 * self.chord(libm::sin(gamma));
        let mut glints = Glints { phi, light: 0.0, length, share, width: glint.width };
        let taken = over_section(|gamma| {
            (1.0 - glints.remaining(wrapped(self.deviation(2, gamma)))) * self.share(2, libm::cos(gamma))
        });
        glints.light = 0.25 * glint.scale * taken;
        Some(glints)
    }

    /// Returns the glints of this section with their light as published in Marschner 2003. There, the scale is a
    /// property of the fibre (0.5 to 5), independent of the light in the caustic.
    pub fn published_glints(&self, glint: &GlintShape) -> Option<Glints> {
        let (gamma, bend) = self.caustic().map_or((0.0, 0.0), |(gamma, _)| (gamma, self.caustic_bend(gamma)));
        let bundled = if bend > 0.0 { MOST_BUNDLED.min(2.0 * (2.0 * glint.width / bend).sqrt()) } else { MOST_BUNDLED };
        let light = glint.scale * self.share(2, libm::cos(gamma)) * bundled;
        self.glints(glint).map(|glints| Glints { light: light * glints.share, ..glints })
    }

    /// Returns |d²Φ/dh²| at a caustic.
    fn caustic_bend(&self, gamma: f64) -> f64 {
        let (h, cos) = (libm::sin(gamma), libm::cos(gamma));
        let across = (self.across * self.across - h * h).max(1e-12);
        (4.0 * h / (across * across.sqrt()) - 2.0 * h / (cos * cos * cos)).abs()
    }

    /// Divides path `p` into thin bundles of rays over the whole cross-section. Returns the exit azimuth and the
    /// contribution of each.
    pub fn bundles(&self, p: u32) -> impl Iterator<Item = (f64, PathContribution)> + '_ {
        const POINTS: usize = 512;
        (0..POINTS).map(move |k| {
            let gamma = ((k as f64 + 0.5) / POINTS as f64 - 0.5) * PI;
            let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
            let light = 0.5 * self.share(p, cos) * cos * (PI / POINTS as f64);
            let phi = self.deviation(p, gamma) + f64::from(p) * PI;
            (phi, PathContribution { light, length: f64::from(p) * self.chord(sin) })
        })
    }

    /// Returns the contributions of path `p` towards azimuth `phi` in a fibre with azimuthal roughness. Each bundle is
    /// spread by a logistic distribution of scale `scale`, radians (Chiang 2016).
    pub fn rough(&self, p: u32, phi: f64, scale: f64) -> impl Iterator<Item = PathContribution> + '_ {
        let logistic = Logistic::new(scale);
        let spread = move |at: f64| logistic.density(wrapped(phi - at));
        self.bundles(p).map(move |(at, way)| PathContribution { light: way.light * spread(at), ..way })
    }

    /// Returns the total light that leaves on path `p`, without absorption. It is ½ ∫ A dh, where A is the share of the
    /// light that enters at offset h and leaves on this path.
    pub fn energy(&self, p: u32) -> f64 {
        0.5 * over_section(|gamma| self.share(p, libm::cos(gamma)))
    }
}

/// Pair of glints of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glints {
    /// Azimuth of one glint, radians; the other has the opposite sign.
    pub phi: f64,
    /// Light of each glint.
    pub light: f64,
    /// Path length, in fibre radii.
    pub length: f64,
    /// Share of the caustics' light that is moved into the glints, 0..=1.
    pub share: f64,
    /// Standard deviation of each glint, radians.
    pub width: f64,
}

impl Glints {
    /// Returns the share of the light at azimuth `phi` that is not moved into the glints.
    pub(super) fn remaining(&self, phi: f64) -> f64 {
        let of = |x: f64| 1.0 - self.share * libm::exp(-0.5 * (x / self.width) * (x / self.width));
        of(wrapped(phi - self.phi)) * of(wrapped(phi + self.phi))
    }
}

/// Logistic distribution, truncated to ±π and renormalised.
#[derive(Clone, Copy, Debug)]
pub struct Logistic {
    scale: f64,
    /// Share of the distribution within ±π.
    whole: f64,
}

impl Logistic {
    /// `scale`: radians.
    pub fn new(scale: f64) -> Self {
        Self { scale, whole: libm::tanh(0.5 * PI / scale) }
    }

    /// Returns the density at `x`, −π to π.
    pub fn density(&self, x: f64) -> f64 {
        let e = libm::exp(-x.abs() / self.scale);
        e / (self.scale * (1.0 + e) * (1.0 + e)) / self.whole
    }
}

/// Returns the integral of f cos γ over γ in −π/2..=π/2, by Gauss quadrature on each half. This equals the integral
/// over the offsets h.
pub fn over_section(f: impl Fn(f64) -> f64) -> f64 {
    let half = FRAC_PI_2 / 2.0;
    let of_half = |middle: f64| {
        let at = |(x, weight): &(f64, f64)| {
            let gamma = middle + half * x;
            weight * half * f(gamma) * libm::cos(gamma)
        };
        legendre().iter().map(at).sum::<f64>()
    };
    of_half(-half) + of_half(half)
}

/// Returns nodes and weights of the [`RULE`]-point quadrature over −1..=1.
pub(super) fn legendre() -> &'static [(f64, f64); RULE] {
    static POINTS: OnceLock<[(f64, f64); RULE]> = OnceLock::new();
    POINTS.get_or_init(|| {
        core::array::from_fn(|i| {
            // Newton's method; the initial guess is close enough for each root of the polynomial.
            let mut x = libm::cos(PI * (i as f64 + 0.75) / (RULE as f64 + 0.5));
            let mut slope = 1.0;
            for _ in 0..6 {
                let (mut before, mut now) = (1.0, x);
                for n in 2..=RULE {
                    let n = n as f64;
                    (before, now) = (now, ((2.0 * n - 1.0) * x * now - (n - 1.0) * before) / n);
                }
                slope = RULE as f64 * (x * now - before) / (x * x - 1.0);
                x -= now / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
    })
}
