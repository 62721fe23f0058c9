//! Topic `environment`: accuracy and cost of lighting fibres by maps ([`MapLighting`]) and single lights
//! ([`SingleLighting`]). The truth is the integral of map times scattering over directions that a body of usual
//! curvature does not hide. No other hair occludes. If lights are fitted to a map, its sun stays an exact light.

use super::environment_fit::even_direction;
use super::skies::NamedSky;
use super::{Cell, Panel};
use crate::printed_light::PrintedLight;
use glam::DVec3;
use pelage_bake::noise::{hash, uniform};
use pelage_formats::FibreOptics;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::meaning::luminance;
use pelage_formats::meaning::scattering::azimuthal::GlintShape;
use pelage_formats::meaning::scattering::broad::{
    BroadSize, BroadTables, CutGaussianLight, HORIZON_SINE, LEAST_MEAN, cut_gaussian_mean_cosine,
};
use pelage_formats::meaning::scattering::gaussian_light::{BroadlyLitFibre, GaussianLight};
use pelage_formats::meaning::scattering::optics::Medulla;
use pelage_formats::meaning::scattering::{Angles, AzimuthalScattering, Fibre};
use pelage_stage::sky::{FitParams, Panorama};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of hair points evaluated under each environment map.
const POINTS: usize = 160;
/// Absorption of the fibres per radius: blond and brown.
const SIGMAS: [f64; 2] = [0.1, 0.5];
/// Fibres under environment maps: human hair, soft hair, and matt wool.
const FIBRES: [FibreOptics; 3] = [
    FibreOptics { eta: 1.55, along: 0.13, tilt: 0.05, around: 0.12, medulla: Medulla::NONE },
    FibreOptics { eta: 1.45, along: 0.2, tilt: 0.05, around: 0.2, medulla: Medulla::NONE },
    FibreOptics { eta: 1.55, along: 0.35, tilt: 0.0, around: 0.5, medulla: Medulla::NONE },
];
/// Columns and rows of cells over which the truth is summed.
const CELLS: (u32, u32) = (64, 32);
/// Number of columns and of rows into which a bright cell is divided, if the map has enough pixels.
const PARTED: u32 = 6;
/// Fraction of all light above which a cell counts as bright.
const BRIGHT: f64 = 0.004;
/// Number of directions at which the light of an environment is evaluated and summed, as in frames.
const DIRECTIONS: u32 = 1024;

/// Columns of the chart.
///
/// * `sky`: name of the environment map, or width of a single light, degrees.
/// * `error_percent`: relative RMS error of the luminance over all points. `mean_percent`: relative error of the mean.
/// * `microseconds`: time per point on one core, memory reads included. `bytes`: size of one fibre's tables.
/// * `fetches`: texture samples per point in a frame.
pub const COLUMNS: [&str; 6] = ["sky", "error_percent", "mean_percent", "microseconds", "fetches", "bytes"];

/// Panels of the chart.
pub const PANELS: [Panel; 2] =
    [panel("microseconds", "µs per point, one core"), panel("fetches", "fetches per point and frame")];

const fn panel(cost: &'static str, cost_label: &'static str) -> Panel {
    Panel { cost, cost_label, error: "error_percent", error_label: "relative L2 error, %", only: None }
}

/// Method of lighting a fibre by an environment map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MapLighting {
    /// Single light along the mean direction above the surface, by tables; arguments: number of lobes, table size.
    OneLight(usize, BroadSize),
    /// Fitted lights with the given number of lobes, each lobe evaluated by the tables.
    Tables(usize),
    /// Fitted lights with the given number of lobes, each lobe integrated exactly.
    Exact(usize),
    /// Fitted lights with the given number of lobes, each lobe in the published form (after Xu 2011).
    Printed(usize),
    /// The given number of directions, sampled from the map in proportion to luminance.
    Samples(usize),
    /// Mean radiance of the map over all directions, as constant light.
    Constant,
}

/// Method of lighting a fibre by a single light that no mesh surface hides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SingleLighting {
    /// Exact integral over the light.
    Exact,
    /// Tables, which cover only about the half sphere around the light's centre.
    Tables,
    /// Published form (after Xu 2011).
    Printed,
}

