//! Topic `scattering`: accuracy and cost of the scattering that a frame looks up for a fibre, compared with the fibre's
//! equations. The compared methods are tables of several sizes and axes, tables with cubic interpolation, the published
//! tables, and a fit without tables.
//!
//! The truth is S cos θi in f64, for pairs of directions uniform over the sphere, five fibres and three absorptions.

use super::{Cell, Panel};
use glam::DVec3;
use pelage_bake::noise::{hash, uniform};
use pelage_formats::FibreOptics;
use pelage_formats::meaning::scattering::azimuthal::PathContribution;
use pelage_formats::meaning::scattering::means::REFERENCE_SIGMA;
use pelage_formats::meaning::scattering::optics::{LEAST_COS_D, Medulla};
use pelage_formats::meaning::scattering::tables::{ScatteringTables, between};
use pelage_formats::meaning::scattering::{Angles, Fibre, PATHS};
use std::f64::consts::PI;

/// Pairs of directions per fibre.
pub const PAIRS: usize = 1_000_000;
/// Absorption of the fibres per radius: one colour channel of blond, brown and black hair.
pub const SIGMAS: [f64; 3] = [0.1, 0.5, 2.0];

/// Fibres: human hair, glossy tilted hair, soft hair, clear hair with glints, and matt wool.
pub const FIBRES: [FibreOptics; 5] = [
    FibreOptics { eta: 1.55, along: 0.13, tilt: 0.05, around: 0.117, medulla: Medulla::NONE },
    FibreOptics { eta: 1.55, along: 0.09, tilt: 0.12, around: 0.08, medulla: Medulla::NONE },
    FibreOptics { eta: 1.45, along: 0.2, tilt: 0.05, around: 0.2, medulla: Medulla::NONE },
    FibreOptics { eta: 1.6, along: 0.1, tilt: 0.03, around: 0.05, medulla: Medulla::NONE },
    FibreOptics { eta: 1.55, along: 0.35, tilt: 0.0, around: 0.5, medulla: Medulla::NONE },
];

/// Columns of the chart.
///
/// * `error_percent`: relative RMS error over all pairs, fibres and absorptions; `worst_fibre_percent`: that of the
///   fibre with the largest error.
/// * `energy_percent`: mean scattered light divided by the truth's, minus 1.
/// * `nanoseconds`: one evaluation of three colours on the adapter, memory reads included; `fetches`: texture samples.
/// * `bytes`: size of a fibre's tables, as half floats.
pub const COLUMNS: [&str; 6] =
    ["error_percent", "worst_fibre_percent", "energy_percent", "nanoseconds", "fetches", "bytes"];

/// Panels of the chart.
pub const PANELS: [Panel; 3] = [
    panel("nanoseconds", "ns per evaluation on the adapter"),
    panel("bytes", "bytes per fibre"),
    panel("fetches", "fetches per evaluation"),
];

const fn panel(cost: &'static str, cost_label: &'static str) -> Panel {
    Panel { cost, cost_label, error: "error_percent", error_label: "relative L2 error of S, %", only: None }
}

/// Method of evaluating a fibre's scattering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScatteringForm {
    /// Tables as in packages, with the given number of texels per side.
    Tables(usize),
    /// Like `Tables`, with cubic interpolation over four texels per axis (Catmull and Rom 1974).
    Cubic(usize),
    /// Like `Tables`, with cos φ as the azimuthal axis, as published.
    CosPhi(usize),
    /// Like `Tables`, but the length of a light path is the same for all azimuths.
    EvenLengths(usize),
    /// Like `Tables`, with a third table that gives the lengths of all light paths by azimuth.
    AllLengths(usize),
    /// Published tables (Nguyen and Donnelly 2005): longitudinal part by sin θi and sin θo, azimuthal part by cos θd
    /// and cos φ, with TT and TRT swapped.
    Printed(usize),
    /// Fit without tables (Karis 2016).
    Fit,
}

/// Parameters of one measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScatteringConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Evaluation method.
    pub form: ScatteringForm,
}

