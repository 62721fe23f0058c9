//! A panorama as few lights.

use super::lobes::{Cells, Chosen};
use super::panorama::Panorama;
use super::sun;
use glam::DVec3;
use pelage_formats::meaning::environment::{Environment, LightLobe, brightness};

/// How a panorama is taken for an [`Environment`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitParams {
    /// Most lobes, up to [`Environment::MOST_LOBES`] (default 16).
    pub lobes: usize,
    /// Least share of all light that a sun has to have to be a light of its own (default 0.1); more than 1 for no sun.
    pub sun: f64,
}

impl Default for FitParams {
    fn default() -> Self {
        Self { lobes: 16, sun: 0.1 }
    }
}

/// A panorama as lights, and how near they come.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The lights.
    pub environment: Environment,
    /// Share of all its light that the sun has.
    pub sun_share: f64,
    /// Light of the lobes and of what is even over that of the sky without its sun, less 1, where it is farthest from 0 of the three colours.
    pub energy: f64,
    /// Root of the mean square of what they differ by from the sky without its sun over that of this sky, both over its cells of 5.6 degrees.
    pub error: f64,
    /// Pixels of the panorama that were no light.
    pub mended: u32,
}

/// Width and height of the picture that lights are fitted to: 5.6 degrees a cell, below the least width of a lobe.
const CELLS: (u32, u32) = (64, 32);
/// Times that all lobes are moved to where they fit best, after each new one.
const MOVES_OF_EACH: usize = 4;
/// And once all are there.
const MOVES_OF_ALL: usize = 8;

impl Panorama {
    /// The lights that come nearest to it, by least squares of radiance over solid angle. The same picture gives the same lights on every machine.
    pub fn fit(&self, params: FitParams) -> Fitted {
        let whole = self.whole();
        let (sun, without) = sun::split(self, params.sun);
        let cells = Cells::new(&without.reduced(CELLS));
        let mut chosen = Chosen::new(&cells);
        for _ in 0..params.lobes.min(Environment::MOST_LOBES) {
            if !chosen.add_best() {
                break;
            }
            // What a lobe far from its place leaves would draw the next ones to it.
            (0..MOVES_OF_EACH).for_each(|_| chosen.move_all());
        }
        (0..MOVES_OF_ALL).for_each(|_| chosen.move_all());
        let lobe = |(light, radiance): (_, DVec3)| {
            let (towards, width_deg): (DVec3, f32) = light;
            LightLobe { towards: towards.as_vec3().into(), width_deg, radiance: radiance.as_vec3().into() }
        };
        let (even, lobes) = chosen.lights();
        let mut lobes: Vec<LightLobe> = lobes.map(lobe).filter(|lobe| lobe.radiance != [0.0; 3]).collect();
        // The brightest first: what is cut off is what matters least.
        lobes.sort_by(|a, b| brightness(b.whole()).total_cmp(&brightness(a.whole())));
        let sun_light = sun.map_or(0.0, |sun| brightness(DVec3::from(sun.color.map(f64::from))) * std::f64::consts::PI);
        let mut environment = Environment { even: even.as_vec3().into(), sun: None, lobes };
        let rest = without.whole();
        // Squares alone leave light in whole as it is only where what is even has some of each colour.
        let scale = (rest / environment.whole().max(DVec3::splat(1e-300))).as_vec3().to_array();
        let scaled = |color: [f32; 3]| std::array::from_fn(|i| color[i] * scale[i]);
        environment.even = scaled(environment.even);
        environment.lobes.iter_mut().for_each(|lobe| lobe.radiance = scaled(lobe.radiance));
        let part = (environment.whole() - rest).abs() / rest.max(DVec3::splat(1e-300));
        let energy = if rest.max_element() > 0.0 { part.max_element() } else { 0.0 };
        let error = chosen.error();
        Fitted {
            environment: Environment { sun, ..environment },
            sun_share: if brightness(whole) > 0.0 { sun_light / brightness(whole) } else { 0.0 },
            energy,
            error,
            mended: self.mended(),
        }
    }
}