/// Standard deviations of the single lights, degrees.
pub const WIDTHS: [f64; 5] = [8.0, 10.0, 20.0, 40.0, 80.0];

/// Parameters of one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentConfiguration {
    /// Index of an environment map, and the method.
    Sky(usize, MapLighting),
    /// Width of a single light in degrees, and the method.
    Single(f64, SingleLighting),
}

fn default_size() -> BroadSize {
    BroadSize::default()
}

/// Lists what to measure, for `skies` environment maps.
pub fn configurations(skies: usize) -> Vec<EnvironmentConfiguration> {
    let size = |means, to, from, phi| BroadSize { means, to, from, phi };
    let mut forms: Vec<MapLighting> = [4, 8, 16, 32].map(|lobes| MapLighting::OneLight(lobes, default_size())).into();
    forms.extend(
        [size(4, 12, 12, 8), size(8, 32, 32, 24), size(12, 48, 48, 32)].map(|size| MapLighting::OneLight(16, size)),
    );
    forms.extend([4, 8, 16, 32].map(MapLighting::Tables));
    forms.extend([4, 16].map(MapLighting::Exact));
    forms.extend([4, 16].map(MapLighting::Printed));
    forms.extend([16, 64, 256].map(MapLighting::Samples));
    forms.push(MapLighting::Constant);
    let mut all: Vec<_> =
        (0..skies).flat_map(|sky| forms.iter().map(move |form| EnvironmentConfiguration::Sky(sky, *form))).collect();
    for width in WIDTHS {
        all.extend(
            [SingleLighting::Exact, SingleLighting::Tables, SingleLighting::Printed]
                .map(|form| EnvironmentConfiguration::Single(width, form)),
        );
    }
    all
}

impl EnvironmentConfiguration {
    /// Returns the name of the varied setting, and its value.
    pub fn labels(&self) -> (&'static str, String) {
        let lobes = |n: usize| format!("{n} lobes");
        match self {
            Self::Sky(_, form) => match form {
                MapLighting::OneLight(n, size) if *size == default_size() => ("one broad light", lobes(*n)),
                MapLighting::OneLight(_, BroadSize { means, to, from, phi }) => {
                    ("one broad light, tables", format!("{means}x{to}x{from}x{phi}"))
                }
                MapLighting::Tables(n) => ("a lobe at a time, tables", lobes(*n)),
                MapLighting::Exact(n) => ("a lobe at a time, exact", lobes(*n)),
                MapLighting::Printed(n) => ("a lobe at a time, as published", lobes(*n)),
                MapLighting::Samples(n) => ("samples by luminance", n.to_string()),
                MapLighting::Constant => ("constant ambient light", String::new()),
            },
            Self::Single(_, SingleLighting::Exact) => ("a single light, exact", String::new()),
            Self::Single(_, SingleLighting::Tables) => ("a single light, tables", String::new()),
            Self::Single(_, SingleLighting::Printed) => ("a single light, as published", String::new()),
        }
    }

    /// Returns whether frames use this method.
    pub fn is_default(&self) -> bool {
        matches!(self, Self::Sky(_, MapLighting::OneLight(16, size)) if *size == default_size())
    }

    /// Returns the number of texture fetches per point in a frame.
    fn fetches(&self) -> Option<usize> {
        // Three fetches give the total light, its direction and its irradiance. Four more interpolate the tables
        // between two means and two angles to the eye. Each sampled direction needs one fetch from each of two tables.
        match self {
            Self::Sky(_, MapLighting::OneLight(..)) => Some(3 + 4),
            Self::Sky(_, MapLighting::Tables(n)) => Some(4 * (n + 1)),
            Self::Sky(_, MapLighting::Samples(n)) => Some(2 * n),
            Self::Sky(_, MapLighting::Constant) => Some(4),
            Self::Sky(_, MapLighting::Exact(_) | MapLighting::Printed(_)) | Self::Single(..) => None,
        }
    }

    fn bytes(&self) -> Option<usize> {
        match self {
            Self::Sky(_, MapLighting::OneLight(_, size)) => Some(8 * size.texels()),
            Self::Sky(_, MapLighting::Tables(_) | MapLighting::Constant) => Some(8 * default_size().texels()),
            _ => None,
        }
    }
}