/// Lists what to measure.
pub fn configurations() -> Vec<ScatteringConfiguration> {
    let sized = |series, form: fn(usize) -> ScatteringForm, sizes: &[usize]| {
        sizes.iter().map(|size| ScatteringConfiguration { series, form: form(*size) }).collect::<Vec<_>>()
    };
    let mut all = sized("tables", ScatteringForm::Tables, &[16, 32, 64, 128, 256]);
    all.extend(sized("tables, cubic", ScatteringForm::Cubic, &[16, 32, 64]));
    all.extend(sized("azimuth by its cosine", ScatteringForm::CosPhi, &[32, 64, 128, 256]));
    all.extend(sized("one length for all azimuths", ScatteringForm::EvenLengths, &[64]));
    all.extend(sized("all lengths by azimuth", ScatteringForm::AllLengths, &[64, 128]));
    all.extend(sized("as published", ScatteringForm::Printed, &[64, 128, 256]));
    all.push(ScatteringConfiguration { series: "a fit without tables", form: ScatteringForm::Fit });
    all
}

impl ScatteringForm {
    /// Returns the number of texels along an edge of the tables; `None` without tables.
    pub fn size(self) -> Option<usize> {
        match self {
            Self::Tables(n) | Self::Cubic(n) | Self::CosPhi(n) | Self::Printed(n) => Some(n),
            Self::EvenLengths(n) | Self::AllLengths(n) => Some(n),
            Self::Fit => None,
        }
    }

    /// Returns whether packages use this form.
    pub fn is_default(self) -> bool {
        self == Self::Tables(64)
    }

    /// Returns the number of texture samples. Each sample reads one texel or interpolates between four.
    pub fn fetches(self) -> u32 {
        match self {
            // Five interpolated samples cover sixteen texels, in each of two tables.
            Self::Cubic(_) => 10,
            Self::Tables(_) | Self::CosPhi(_) | Self::EvenLengths(_) => 2,
            Self::AllLengths(_) | Self::Printed(_) => 3,
            Self::Fit => 0,
        }
    }

    /// Returns the size of a fibre's tables, bytes.
    pub fn bytes(self) -> usize {
        // The published tables have three layers of data: longitudinal part, azimuthal part, and two path lengths.
        let layers = if matches!(self, Self::AllLengths(_) | Self::Printed(_)) { 3 } else { 2 };
        self.size().map_or(0, |n| 8 * layers * n * n)
    }
}

/// Fibre in one of the forms, ready for evaluation.
pub enum FibreEvaluator {
    /// Tables as in packages.
    Ours {
        /// Tables of the fibre.
        tables: Box<ScatteringTables>,
        /// Whether interpolation is cubic.
        cubic: bool,
        /// Whether the azimuth's axis is its cosine.
        by_cosine: bool,
    },
    /// Tables as in packages, with an additional table for the path lengths of TRT and of all other paths.
    AllLengths {
        /// Tables of the fibre.
        tables: Box<ScatteringTables>,
        /// Path lengths at the texels of the azimuthal table.
        lengths: Vec<[f64; 2]>,
    },
    /// Published tables.
    Printed {
        /// Texels along an edge.
        size: usize,
        /// Longitudinal part of R, TT and TRT: columns by sin θi, rows by sin θo.
        along: Vec<[f64; 3]>,
        /// Azimuthal part of R, TT and TRT, and path lengths of TT and TRT: columns by cos φ, rows by cos θd.
        around: Vec<[f64; 5]>,
    },
    /// Fit without tables.
    Fit(FibreOptics),
}

impl FibreEvaluator {
    /// Prepares a fibre for evaluation in the given form.
    pub fn new(form: ScatteringForm, optics: &FibreOptics) -> Self {
        let fibre = optics.fibre();
        match form {
            ScatteringForm::Tables(size) => Self::ours(ScatteringTables::new(&fibre, size), false, false),
            ScatteringForm::Cubic(size) => Self::ours(ScatteringTables::new(&fibre, size), true, false),
            ScatteringForm::CosPhi(size) => Self::ours(by_cosine(&fibre, size), false, true),
            ScatteringForm::EvenLengths(size) => {
                Self::ours(even_lengths(ScatteringTables::new(&fibre, size)), false, false)
            }
            ScatteringForm::AllLengths(size) => all_lengths(&fibre, size),
            ScatteringForm::Printed(size) => printed(&fibre, size),
            ScatteringForm::Fit => Self::Fit(*optics),
        }
    }

    fn ours(tables: ScatteringTables, cubic: bool, by_cosine: bool) -> Self {
        Self::Ours { tables: Box::new(tables), cubic, by_cosine }
    }

