//! Light scattering of a fibre (Marschner 2003; d'Eon 2011; Chiang 2016; broad lights Xu 2011): reflected at its
//! surface (R), transmitted (TT), reflected once inside (TRT), and scattered by a medulla (after Yan 2015).
//!
//! Angles: θ is the inclination to the normal plane of the fibre, positive towards its tip, −π/2..=π/2. φ is the
//! azimuth around the fibre, from incident to outgoing light; 0 is straight back. Both directions point away from the
//! fibre. θd = (θo − θi) / 2. Lengths within the fibre are in radii; its absorption σ is per radius, for each colour.
//!
//! All computations are in f64, because tables are derived from them and the reference renderer uses them. The
//! runtime's frames use lookup tables instead.

pub mod azimuthal;
pub mod broad;
pub mod colour;
pub mod gaussian_light;
pub mod longitudinal;
pub mod means;
pub mod near;
pub mod optics;
pub mod tables;

use azimuthal::{GlintShape, Glints, PathContribution};
use core::array::from_fn;
use glam::DVec3;
use longitudinal::Spread;
use optics::{Medulla, Section};

/// Number of paths: R, TT, TRT, and all light reflected inside more than once, which leaves uniformly in azimuth.
pub const PATHS: usize = 4;
/// Number of the path of light that the medulla scatters. It leaves uniformly in azimuth, after two crossings on
/// average.
pub const SCATTERED: usize = PATHS;

/// Optical properties of a fibre except for its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// Index of refraction, 1.2 to 2; 1.55 for hair.
    pub eta: f64,
    /// Standard deviation of the reflected lobe along the fibre, radians of the half angle (5 to 10 degrees for smooth
    /// hair). Transmitted light spreads half as far, internally reflected light twice as far.
    pub along: f64,
    /// Tilt of the reflected lobe due to the cuticle scales, radians of the half angle, towards the root (5 to 10
    /// degrees).
    pub tilt: f64,
    /// Azimuthal scattering.
    pub around: AzimuthalScattering,
    /// Longitudinal lobe shape.
    pub keeps: LobeShape,
    /// Medulla.
    pub medulla: Medulla,
}

/// Azimuthal scattering of a fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AzimuthalScattering {
    /// Smooth fibre, whose caustics are replaced by glints of this shape.
    Smooth(GlintShape),
    /// Rough fibre, in which each contribution is spread by a logistic distribution of this scale, radians.
    Rough(f64),
}

/// Shape of the lobes along a fibre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeShape {
    /// Energy-conserving lobes ([`Spread::conserving`]).
    Energy,
    /// Marschner's lobes, which are reciprocal: eye and light source can be exchanged ([`Spread::by_half_angle`]).
    Reciprocity,
}

impl Default for Fibre {
    /// Returns the fibre of human hair.
    fn default() -> Self {
        Self {
            eta: 1.55,
            along: 7.5_f64.to_radians(),
            tilt: 3.0_f64.to_radians(),
            around: AzimuthalScattering::Rough(0.12),
            keeps: LobeShape::Energy,
            medulla: Medulla::NONE,
        }
    }
}

/// Angles of two directions relative to a fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles {
    /// Sine and cosine of θi.
    pub from: (f64, f64),
    /// Sine and cosine of θo.
    pub to: (f64, f64),
    /// φ, −π..=π.
    pub phi: f64,
}

/// Lower limit of |l|² |e|², where l and e are the components normal to the fibre of the directions to light and eye.
/// Below it, one of the directions is along the fibre, and φ is 0.
const ALONG: f64 = 1e-12;

impl Angles {
    /// Computes the angles from three unit vectors: along the fibre towards its tip, towards the light, and towards the
    /// eye.
    pub fn between(tip: DVec3, light: DVec3, eye: DVec3) -> Self {
        let split = |way: DVec3| {
            let sin = tip.dot(way).clamp(-1.0, 1.0);
            let across = way - tip * sin;
            (across, (sin, (1.0 - sin * sin).max(0.0).sqrt()))
        };
        let ((l, from), (e, to)) = (split(light), split(eye));
        let phi = if l.length_squared() * e.length_squared() < ALONG {
            0.0
        } else {
            libm::atan2(tip.dot(l.cross(e)), l.dot(e))
        };
        Self { from, to, phi }
    }