/// Point on a hair, with unit vectors along the hair to its tip and from the point to the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    fibre: usize,
    sigma: f64,
    normal: DVec3,
    tip: DVec3,
    eye: DVec3,
}

/// Returns points on hair leaning by up to 80 degrees, seen from above, on surfaces with normals in all directions.
fn points() -> Vec<Point> {
    let random = |number: usize, what: u64| f64::from(uniform(hash(0x5e5, number as u64), what));
    let about = |normal: DVec3, cosine: f64, turn: f64| {
        let (a, b) = normal.any_orthonormal_pair();
        let out = (1.0 - cosine * cosine).max(0.0).sqrt();
        normal * cosine + (a * libm::cos(turn) + b * libm::sin(turn)) * out
    };
    let point = |number: usize| {
        let normal = even_direction(number as u32, POINTS as u32);
        Point {
            fibre: number % FIBRES.len(),
            sigma: SIGMAS[number / FIBRES.len() % SIGMAS.len()],
            normal,
            tip: about(normal, libm::cos(1.4 * random(number, 0)), 2.0 * PI * random(number, 1)),
            eye: about(normal, random(number, 2), 2.0 * PI * random(number, 3)),
        }
    };
    (0..POINTS).map(point).collect()
}

fn smooth(width_deg: f64, optics: &FibreOptics) -> Fibre {
    Fibre {
        around: AzimuthalScattering::Smooth(GlintShape { width: width_deg.to_radians(), ..GlintShape::default() }),
        ..optics.fibre()
    }
}

/// Returns the light that a fibre scatters to the eye from the direction `towards`.
fn scatter_from(fibre: &Fibre, point: &Point, towards: DVec3) -> f64 {
    fibre.scatter([point.sigma; 3], &Angles::between(point.tip, towards, point.eye))[0]
}

/// Filters lights, given as direction and luminance, to those visible from hair on a surface with this normal.
fn above<'a>(lights: &'a [(DVec3, f64)], normal: DVec3) -> impl Iterator<Item = (DVec3, f64)> + 'a {
    lights.iter().copied().filter(move |(way, _)| normal.dot(*way) > -HORIZON_SINE)
}

/// True scattered light at each point under an environment map.
pub struct EnvironmentTruth {
    points: Vec<Point>,
    cells: Vec<(DVec3, f64)>,
    expected: Vec<f64>,
    mean_radiance: f64,
}

impl EnvironmentTruth {
    /// Computes the truth under an environment map.
    pub fn new(sky: &NamedSky) -> Self {
        let points = points();
        let cells = cells_of(&sky.panorama);
        let fibres = FIBRES.map(|optics| optics.fibre());
        let of = |point: &Point| {
            let fibre = &fibres[point.fibre];
            above(&cells, point.normal).map(|(way, light)| light * scatter_from(fibre, point, way)).sum()
        };
        let expected = points.par_iter().map(of).collect();
        let mean_radiance = luminance(sky.panorama.total()) / (4.0 * PI);
        Self { points, cells, expected, mean_radiance }
    }
}

/// Returns the directions of an environment map's cells, with the light from each as luminance.
fn cells_of(panorama: &Panorama) -> Vec<(DVec3, f64)> {
    let (coarse, fine) = (panorama.reduced(CELLS), panorama.reduced((PARTED * CELLS.0, PARTED * CELLS.1)));
    let of = |cells: &Panorama, x: u32, y: u32| (cells.towards(x, y), luminance(cells.at(x, y)) * cells.solid_angle(y));
    let (width, height) = coarse.size();
    let parted = if fine.size() == (PARTED * width, PARTED * height) { PARTED } else { 1 };
    let bright = BRIGHT * luminance(panorama.total());
    let mut out = Vec::new();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let whole = of(&coarse, x, y);
        if whole.1 <= bright || parted == 1 {
            out.push(whole);
            continue;
        }
        let places = (0..parted).flat_map(|j| (0..parted).map(move |i| (parted * x + i, parted * y + j)));
        out.extend(places.map(|(x, y)| of(&fine, x, y)));
    }
    out
}