    /// Returns the scattered light times cos θi, for each absorption of [`SIGMAS`].
    pub fn scatter(&self, angles: &Angles) -> [f64; 3] {
        match self {
            Self::Ours { tables, cubic, by_cosine } => {
                let [mut azimuth, row] = ScatteringTables::around_place(angles);
                if *by_cosine {
                    azimuth = 0.5 - 0.5 * libm::cos(angles.phi);
                }
                let read = |layer: &[[f32; PATHS]], at| match cubic {
                    true => cubic_between(layer, tables.size, at),
                    false => between(layer, tables.size, at),
                };
                let along = read(&tables.along, ScatteringTables::along_place(angles));
                tables.of_texels(along, read(&tables.around, [azimuth, row]), SIGMAS, angles)
            }
            Self::AllLengths { tables, lengths } => {
                let (size, place) = (tables.size, ScatteringTables::around_place(angles));
                let along = between(&tables.along, size, ScatteringTables::along_place(angles));
                let [r, tt, trt, through] = between(&tables.around, size, place);
                let [within, others] = between(lengths, size, place);
                let ways =
                    [(along[0] * r, 0.0), (along[1] * tt, through), (along[2] * trt, within), (along[3], others)];
                SIGMAS.map(|sigma| ways.iter().map(|(light, length)| light * libm::exp(-sigma * length)).sum())
            }
            Self::Printed { size, along, around } => {
                let half = |sine: f64| 0.5 + 0.5 * sine;
                let along = between(along, *size, [half(angles.from.0), half(angles.to.0)]);
                let place = [half(libm::cos(angles.phi)), angles.cos_d()];
                let [r, tt, trt, through, within] = between(around, *size, place);
                SIGMAS.map(|sigma| {
                    let [tt, trt] = [(tt, through), (trt, within)]
                        .map(|(light, length)| PathContribution { light, length }.attenuated(sigma));
                    along[0] * r + along[1] * trt + along[2] * tt
                })
            }
            Self::Fit(optics) => fit(optics, angles),
        }
    }
}

fn cubic_between<const N: usize>(table: &[[f32; N]], size: usize, at: [f64; 2]) -> [f64; N] {
    let at = at.map(|place| place.clamp(0.0, 1.0) * (size - 1) as f64);
    let weights = |t: f64| {
        let (t2, t3) = (t * t, t * t * t);
        [-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * t3 - 0.5 * t2]
    };
    let [left, top] = at.map(|place| (place as usize).min(size - 2));
    let (across, down) = (weights(at[0] - left as f64), weights(at[1] - top as f64));
    let mut sum = [0.0; N];
    for (j, down) in down.iter().enumerate() {
        for (i, across) in across.iter().enumerate() {
            let place = |first: usize, step: usize| (first + step).saturating_sub(1).min(size - 1);
            let texel = &table[place(top, j) * size + place(left, i)];
            sum = std::array::from_fn(|k| sum[k] + across * down * f64::from(texel[k]));
        }
    }
    sum
}

/// Returns tables like those of packages, with texels evenly spaced in cos φ.
fn by_cosine(fibre: &Fibre, size: usize) -> ScatteringTables {
    let mut tables = ScatteringTables::new(fibre, size);
    let share = |i: usize| i as f64 / (size - 1) as f64;
    let phis: Vec<f64> = (0..size).map(|i| libm::acos(1.0 - 2.0 * share(i))).collect();
    for j in 0..size {
        let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
        for p in 0..3 {
            for (i, way) in section.mean_contributions(p, &phis, REFERENCE_SIGMA).into_iter().enumerate() {
                tables.around[j * size + i][p as usize] = way.light as f32;
                if p == 1 {
                    tables.around[j * size + i][3] = way.length as f32;
                }
            }
        }
    }
    tables
}

/// Replaces the path lengths of TT in each row by their mean, weighted by the light of TT.
fn even_lengths(mut tables: ScatteringTables) -> ScatteringTables {
    for row in tables.around.chunks_mut(tables.size) {
        let light: f32 = row.iter().map(|of| of[1]).sum();
        let mean = row.iter().map(|of| of[3] * of[1]).sum::<f32>() / light.max(1e-20);
        row.iter_mut().for_each(|of| of[3] = mean);
    }
    tables
}

