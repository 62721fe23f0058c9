//! Approximates a panorama by a small set of lights.

use super::lobes::{Cells, LobeSelection};
use super::panorama::Panorama;
use super::sun;
use glam::DVec3;
use pelage_formats::meaning::environment::{Environment, LightLobe};
use pelage_formats::meaning::luminance;

/// Settings for fitting an [`Environment`] to a panorama.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitParams {
    /// Maximum number of lobes, up to [`Environment::MOST_LOBES`] (default 16).
    pub lobes: usize,
    /// Minimum fraction of all light from which a sun becomes a separate light (default 0.1). More than 1 disables the
    /// sun.
    pub sun: f64,
}

impl Default for FitParams {
    fn default() -> Self {
        Self { lobes: 16, sun: 0.1 }
    }
}

/// Lights fitted to a panorama, and the errors of the fit.
#[derive(Clone, Debug, PartialEq)]
pub struct FitResult {
    /// Fitted lights.
    pub environment: Environment,
    /// Fraction of all light that comes from the sun.
    pub sun_share: f64,
    /// Relative error of the fitted total light: lobes plus uniform light, compared with the sky without its sun.
    /// Maximum of the three colour channels.
    pub energy: f64,
    /// Root mean square error of the fitted lights, compared with the sky without its sun. It is relative to the root
    /// mean square of that sky. Both are over cells of 5.6 degrees.
    pub error: f64,
    /// Number of invalid panorama pixels that were repaired.
    pub repaired_pixels: u32,
}

/// Width and height of the reduced picture to which lights are fitted. A cell of 5.6 degrees is smaller than the
/// minimum width of a lobe.
const CELLS: (u32, u32) = (64, 32);
/// Number of optimisation passes over all lobes after each new one.
const MOVES_OF_EACH: usize = 4;
/// Number of additional optimisation passes once all lobes exist.
const MOVES_OF_ALL: usize = 8;

impl Panorama {
    /// Fits lights to the panorama by least squares of radiance over solid angle. The result is the same on every
    /// machine.
    pub fn fit(&self, params: FitParams) -> FitResult {
        let whole = self.total();
        let (sun, without) = sun::split(self, params.sun);
        let cells = Cells::new(&without.reduced(CELLS));
        let mut chosen = LobeSelection::new(&cells);
        for _ in 0..params.lobes.min(Environment::MOST_LOBES) {
            if !chosen.add_best() {
                break;
            }
            // Moves the lobes now, because the residual of a misplaced lobe would attract the next ones.
            (0..MOVES_OF_EACH).for_each(|_| chosen.move_all());
        }
        (0..MOVES_OF_ALL).for_each(|_| chosen.move_all());
        let lobe = |(light, radiance): (_, DVec3)| {
            let (towards, width_deg): (DVec3, f32) = light;
            LightLobe { towards: towards.as_vec3().into(), width_deg, radiance: radiance.as_vec3().into() }
        };
        let (even, lobes) = chosen.lights();
        let mut lobes: Vec<LightLobe> = lobes.map(lobe).filter(|lobe| lobe.radiance != [0.0; 3]).collect();
        // Brightest first, so that truncation drops the least important lobes.
        lobes.sort_by(|a, b| luminance(b.integral()).total_cmp(&luminance(a.integral())));
        let sun_light = sun.map_or(0.0, |sun| luminance(DVec3::from(sun.color.map(f64::from))) * std::f64::consts::PI);
        let mut environment = Environment { even: even.as_vec3().into(), sun: None, lobes };
        let rest = without.total();
        // Least squares preserve the total light only if the uniform light is above zero in each colour channel.
        let scale = (rest / environment.total().max(DVec3::splat(1e-300))).as_vec3().to_array();
        let scaled = |color: [f32; 3]| std::array::from_fn(|i| color[i] * scale[i]);
        environment.even = scaled(environment.even);
        environment.lobes.iter_mut().for_each(|lobe| lobe.radiance = scaled(lobe.radiance));
        let part = (environment.total() - rest).abs() / rest.max(DVec3::splat(1e-300));
        let energy = if rest.max_element() > 0.0 { part.max_element() } else { 0.0 };
        let error = chosen.error();
        FitResult {
            environment: Environment { sun, ..environment },
            sun_share: if luminance(whole) > 0.0 { sun_light / luminance(whole) } else { 0.0 },
            energy,
            error,
            repaired_pixels: self.mended(),
        }
    }
}