/// Error of a method, and its time per point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnvironmentAccuracy {
    /// Relative L2 error.
    pub error: f64,
    /// Mean divided by the truth's mean, minus 1.
    pub mean: f64,
    /// Seconds per point.
    pub seconds: f64,
}

fn accuracy(pairs: &[(f64, f64)], seconds: f64) -> EnvironmentAccuracy {
    let sum = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>();
    EnvironmentAccuracy {
        error: (sum(|(found, truth)| (found - truth) * (found - truth)) / sum(|(_, truth)| truth * truth)).sqrt(),
        mean: sum(|(found, _)| *found) / sum(|(_, truth)| *truth) - 1.0,
        seconds,
    }
}

/// Returns `of` for 0..`count`, and the seconds per call of the fastest of three runs (one run if over 0.5 s).
fn timed(count: usize, mut of: impl FnMut(usize) -> f64) -> (Vec<f64>, f64) {
    let (mut values, mut fastest) = (Vec::new(), f64::INFINITY);
    for _ in 0..3 {
        let begun = std::time::Instant::now();
        values = (0..count).map(|i| std::hint::black_box(of(i))).collect();
        fastest = fastest.min(begun.elapsed().as_secs_f64());
        if fastest > 0.5 {
            break;
        }
    }
    (values, fastest / count as f64)
}

/// Measures a method under an environment map.
pub fn measure_map(form: MapLighting, sky: &NamedSky, truth: &EnvironmentTruth) -> EnvironmentAccuracy {
    let fit = |lobes| sky.panorama.fit(FitParams { lobes, ..FitParams::default() }).environment;
    let fibres = FIBRES.map(|optics| optics.fibre());
    let sun_of = |environment: &Environment, point: &Point| {
        environment.sun.map_or(0.0, |sun| {
            let towards = DVec3::from(sun.towards.map(f64::from)).normalize_or(DVec3::Y);
            let light = PI * luminance(DVec3::from(sun.color.map(f64::from)));
            if point.normal.dot(towards) > -HORIZON_SINE {
                light * scatter_from(&fibres[point.fibre], point, towards)
            } else {
                0.0
            }
        })
    };
    let tables_of = |size| FIBRES.map(|optics| BroadTables::new(&optics.fibre(), size));
    let points = &truth.points;
    let (values, seconds) = match form {
        MapLighting::OneLight(lobes, size) => {
            let (environment, tables) = (fit(lobes), tables_of(size));
            let lights = directions(&environment);
            let means: Vec<(f64, DVec3)> = points.iter().map(|point| mean_of(&lights, point.normal)).collect();
            timed(points.len(), |i| {
                let (point, (whole, middle)) = (&points[i], means[i]);
                let light = CutGaussianLight {
                    towards: middle.normalize_or(point.normal),
                    mean: middle.length().clamp(LEAST_MEAN, 1.0),
                };
                let sent = tables[point.fibre].scatter([point.sigma; 3], point.tip, &light, point.eye)[0];
                whole / light.integral() * sent + sun_of(&environment, point)
            })
        }
        MapLighting::Tables(lobes) => {
            let (environment, tables) = (fit(lobes), tables_of(default_size()));
            let shares = shares(&environment, points);
            timed(points.len(), |i| {
                let point = &points[i];
                let tables = &tables[point.fibre];
                let of = |light: &CutGaussianLight| tables.scatter([point.sigma; 3], point.tip, light, point.eye)[0];
                let lobe = |(lobe, share): (&pelage_stage::sky::LightLobe, &f64)| {
                    let light = lobe.light();
                    let half =
                        CutGaussianLight { towards: light.towards, mean: cut_gaussian_mean_cosine(light.sharpness) };
                    share * radiance(lobe) * light.integral() / half.integral() * of(&half)
                };
                environment.lobes.iter().zip(&shares[i]).map(lobe).sum::<f64>()
                    + luminance(DVec3::from(environment.even.map(f64::from)))
                        * of(&CutGaussianLight { towards: point.normal, mean: LEAST_MEAN })
                    + sun_of(&environment, point)
            })
        }
        MapLighting::Exact(lobes) => {
            let exact = fibres.map(|fibre| BroadlyLitFibre::new(&fibre));
            by_lobes(&fit(lobes), points, &sun_of, &|point, light| {
                exact[point.fibre].scatter([point.sigma; 3], point.tip, light, point.eye)[0]
            })
        }
        MapLighting::Printed(lobes) => {
            let printed = fibres.map(|fibre| SIGMAS.map(|sigma| PrintedLight::new(&to_smooth(&fibre), sigma)));
            by_lobes(&fit(lobes), points, &sun_of, &|point, light| {
                let sigma = SIGMAS.iter().position(|sigma| *sigma == point.sigma).unwrap_or(0);
                printed[point.fibre][sigma].scatter(point.tip, light, point.eye)
            })
        }
        MapLighting::Samples(count) => {
            let all: f64 = truth.cells.iter().map(|(_, light)| light).sum();
            let mut sums = Vec::with_capacity(truth.cells.len());
            let mut sum = 0.0;
            for (_, light) in &truth.cells {
                sum += light;
                sums.push(sum);
            }
            timed(points.len(), |i| {
                let (point, seed) = (&points[i], hash(0xa11, i as u64));
                let sample = |k: usize| {
                    let place = (k as f64 + f64::from(uniform(seed, k as u64))) / count as f64 * all;
                    let cell = sums.partition_point(|sum| *sum < place).min(sums.len() - 1);
                    let towards = truth.cells[cell].0;
                    if point.normal.dot(towards) > -HORIZON_SINE {
                        scatter_from(&fibres[point.fibre], point, towards)
                    } else {
                        0.0
                    }
                };
                (0..count).map(sample).sum::<f64>() * all / count as f64
            })
        }
        MapLighting::Constant => {
            let tables = tables_of(default_size());
            timed(points.len(), |i| {
                let point = &points[i];
                let light = CutGaussianLight { towards: point.normal, mean: LEAST_MEAN };
                truth.mean_radiance * tables[point.fibre].scatter([point.sigma; 3], point.tip, &light, point.eye)[0]
            })
        }
    };
    let pairs: Vec<(f64, f64)> = values.into_iter().zip(truth.expected.iter().copied()).collect();
    accuracy(&pairs, seconds)
}