fn all_lengths(fibre: &Fibre, size: usize) -> FibreEvaluator {
    let share = |i: usize| i as f64 / (size - 1) as f64;
    let phis: Vec<f64> = (0..size).map(|i| PI * share(i)).collect();
    let mut lengths = Vec::with_capacity(size * size);
    for j in 0..size {
        let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
        let others = section.mean_rest(REFERENCE_SIGMA).length;
        lengths
            .extend(section.mean_contributions(2, &phis, REFERENCE_SIGMA).into_iter().map(|way| [way.length, others]));
    }
    FibreEvaluator::AllLengths { tables: Box::new(ScatteringTables::new(fibre, size)), lengths }
}

fn printed(fibre: &Fibre, size: usize) -> FibreEvaluator {
    let share = |i: usize| i as f64 / (size - 1) as f64;
    let sine = |i: usize| 2.0 * share(i) - 1.0;
    let of = |sin: f64| (sin, (1.0 - sin * sin).max(0.0).sqrt());
    let mut along = Vec::with_capacity(size * size);
    let mut around = Vec::with_capacity(size * size);
    let phis: Vec<f64> = (0..size).map(|i| libm::acos(sine(i))).collect();
    for j in 0..size {
        for i in 0..size {
            let angles = Angles { from: of(sine(i)), to: of(sine(j)), phi: 0.0 };
            let [r, tt, trt, _] = fibre.along(&angles);
            along.push([r, tt, trt]);
        }
        let section = fibre.section(share(j).max(LEAST_COS_D));
        let [r, tt, trt] = [0, 1, 2].map(|p| section.mean_contributions(p, &phis, REFERENCE_SIGMA));
        around.extend((0..size).map(|i| [r[i].light, tt[i].light, trt[i].light, tt[i].length, trt[i].length]));
    }
    FibreEvaluator::Printed { size, along, around }
}

/// Evaluates the lobes used by a game engine, which need no table (Karis 2016): Gaussians of sin θi + sin θo along the
/// fibre, and fits of the azimuthal part.
fn fit(optics: &FibreOptics, angles: &Angles) -> [f64; 3] {
    let (eta, width, tilt) = (f64::from(optics.eta), 2.0 * f64::from(optics.along), 2.0 * f64::from(optics.tilt));
    let cos_d = angles.cos_d().max(LEAST_COS_D);
    let (cos_phi, half_phi) = (libm::cos(angles.phi), libm::cos(0.5 * angles.phi).abs());
    let schlick = |cos: f64| {
        let straight = ((1.0 - eta) / (1.0 + eta)).powi(2);
        straight + (1.0 - straight) * libm::pow(1.0 - cos.clamp(0.0, 1.0), 5.0)
    };
    let along = |width: f64, shift: f64| {
        let off = angles.from.0 + angles.to.0 - shift;
        libm::exp(-0.5 * off * off / (width * width)) / ((2.0 * PI).sqrt() * width)
    };
    let across = 1.19 / cos_d + 0.36 * cos_d;
    let half_vector =
        (0.5 + 0.5 * (angles.from.0 * angles.to.0 + angles.from.1 * angles.to.1 * cos_phi)).max(0.0).sqrt();
    let reflected =
        along(width * std::f64::consts::SQRT_2 * half_phi.max(0.05), -tilt) * 0.25 * half_phi * schlick(half_vector);
    let offset = half_phi * (1.0 + (0.6 - 0.8 * cos_phi) / across);
    let through_f = (1.0 - schlick(cos_d * (1.0 - offset * offset).max(0.0).sqrt())).powi(2);
    let through = along(0.5 * width, 0.5 * tilt) * through_f * libm::exp(-3.65 * cos_phi - 3.98);
    let chord = (1.0 - (offset / across).powi(2)).max(0.0).sqrt() * 2.0 / cos_d;
    let within_f = schlick(cos_d * 0.5);
    let within =
        along(2.0 * width, 1.5 * tilt) * (1.0 - within_f).powi(2) * within_f * libm::exp(17.0 * cos_phi - 16.78);
    SIGMAS.map(|sigma| {
        // The fit's lobes are relative to the cosine towards the eye, S to the one towards the light.
        let light = angles.from.1;
        (reflected + through * libm::exp(-sigma * chord) + within * libm::exp(-sigma * 3.2 / cos_d)) * light / cos_d
    })
}

