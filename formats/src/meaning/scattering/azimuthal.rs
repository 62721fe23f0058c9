//! How light spreads around a fibre: the ways through its cross-section that end at an angle (Marschner 2003, section 4.2).
//!
//! What a fibre absorbs is kept apart: each way has the share of the light that takes it and how far it goes, so that one evaluation serves every colour.

use super::longitudinal::gaussian;
use super::optics::Section;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

/// A way that light takes, as seen from one azimuth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// Light per radian, without absorption.
    pub light: f64,
    /// Length within the fibre, over its radius.
    pub length: f64,
}

impl Way {
    /// What is left of it where the fibre absorbs `sigma` a radius.
    pub fn left(&self, sigma: f64) -> f64 {
        self.light * libm::exp(-sigma * self.length)
    }
}

/// How the caustics of light that was reflected within are drawn: what a fibre that is smooth all around bundles without bound is spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glint {
    /// Standard deviation of each of both glints, radians (10 to 25 degrees in Marschner 2003).
    pub width: f64,
    /// Their strength, 1 for what they bundle: light is neither lost nor gained.
    pub scale: f64,
    /// How far beyond η′ = 2, where both meet and vanish, they fade.
    pub fade: f64,
}

impl Default for Glint {
    fn default() -> Self {
        Self { width: 10_f64.to_radians(), scale: 1.0, fade: 0.3 }
    }
}

/// Share of the cross-section that is bundled into a glint at most.
const MOST_BUNDLED: f64 = 0.5;
/// Points of Gauss's rule over the cross-section, of each half.
const RULE: usize = 24;

/// A fibre's azimuthal angle in −π..=π.
pub fn wrapped(phi: f64) -> f64 {
    phi - TAU * libm::round(phi / TAU)
}

impl Section {
    /// How much further than the straight way out light on path `p` leaves that came in at angle `gamma`, radians: 2 p γt − 2 γ.
    pub fn turned(&self, p: u32, gamma: f64) -> f64 {
        let (sin, cos) = self.refracted(libm::sin(gamma));
        2.0 * f64::from(p) * libm::atan2(sin, cos) - 2.0 * gamma
    }

    /// Its slope over the angle.
    fn turned_slope(&self, p: u32, gamma: f64) -> f64 {
        let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
        2.0 * f64::from(p) * cos / (self.across * self.across - sin * sin).max(1e-12).sqrt() - 2.0
    }

    /// The light that comes out at the root `gamma` of path `p`, with its way.
    fn way(&self, p: u32, gamma: f64) -> Way {
        let (sin, cos) = (libm::sin(gamma), libm::cos(gamma).max(0.0));
        let bundled = self.turned_slope(p, gamma).abs().max(1e-6);
        Way { light: 0.5 * self.share(p, cos) * cos / bundled, length: f64::from(p) * self.chord(sin) }
    }

    /// Reflected at the surface (R) towards azimuth `phi`, −π..=π.
    pub fn reflected(&self, phi: f64) -> f64 {
        let half = libm::cos(0.5 * wrapped(phi)).max(0.0);
        0.25 * half * self.fresnel(half)
    }

    /// Through the fibre (TT) towards azimuth `phi`; nothing beyond the angle that it can turn.
    pub fn through(&self, phi: f64) -> Way {
        let aside = PI - wrapped(phi).abs();
        match self.root(1, -aside, [0.0, FRAC_PI_2]) {
            Some(gamma) => self.way(1, gamma),
            None => Way::default(),
        }
    }