/// Converts a rough fibre to what the published form handles: a smooth fibre with glints of the same width.
fn to_smooth(fibre: &Fibre) -> Fibre {
    match fibre.around {
        AzimuthalScattering::Rough(scale) => {
            let width = scale * PI / 3.0_f64.sqrt();
            Fibre { around: AzimuthalScattering::Smooth(GlintShape { width, ..GlintShape::default() }), ..*fibre }
        }
        AzimuthalScattering::Smooth(_) => *fibre,
    }
}

fn radiance(lobe: &pelage_stage::sky::LightLobe) -> f64 {
    luminance(DVec3::from(lobe.radiance.map(f64::from)))
}

/// Returns an environment without its sun, as directions with their luminance.
fn directions(environment: &Environment) -> Vec<(DVec3, f64)> {
    let each = 4.0 * PI / f64::from(DIRECTIONS);
    let ways = (0..DIRECTIONS).map(|i| even_direction(i, DIRECTIONS));
    ways.map(|way| (way, luminance(environment.radiance(way)) * each)).collect()
}

/// Returns the total light that reaches hair on a surface with this normal, and the light's mean direction.
fn mean_of(lights: &[(DVec3, f64)], normal: DVec3) -> (f64, DVec3) {
    let (whole, middle) = above(lights, normal)
        .fold((0.0, DVec3::ZERO), |(whole, middle), (way, light)| (whole + light, middle + way * light));
    (whole, middle / whole.max(1e-300))
}