    /// Returns cos θd, 0..=1.
    pub fn cos_d(&self) -> f64 {
        let ((sin_i, cos_i), (sin_o, cos_o)) = (self.from, self.to);
        (0.5 * (1.0 + cos_i * cos_o + sin_i * sin_o)).clamp(0.0, 1.0).sqrt()
    }
}

impl Fibre {
    /// Returns the number of paths that carry light.
    pub(crate) fn path_count(&self) -> usize {
        PATHS + usize::from(self.medulla.scatters())
    }

    /// Returns the longitudinal lobe of path `p`; for scattered light, one that is wider than all directions.
    pub fn spread(&self, p: u32) -> Spread {
        if p as usize == SCATTERED {
            return Spread { shift: 0.0, width: 10.0 };
        }
        let (shift, width) = [(-1.0, 1.0), (0.5, 0.5), (1.5, 2.0), (0.0, 2.0)][p.min(3) as usize];
        Spread { shift: shift * self.tilt, width: width * self.along }
    }

    /// Returns the longitudinal factor of each path: the share of light from θi that leaves at θo. Multiplied by the
    /// contributions of [`FibreSection::contributions`], it gives the scattered light times cos θi.
    pub fn along(&self, angles: &Angles) -> [f64; PATHS] {
        from_fn(|p| self.path_along(p as u32, angles))
    }

    /// Returns the longitudinal factor of path `p`, up to [`SCATTERED`].
    pub fn path_along(&self, p: u32, angles: &Angles) -> f64 {
        if p as usize == SCATTERED {
            // A core that sends light evenly in all directions has the brightness of its projected area.
            return angles.from.1 * core::f64::consts::FRAC_2_PI;
        }
        let spread = self.spread(p);
        match self.keeps {
            LobeShape::Energy => spread.conserving(angles.from, angles.to),
            LobeShape::Reciprocity => {
                let cos_d = angles.cos_d().max(optics::LEAST_COS_D);
                let [i, o] = [angles.from, angles.to].map(|(sin, cos)| libm::atan2(sin, cos));
                spread.by_half_angle(i, o) * angles.from.1 / (cos_d * cos_d)
            }
        }
    }

    /// Returns the cross-section for the difference angle with cosine `cos_d`, which is the same at all azimuths.
    pub fn section(&self, cos_d: f64) -> FibreSection {
        let section = Section { medulla: self.medulla, ..Section::new(self.eta, cos_d) };
        let glints = match &self.around {
            AzimuthalScattering::Smooth(glint) => section.glints(glint),
            AzimuthalScattering::Rough(_) => None,
        };
        FibreSection {
            section,
            glints,
            rough: if let AzimuthalScattering::Rough(scale) = self.around { Some(scale) } else { None },
        }
    }

    /// Returns the light scattered from the incident into the outgoing direction, times cos θi, for each colour.
    /// Multiplied by the fibre's diameter, the incident radiance and its solid angle, it gives the radiance that a
    /// fibre adds, integrated over its width.
    ///
    /// * `sigma`: absorption of the fibre per radius, 0 or more
    pub fn scatter(&self, sigma: [f64; 3], angles: &Angles) -> [f64; 3] {
        let (along, section) = (self.along(angles), self.section(angles.cos_d()));
        let mut sum = sigma.map(|sigma| along[3] * section.rest(sigma));
        for (p, along) in along.into_iter().take(3).enumerate() {
            section.contributions(p as u32, angles.phi, &mut |way| {
                for (sum, sigma) in sum.iter_mut().zip(sigma) {
                    *sum += along * way.attenuated(sigma);
                }
            });
        }
        if self.medulla.scatters() {
            let (along, section) = (self.path_along(SCATTERED as u32, angles), self.section(angles.to.1));
            sum.iter_mut().zip(sigma).for_each(|(sum, sigma)| *sum += along * section.scattered(sigma));
        }
        sum
    }
}

/// Fibre at one difference angle.
#[derive(Clone, Copy, Debug)]
pub struct FibreSection {
    /// Cross-section.
    pub section: Section,
    glints: Option<Glints>,
    rough: Option<f64>,
}

impl FibreSection {
    /// Calls `each` with the contributions of path `p` towards azimuth `phi`.
    pub fn contributions(&self, p: u32, phi: f64, each: &mut dyn FnMut(PathContribution)) {
        let section = &self.section;
        match (self.rough, p) {
            (Some(scale), p) => section.rough(p, phi, scale).for_each(each),
            (None, 0) => each(PathContribution { light: section.reflected(phi), length: 0.0 }),
            (None, 1) => each(section.transmitted(phi)),
            (None, _) => section.glinting(phi, self.glints.as_ref()).for_each(each),
        }
    }

