//! Topic `environment-fit`: accuracy and cost of fitting a few lights to an environment map, by the number of lights.

use super::skies::NamedSky;
use super::{Cell, Panel};
use glam::DVec3;
use pelage_formats::meaning::luminance;
use pelage_stage::sky::{Environment, FitParams, FitResult, Panorama};

/// Numbers of lobes.
pub const LOBES: [usize; 9] = [0, 1, 2, 4, 8, 12, 16, 24, 32];

/// Columns of the chart.
///
/// * `sky`: name of the environment map. `lobes`: number requested.
/// * `error_percent`: relative RMS error of the radiance without the sun, over cells of 5.6 degrees.
/// * `irradiance_percent`: relative RMS error of a surface's irradiance, sun included, over all normals. This error is
///   visible in fur; the others describe only the fit.
/// * `energy_percent`: total light without the sun divided by the map's, minus 1, for the colour with the largest
///   error. `sun_percent`: fraction of all light that comes from the sun.
/// * `seconds`: duration of the fit. `bytes`: size of the lights as 32-bit numbers.
pub const COLUMNS: [&str; 8] =
    ["sky", "lobes", "error_percent", "irradiance_percent", "energy_percent", "sun_percent", "seconds", "bytes"];

/// Panels of the chart.
pub const PANELS: [Panel; 3] = [
    panel("lobes", "lobes", "error_percent", "relative L2 error of radiance, %"),
    panel("lobes", "lobes", "irradiance_percent", "relative error of irradiance, %"),
    panel("seconds", "fit time, seconds", "irradiance_percent", "relative error of irradiance, %"),
];

const fn panel(cost: &'static str, cost_label: &'static str, error: &'static str, error_label: &'static str) -> Panel {
    Panel { cost, cost_label, error, error_label, only: None }
}

/// Number of surface normals.
const NORMALS: u32 = 256;

/// Returns irradiance / π of a surface for each normal, integrated over the environment map itself.
pub fn true_irradiance(panorama: &Panorama) -> Vec<DVec3> {
    let cells = panorama.reduced((256, 128));
    let (width, height) = cells.size();
    let lights: Vec<(DVec3, DVec3)> = (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| (cells.towards(column, row), cells.at(column, row) * cells.solid_angle(row)))
        .collect();
    irradiance_by_lights(&lights, None)
}

fn irradiance_by_lights(lights: &[(DVec3, DVec3)], environment: Option<&Environment>) -> Vec<DVec3> {
    let normals = (0..NORMALS).map(|i| even_direction(i, NORMALS));
    let sun = environment.and_then(|environment| environment.sun);
    let of = |normal: DVec3| {
        let sum: DVec3 = lights.iter().map(|(way, light)| *light * normal.dot(*way).max(0.0)).sum();
        let sun = sun.map_or(DVec3::ZERO, |sun| {
            let towards = DVec3::from(sun.towards.map(f64::from)).normalize_or(DVec3::Y);
            DVec3::from(sun.color.map(f64::from)) * normal.dot(towards).max(0.0)
        });
        sum / std::f64::consts::PI + sun
    };
    normals.map(of).collect()
}

/// Returns direction `i` of `count` directions spread evenly over the sphere.
pub(super) fn even_direction(i: u32, count: u32) -> DVec3 {
    let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
    let turn = 2.399_963_229_728_653 * f64::from(i);
    let out = (1.0 - y * y).sqrt();
    DVec3::new(out * libm::cos(turn), y, out * libm::sin(turn))
}

/// Fits the given number of lobes to an environment map.
pub fn fit(sky: &NamedSky, lobes: usize) -> FitResult {
    sky.panorama.fit(FitParams { lobes, ..FitParams::default() })
}

/// Returns the cells of a row, in the order of [`COLUMNS`].
///
/// * `truth`: result of [`true_irradiance`]
pub fn cells(sky: &NamedSky, lobes: usize, fitted: &FitResult, truth: &[DVec3], seconds: f64) -> Vec<Cell> {
    const DIRECTIONS: u32 = 8192;
    let each = 4.0 * std::f64::consts::PI / f64::from(DIRECTIONS);
    let environment = &fitted.environment;
    let lights: Vec<(DVec3, DVec3)> = (0..DIRECTIONS)
        .map(|i| even_direction(i, DIRECTIONS))
        .map(|way| (way, environment.radiance(way) * each))
        .collect();
    let found = irradiance_by_lights(&lights, Some(environment));
    let wrong: f64 = found.iter().zip(truth).map(|(a, b)| luminance(*a - *b).powi(2)).sum();
    let whole: f64 = truth.iter().map(|of| luminance(*of).powi(2)).sum();
    let irradiance = (wrong / whole.max(1e-300)).sqrt();
    let percent = |x: f64| Cell::Number(100.0 * x);
    // Number of floats: uniform light, lobes, and the sun if there is one.
    let numbers = 3 + 7 * environment.lobes.len() + environment.sun.map_or(0, |_| 6);
    vec![
        Cell::Text(sky.name.clone()),
        Cell::Number(lobes as f64),
        percent(fitted.error),
        percent(irradiance),
        percent(fitted.energy.abs()),
        percent(fitted.sun_share),
        Cell::Number(seconds),
        Cell::Number(4.0 * numbers as f64),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::skies::painted;
    use super::*;

    #[test]
    fn more_lobes_reduce_the_error() {
        for sky in painted().expect("skies") {
            let truth = true_irradiance(&sky.panorama);
            let of = |lobes| {
                let fitted = fit(&sky, lobes);
                let cells = cells(&sky, lobes, &fitted, &truth, 0.1);
                assert_eq!(cells.len(), COLUMNS.len());
                [2, 3, 4].map(|i| cells[i].number().expect("a number"))
            };
            let [few, many] = [2, 16].map(of);
            assert!(many[0] < few[0] && many[1] < few[1], "{}: {few:?}, {many:?}", sky.name);
            assert!(many[1] < 8.0 && many[2] < 0.1, "{}: {many:?}", sky.name);
        }
    }
}