/// Returns, for each point, the visible fraction of each lobe.
fn shares(environment: &Environment, points: &[Point]) -> Vec<Vec<f64>> {
    let lobes: Vec<Vec<(DVec3, f64)>> = environment
        .lobes
        .iter()
        .map(|lobe| {
            let light = lobe.light();
            let ways = (0..DIRECTIONS).map(|i| even_direction(i, DIRECTIONS));
            ways.map(|way| (way, light.radiance(way))).collect()
        })
        .collect();
    let of = |lights: &Vec<(DVec3, f64)>, normal| {
        let all: f64 = lights.iter().map(|(_, light)| light).sum();
        above(lights, normal).map(|(_, light)| light).sum::<f64>() / all.max(1e-300)
    };
    points.iter().map(|point| lobes.iter().map(|lights| of(lights, point.normal)).collect()).collect()
}

/// Sums the light scattered from all lobes, the uniform light and the sun. `of`: light scattered from one lobe.
fn by_lobes(
    environment: &Environment,
    points: &[Point],
    sun: &dyn Fn(&Environment, &Point) -> f64,
    of: &dyn Fn(&Point, &GaussianLight) -> f64,
) -> (Vec<f64>, f64) {
    let shares = shares(environment, points);
    let even = GaussianLight { towards: DVec3::Y, sharpness: 0.0 };
    let above = 0.5 * (1.0 + HORIZON_SINE);
    timed(points.len(), |i| {
        let point = &points[i];
        let lobes = environment.lobes.iter().zip(&shares[i]);
        lobes.map(|(lobe, share)| share * radiance(lobe) * of(point, &lobe.light())).sum::<f64>()
            + above * luminance(DVec3::from(environment.even.map(f64::from))) * of(point, &even)
            + sun(environment, point)
    })
}

/// Measures a method under single lights: two absorptions, two smooth fibres, three views and twenty directions.
pub fn measure_single(form: SingleLighting, width_deg: f64) -> EnvironmentAccuracy {
    let sharpness = width_deg.to_radians().powi(-2);
    let fibres: Vec<Fibre> = [5.0, 15.0].map(|width| smooth(width, &FIBRES[0])).into();
    let sigmas = [0.0, 0.3];
    let way = |theta: f64, phi: f64| {
        DVec3::new(libm::cos(theta) * libm::cos(phi), libm::sin(theta), libm::cos(theta) * libm::sin(phi))
    };
    let mut cases = Vec::new();
    for fibre in 0..fibres.len() {
        for (sigma, _) in sigmas.iter().enumerate() {
            for theta_o in [0.0, 0.5, 1.0] {
                for theta_j in [-1.1, -0.5, 0.05, 0.5, 1.1] {
                    for phi in [0.3, 1.2, 2.1, 3.0] {
                        cases.push((fibre, sigma, way(theta_o, 0.0), way(theta_j, phi)));
                    }
                }
            }
        }
    }
    let half = form == SingleLighting::Tables;
    let brute = |&(fibre, sigma, eye, towards): &(usize, usize, DVec3, DVec3)| {
        single_truth(&fibres[fibre], sigmas[sigma], eye, &GaussianLight { towards, sharpness }, half)
    };
    let expected: Vec<f64> = cases.par_iter().map(brute).collect();
    let exact: Vec<BroadlyLitFibre> = fibres.iter().map(BroadlyLitFibre::new).collect();
    let tables: Vec<BroadTables> = match form {
        SingleLighting::Tables => fibres.iter().map(|fibre| BroadTables::new(fibre, default_size())).collect(),
        _ => Vec::new(),
    };
    let printed: Vec<[PrintedLight; 2]> = match form {
        SingleLighting::Printed => {
            fibres.iter().map(|fibre| sigmas.map(|sigma| PrintedLight::new(fibre, sigma))).collect()
        }
        _ => Vec::new(),
    };
    let (values, seconds) = timed(cases.len(), |i| {
        let (fibre, sigma, eye, towards) = cases[i];
        let light = GaussianLight { towards, sharpness };
        match form {
            SingleLighting::Exact => exact[fibre].scatter([sigmas[sigma]; 3], DVec3::Y, &light, eye)[0],
            SingleLighting::Tables => {
                let half = CutGaussianLight { towards, mean: cut_gaussian_mean_cosine(sharpness) };
                tables[fibre].scatter([sigmas[sigma]; 3], DVec3::Y, &half, eye)[0]
            }
            SingleLighting::Printed => printed[fibre][sigma].scatter(DVec3::Y, &light, eye),
        }
    });
    let pairs: Vec<(f64, f64)> = values.into_iter().zip(expected).collect();
    accuracy(&pairs, seconds)
}