/// Error of a form, compared with the fibre's equations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScatteringAccuracy {
    /// Relative L2 error over all fibres.
    pub error: f64,
    /// Relative L2 error of the worst fibre.
    pub worst: f64,
    /// Mean scattered light divided by the truth's, minus 1.
    pub energy: f64,
}

/// Pairs of directions with the light scattered according to the equations, for one fibre.
pub struct ScatteringTruth {
    pairs: Vec<(Angles, [f64; 3])>,
}

impl ScatteringTruth {
    /// Evaluates `count` pairs of directions.
    pub fn new(optics: &FibreOptics, count: usize) -> Self {
        use rayon::prelude::*;
        let fibre = optics.fibre();
        let pairs = (0..count).into_par_iter().map(|pair| {
            // Scattering depends only on the angles to the fibre, so one fibre axis is enough.
            let angles = Angles::between(DVec3::X, direction(2 * pair as u64), direction(2 * pair as u64 + 1));
            (angles, fibre.scatter(SIGMAS, &angles))
        });
        Self { pairs: pairs.collect() }
    }
}

/// Returns a random direction, uniform over the sphere.
fn direction(number: u64) -> DVec3 {
    let [height, turn] = [0, 1].map(|what| f64::from(uniform(hash(0xf1b7, number), what)));
    let z = 2.0 * height - 1.0;
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * libm::cos(2.0 * PI * turn), across * libm::sin(2.0 * PI * turn), z)
}

/// Returns the error of a form, compared with the truths of all [`FIBRES`].
pub fn measure(form: ScatteringForm, truths: &[ScatteringTruth]) -> ScatteringAccuracy {
    use rayon::prelude::*;
    let of_fibres = FIBRES.iter().zip(truths).map(|(optics, truth)| {
        let known = FibreEvaluator::new(form, optics);
        let sums = truth.pairs.par_iter().map(|(angles, expected)| {
            let found = known.scatter(angles);
            let mut sums = [0.0; 4];
            for (found, expected) in found.into_iter().zip(*expected) {
                sums[0] += (found - expected) * (found - expected);
                sums[1] += expected * expected;
                sums[2] += found;
                sums[3] += expected;
            }
            sums
        });
        sums.reduce(|| [0.0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]))
    });
    let each: Vec<[f64; 4]> = of_fibres.collect();
    let all = each.iter().fold([0.0; 4], |sum, of| std::array::from_fn(|i| sum[i] + of[i]));
    ScatteringAccuracy {
        error: (all[0] / all[1]).sqrt(),
        worst: each.iter().map(|of| (of[0] / of[1]).sqrt()).fold(0.0, f64::max),
        energy: all[2] / all[3] - 1.0,
    }
}

/// Returns the cells of a row, in the order of [`COLUMNS`].
pub fn cells(form: ScatteringForm, off: &ScatteringAccuracy, nanoseconds: Option<f64>) -> Vec<Cell> {
    vec![
        Cell::Number(100.0 * off.error),
        Cell::Number(100.0 * off.worst),
        Cell::Number(100.0 * off.energy),
        nanoseconds.map_or(Cell::Empty, Cell::Number),
        Cell::Number(form.fetches().into()),
        Cell::Number(form.bytes() as f64),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattering_errors_are_small_and_ordered_as_expected() {
        let truths: Vec<ScatteringTruth> = FIBRES.iter().map(|optics| ScatteringTruth::new(optics, 4_000)).collect();
        let of = |form| measure(form, &truths);
        let (small, large) = (of(ScatteringForm::Tables(64)), of(ScatteringForm::Tables(128)));
        assert!(small.error < 0.02 && large.error < 0.007 && small.energy.abs() < 0.01, "{small:?} {large:?}");
        assert!(of(ScatteringForm::Cubic(32)).error < of(ScatteringForm::Tables(32)).error);
        let (all, even) = (of(ScatteringForm::AllLengths(64)), of(ScatteringForm::EvenLengths(64)));
        assert!(
            all.error < small.error && small.error < 1.1 * all.error && even.error > 1.5 * small.error,
            "{all:?} {even:?}"
        );
        let printed = of(ScatteringForm::Printed(64));
        assert!(
            printed.error > 10.0 * small.error && of(ScatteringForm::CosPhi(64)).error > small.error,
            "{printed:?}"
        );
        assert!(of(ScatteringForm::Fit).error.is_finite() && of(ScatteringForm::Fit).error > printed.error * 0.1);
    }
}