    /// Reflected once within (TRT) towards azimuth `phi`, as a smooth fibre has it: without bound at the caustics. Up to three ways.
    pub fn within(&self, phi: f64) -> impl Iterator<Item = Way> + '_ {
        let phi = wrapped(phi).abs();
        let caustic = self.caustic().map_or(0.0, |(gamma, _)| gamma);
        let found = [
            self.root(2, phi, [0.0, caustic]),
            self.root(2, phi, [caustic, FRAC_PI_2]),
            // From the other half of the section.
            self.root(2, -phi, [caustic, FRAC_PI_2]),
        ];
        // What goes through the middle belongs to both halves, and counts once.
        let is_middle = found[1] == Some(0.0) && found[2] == Some(0.0);
        let of_halves = if is_middle { &found[..2] } else { &found[..] };
        let gammas: [Option<f64>; 3] = core::array::from_fn(|i| of_halves.get(i).copied().flatten());
        gammas.into_iter().flatten().map(|gamma| self.way(2, gamma))
    }

    /// Where light that is reflected within is bundled without bound, of the half with positive angles: the angle that it comes in at, and by how much it is turned.
    /// `None` where η′ is 2 or more.
    pub fn caustic(&self) -> Option<(f64, f64)> {
        let under = (4.0 - self.across * self.across) / 3.0;
        (under > 0.0).then(|| {
            let gamma = libm::asin(under.min(1.0).sqrt());
            (gamma, self.turned(2, gamma))
        })
    }

    /// The angle between `from` and `to`, 0..=π/2, at which path `p` is turned by `turned`, if any: it must be monotone there.
    fn root(&self, p: u32, turned: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let off = |gamma: f64| self.turned(p, gamma) - turned;
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
            // Newton's step where it stays within, else half of what is left.
            let next = gamma - found / self.turned_slope(p, gamma);
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            if (next - gamma).abs() < 1e-15 {
                return Some(next);
            }
            gamma = next;
        }
        Some(gamma)
    }

    /// Reflected once within (TRT) towards azimuth `phi`, its caustics spread into `glints`, those of this section. Up to four ways.
    pub fn glinting(&self, phi: f64, glints: Option<&Glints>) -> impl Iterator<Item = Way> + '_ {
        let phi = wrapped(phi);
        let kept = glints.map_or(1.0, |glints| glints.kept(phi));
        // What is taken away wholly may be without bound.
        let own =
            self.within(phi).map(move |way| Way { light: if kept > 0.0 { way.light * kept } else { 0.0 }, ..way });
        let spread = glints.map(|glints| {
            let about =
                gaussian(glints.width, wrapped(phi - glints.phi)) + gaussian(glints.width, wrapped(phi + glints.phi));
            Way { light: glints.light * about, length: glints.length }
        });
        own.chain(spread)
    }

    /// Where the glints of this section are, and what is in each: as much as is taken away about the caustics, times the scale. `None` where it has none.
    pub fn glints(&self, glint: &Glint) -> Option<Glints> {
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
        let taken =
            over_section(|gamma| (1.0 - glints.kept(wrapped(self.turned(2, gamma)))) * self.share(2, libm::cos(gamma)));
        glints.light = 0.25 * glint.scale * taken;
        Some(glints)
    }

    /// The same with as much in each as Marschner 2003 prints: the scale is a number of the fibre (0.5 to 5), whatever the caustic bundles.
    pub fn glints_as_printed(&self, glint: &Glint) -> Option<Glints> {
        let (gamma, bend) = self.caustic().map_or((0.0, 0.0), |(gamma, _)| (gamma, self.caustic_bend(gamma)));
        let bundled = if bend > 0.0 { MOST_BUNDLED.min(2.0 * (2.0 * glint.width / bend).sqrt()) } else { MOST_BUNDLED };
        let light = glint.scale * self.share(2, libm::cos(gamma)) * bundled;
        self.glints(glint).map(|glints| Glints { light: light * glints.share, ..glints })
    }

    /// |d²Φ/dh²| at a caustic.
    fn caustic_bend(&self, gamma: f64) -> f64 {
        let (h, cos) = (libm::sin(gamma), libm::cos(gamma));
        let across = (self.across * self.across - h * h).max(1e-12);
        (4.0 * h / (across * across.sqrt()) - 2.0 * h / (cos * cos * cos)).abs()
    }

    /// Path `p` cut into thin bundles all over the section: the azimuth that each leaves at, and its light with its way.
    pub fn bundles(&self, p: u32) -> impl Iterator<Item = (f64, Way)> + '_ {
        const POINTS: usize = 512;
        (0..POINTS).map(move |k| {
            let gamma = ((k as f64 + 0.5) / POINTS as f64 - 0.5) * PI;
            let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
            let light = 0.5 * self.share(p, cos) * cos * (PI / POINTS as f64);
            let phi = self.turned(p, gamma) + f64::from(p) * PI;
            (phi, Way { light, length: f64::from(p) * self.chord(sin) })
        })
    }

    /// Path `p` towards azimuth `phi` of a fibre that is rough all around: each bundle is spread by a logistic distribution of that scale, radians (Chiang 2016).
    pub fn rough(&self, p: u32, phi: f64, scale: f64) -> impl Iterator<Item = Way> + '_ {
        let spread = move |at: f64| logistic(scale, wrapped(phi - at));
        self.bundles(p).map(move |(at, way)| Way { light: way.light * spread(at), ..way })
    }

    /// All the light that leaves on path `p`, without absorption: ½ ∫ A dh.
    pub fn energy(&self, p: u32) -> f64 {
        0.5 * over_section(|gamma| self.share(p, libm::cos(gamma)))
    }
}

/// A pair of glints of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glints {
    /// Azimuth of one, radians; the other is at its negative.
    pub phi: f64,
    /// Light of each.
    pub light: f64,
    /// Length of its way, over the radius.
    pub length: f64,
    /// How much of what is bundled there they take, 0..=1.
    pub share: f64,
    /// Standard deviation of each, radians.
    pub width: f64,
}

impl Glints {
    /// How much of the light at `phi` stays out of them.
    pub(super) fn kept(&self, phi: f64) -> f64 {
        let of = |x: f64| 1.0 - self.share * libm::exp(-0.5 * (x / self.width) * (x / self.width));
        of(wrapped(phi - self.phi)) * of(wrapped(phi + self.phi))
    }
}

/// A logistic distribution of that scale, cut at ±π and made whole again.
pub fn logistic(scale: f64, x: f64) -> f64 {
    let e = libm::exp(-x.abs() / scale);
    let whole = libm::tanh(0.5 * PI / scale);
    e / (scale * (1.0 + e) * (1.0 + e)) / whole
}

/// ∫ f cos γ dγ over −π/2..=π/2, which is the integral over the offsets h: by Gauss's rule of each half.
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

/// Places and weights of the rule of [`RULE`] points over −1..=1.
pub(super) fn legendre() -> &'static [(f64, f64); RULE] {
    static POINTS: OnceLock<[(f64, f64); RULE]> = OnceLock::new();
    POINTS.get_or_init(|| {
        core::array::from_fn(|i| {
            // Newton's method from a guess that is near enough for each root of the polynomial.
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