/// Integrates the scattered light over all directions, or with `half` over about the half sphere that the tables cover.
fn single_truth(fibre: &Fibre, sigma: f64, eye: DVec3, light: &GaussianLight, half: bool) -> f64 {
    const STEPS: (usize, usize) = (72, 120);
    // Integrates over five standard deviations about the light's centre, clamped to valid angles.
    let reach = 5.0 / light.sharpness.sqrt();
    let middle = libm::asin(light.towards.y.clamp(-1.0, 1.0));
    let [from, to] = [-reach, reach].map(|far| (middle + far).clamp(-PI / 2.0, PI / 2.0));
    let step = (to - from) / STEPS.0 as f64;
    let turn = 2.0 * PI / STEPS.1 as f64;
    let mut sum = 0.0;
    for i in 0..STEPS.0 {
        let theta = from + step * (i as f64 + 0.5);
        let (sin, cos) = (libm::sin(theta), libm::cos(theta));
        let middle = Angles::between(DVec3::Y, DVec3::new(cos, sin, 0.0), eye);
        let (along, section) = (fibre.along(&middle), fibre.section(middle.cos_d()));
        let rest = along[3] * section.rest(sigma);
        for k in 0..STEPS.1 {
            let phi = turn * (k as f64 + 0.5) - PI;
            let way = DVec3::new(cos * libm::cos(phi), sin, cos * libm::sin(phi));
            if half && way.dot(light.towards) <= -HORIZON_SINE {
                continue;
            }
            let near = light.radiance(way);
            if near < 1e-6 {
                continue;
            }
            let angles = Angles::between(DVec3::Y, way, eye);
            let mut sent = rest;
            for (p, along) in along.iter().take(3).enumerate() {
                section.contributions(p as u32, angles.phi, &mut |way| sent += along * way.attenuated(sigma));
            }
            sum += sent * near * cos * step * turn;
        }
    }
    sum
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `sky` is the name of the environment map.
pub fn cells(configuration: &EnvironmentConfiguration, sky: &str, off: &EnvironmentAccuracy) -> Vec<Cell> {
    let name = match configuration {
        EnvironmentConfiguration::Sky(..) => sky.into(),
        EnvironmentConfiguration::Single(width, _) => format!("one light of {width} degrees"),
    };
    let optional = |x: Option<usize>| x.map_or(Cell::Empty, |x| Cell::Number(x as f64));
    vec![
        Cell::Text(name),
        Cell::Number(100.0 * off.error),
        Cell::Number(100.0 * off.mean),
        Cell::Number(1e6 * off.seconds),
        optional(configuration.fetches()),
        optional(configuration.bytes()),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::skies::painted;
    use super::*;

    #[test]
    fn single_light_errors_are_in_their_expected_ranges() {
        let exact = measure_single(SingleLighting::Exact, 40.0);
        let printed = measure_single(SingleLighting::Printed, 10.0);
        assert!(exact.error < 0.01 && exact.mean.abs() < 0.01, "{exact:?}");
        assert!(printed.error > 0.02 && printed.error < 0.5, "{printed:?}");
    }

    #[test]
    fn one_light_approximates_a_sky_better_than_a_constant() {
        let sky = &painted().expect("skies")[0];
        let truth = EnvironmentTruth::new(sky);
        let of = |form| measure_map(form, sky, &truth);
        let [one, lobes, constant] =
            [MapLighting::OneLight(16, default_size()), MapLighting::Tables(16), MapLighting::Constant].map(of);
        assert!(lobes.error < one.error && one.error < 0.5 * constant.error, "{lobes:?} {one:?} {constant:?}");
        assert!(one.mean.abs() < 0.1, "{one:?}");
        assert!(of(MapLighting::Samples(256)).error < of(MapLighting::Samples(16)).error);
        let all = configurations(1);
        assert_eq!(all.iter().filter(|configuration| configuration.is_default()).count(), 1);
        assert_eq!(cells(&all[0], "sky", &one).len(), COLUMNS.len());
    }
}