    /// Divides path `p` into bundles of rays and calls `each` for every bundle. Its arguments are the exit azimuth, the
    /// standard deviation of the bundle's spread in radians, and the contribution. The spread due to azimuthal
    /// roughness is not included.
    pub fn for_each_bundle(&self, p: u32, each: &mut dyn FnMut(f64, f64, PathContribution)) {
        let section = &self.section;
        let glints = self.glints.as_ref().filter(|_| p == 2);
        for (phi, way) in section.bundles(p) {
            let kept = glints.map_or(1.0, |glints| glints.remaining(azimuthal::wrapped(phi)));
            each(phi, 0.0, PathContribution { light: kept * way.light, ..way });
        }
        if let Some(glints) = glints {
            for phi in [glints.phi, -glints.phi] {
                each(phi, glints.width, PathContribution { light: glints.light, length: glints.length });
            }
        }
    }

    /// Returns the light per radian that is reflected inside more than once, if the fibre absorbs `sigma` per radius.
    pub fn rest(&self, sigma: f64) -> f64 {
        let section = &self.section;
        let left = azimuthal::over_section(|gamma| {
            let sin = libm::sin(gamma);
            let through = libm::exp(-sigma * section.chord(sin)) * section.unscattered(sin);
            section.rest(section.fresnel(libm::cos(gamma)), through)
        });
        0.5 * left / core::f64::consts::TAU
    }

    /// Returns the light per radian that the medulla scatters, if the fibre absorbs `sigma` per radius.
    pub fn scattered(&self, sigma: f64) -> f64 {
        let section = &self.section;
        if !section.medulla.scatters() {
            return 0.0;
        }
        let left = azimuthal::over_section(|gamma| {
            let (sin, cos) = (libm::sin(gamma), libm::cos(gamma));
            section.scattered(sin, cos) * libm::exp(-2.0 * sigma * section.chord(sin))
        });
        0.5 * left / core::f64::consts::TAU
    }

    /// Returns the light per radian that is reflected inside more than once, without absorption. The path length of the
    /// result is the effective length at absorption `sigma`.
    pub fn mean_rest(&self, sigma: f64) -> PathContribution {
        mean_of(self.rest(0.0), self.rest(sigma), sigma)
    }

    /// Returns the same as [`FibreSection::mean_rest`] for light that the medulla scatters.
    pub fn mean_scattered(&self, sigma: f64) -> PathContribution {
        mean_of(self.scattered(0.0), self.scattered(sigma), sigma)
    }

    /// Returns [`FibreSection::mean_contribution`] of path `p` at many azimuths.
    pub fn mean_contributions(&self, p: u32, phis: &[f64], sigma: f64) -> Vec<PathContribution> {
        let Some(scale) = self.rough else {
            return phis.iter().map(|phi| self.mean_contribution(p, *phi, sigma)).collect();
        };
        // Terms that do not depend on the azimuth are computed once.
        let bundles: Vec<_> = self.section.bundles(p).map(|(at, way)| (at, way.light, way.attenuated(sigma))).collect();
        let logistic = azimuthal::Logistic::new(scale);
        let mean = |phi: &f64| {
            let (mut light, mut left) = (0.0, 0.0);
            for (at, of, of_left) in &bundles {
                let spread = logistic.density(azimuthal::wrapped(phi - at));
                (light, left) = (light + of * spread, left + of_left * spread);
            }
            mean_of(light, left, sigma)
        };
        phis.iter().map(mean).collect()
    }

    /// Returns the total light of path `p` towards azimuth `phi`, without absorption. The path length of the result is
    /// the effective length at absorption `sigma`.
    pub fn mean_contribution(&self, p: u32, phi: f64, sigma: f64) -> PathContribution {
        let (mut light, mut left) = (0.0, 0.0);
        self.contributions(p, phi, &mut |way| {
            light += way.light;
            left += way.attenuated(sigma);
        });
        mean_of(light, left, sigma)
    }
}

/// Returns the single contribution that has the given light without absorption, and the light `left` at absorption
/// `sigma`.
fn mean_of(light: f64, left: f64, sigma: f64) -> PathContribution {
    if light <= 0.0 || left <= 0.0 {
        return PathContribution::default();
    }
    PathContribution { light, length: (libm::log(light / left) / sigma).max(0.0) }
}

#[cfg(test)]
mod tests;
