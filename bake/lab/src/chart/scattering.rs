//! Topic `scattering`: how near what a frame looks up of a fibre is to the fibre's equations, and what it costs: tables
//! of several sizes and axes, tables between whose texels a cubic goes, the printed tables, and a fit without any.
//!
//! The truth is S cos θi in f64 of pairs of directions that are even over the sphere, under five fibres and three
//! absorptions.

use super::{Cell, Panel};
use glam::DVec3;
use pelage_bake::noise::{hash, uniform};
use pelage_formats::FibreOptics;
use pelage_formats::meaning::scattering::azimuthal::Way;
use pelage_formats::meaning::scattering::means::REFERENCE_SIGMA;
use pelage_formats::meaning::scattering::optics::LEAST_COS_D;
use pelage_formats::meaning::scattering::tables::{Tables, between};
use pelage_formats::meaning::scattering::{Angles, Fibre, PATHS};
use std::f64::consts::PI;

/// Pairs of directions, of each fibre.
pub const PAIRS: usize = 1_000_000;
/// What the fibres absorb a radius: a blond, a brown and a black channel.
pub const SIGMAS: [f64; 3] = [0.1, 0.5, 2.0];

/// The fibres: human hair, glossy and tilted, soft, clear with glints, and matt wool.
pub const FIBRES: [FibreOptics; 5] = [
    FibreOptics { eta: 1.55, along: 0.13, tilt: 0.05, around: 0.117 },
    FibreOptics { eta: 1.55, along: 0.09, tilt: 0.12, around: 0.08 },
    FibreOptics { eta: 1.45, along: 0.2, tilt: 0.05, around: 0.2 },
    FibreOptics { eta: 1.6, along: 0.1, tilt: 0.03, around: 0.05 },
    FibreOptics { eta: 1.55, along: 0.35, tilt: 0.0, around: 0.5 },
];

/// Columns of the chart.
///
/// * `error_percent`: root of the mean square of the difference over that of the truth, of all pairs, fibres and
///   absorptions; `worst_fibre_percent`: of the fibre of which it is largest.
/// * `energy_percent`: mean of what is scattered over that of the truth, less 1.
/// * `nanoseconds`: of one evaluation of three colours on the adapter, with all that is read; `fetches`: texels that a
///   sampler is asked for.
/// * `bytes`: of a fibre's tables, as half floats.
pub const COLUMNS: [&str; 6] =
    ["error_percent", "worst_fibre_percent", "energy_percent", "nanoseconds", "fetches", "bytes"];

/// Panels of the chart.
pub const PANELS: [Panel; 3] = [
    panel("nanoseconds", "ns of an evaluation on the adapter"),
    panel("bytes", "bytes of a fibre"),
    panel("fetches", "fetches of an evaluation"),
];

const fn panel(cost: &'static str, cost_label: &'static str) -> Panel {
    Panel { cost, cost_label, error: "error_percent", error_label: "relative L2 error of S, %", only: None }
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Our tables, of so many texels a side.
    Tables(usize),
    /// Ours, with a cubic through four texels each way (Catmull and Rom 1974).
    Cubic(usize),
    /// Ours, but cos φ for the azimuth's axis, as printed.
    CosPhi(usize),
    /// Ours, but one length of each path for all azimuths.
    EvenLengths(usize),
    /// Ours, but lengths of all paths by their azimuth, from a third table.
    AllLengths(usize),
    /// As printed (Nguyen and Donnelly 2005): along by sin θi and sin θo, around by cos θd and cos φ, TT taken for TRT
    /// and the other way round.
    Printed(usize),
    /// Without tables, by a fit (Karis 2016).
    Fit,
}

/// Something to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Configuration {
    /// What is varied.
    pub series: &'static str,
    /// What it is.
    pub form: Form,
}

/// What to measure.
pub fn configurations() -> Vec<Configuration> {
    let sized = |series, form: fn(usize) -> Form, sizes: &[usize]| {
        sizes.iter().map(|size| Configuration { series, form: form(*size) }).collect::<Vec<_>>()
    };
    let mut all = sized("tables", Form::Tables, &[16, 32, 64, 128, 256]);
    all.extend(sized("tables, cubic", Form::Cubic, &[16, 32, 64]));
    all.extend(sized("azimuth by its cosine", Form::CosPhi, &[32, 64, 128, 256]));
    all.extend(sized("one length for all azimuths", Form::EvenLengths, &[64]));
    all.extend(sized("all lengths by azimuth", Form::AllLengths, &[64, 128]));
    all.extend(sized("as printed", Form::Printed, &[64, 128, 256]));
    all.push(Configuration { series: "a fit without tables", form: Form::Fit });
    all
}

impl Form {
    /// Texels along an edge of its tables; `None` without.
    pub fn size(self) -> Option<usize> {
        match self {
            Self::Tables(n) | Self::Cubic(n) | Self::CosPhi(n) | Self::Printed(n) => Some(n),
            Self::EvenLengths(n) | Self::AllLengths(n) => Some(n),
            Self::Fit => None,
        }
    }

    /// Whether it is what a package has.
    pub fn is_default(self) -> bool {
        self == Self::Tables(64)
    }

    /// Texels that a sampler is asked for, each between four or one.
    pub fn fetches(self) -> u32 {
        match self {
            // Sixteen texels by five fetches between them.
            Self::Cubic(_) => 10,
            Self::Tables(_) | Self::CosPhi(_) | Self::EvenLengths(_) => 2,
            Self::AllLengths(_) | Self::Printed(_) => 3,
            Self::Fit => 0,
        }
    }

    /// Bytes of a fibre's tables.
    pub fn bytes(self) -> usize {
        // Printed: what is along it, what is around it, and two lengths.
        let layers = if matches!(self, Self::AllLengths(_) | Self::Printed(_)) { 3 } else { 2 };
        self.size().map_or(0, |n| 8 * layers * n * n)
    }
}

/// A form of a fibre, ready to be asked.
pub enum Known {
    /// Our tables.
    Ours {
        /// They.
        tables: Box<Tables>,
        /// A cubic goes between texels.
        cubic: bool,
        /// The azimuth's axis is its cosine.
        by_cosine: bool,
    },
    /// Our tables, and one more of the lengths of TRT and all other paths.
    AllLengths {
        /// They.
        tables: Box<Tables>,
        /// Of the texels of what is around the fibre.
        lengths: Vec<[f64; 2]>,
    },
    /// The printed tables.
    Printed {
        /// Texels along an edge.
        size: usize,
        /// By sin θi, row by row by sin θo: R, TT, TRT along.
        along: Vec<[f64; 3]>,
        /// By cos φ, row by row by cos θd: light of R, TT, TRT, and the lengths of the last two.
        around: Vec<[f64; 5]>,
    },
    /// The fit.
    Fit(FibreOptics),
}

impl Known {
    /// Makes it.
    pub fn new(form: Form, optics: &FibreOptics) -> Self {
        let fibre = optics.fibre();
        match form {
            Form::Tables(size) => Self::ours(Tables::new(&fibre, size), false, false),
            Form::Cubic(size) => Self::ours(Tables::new(&fibre, size), true, false),
            Form::CosPhi(size) => Self::ours(by_cosine(&fibre, size), false, true),
            Form::EvenLengths(size) => Self::ours(even_lengths(Tables::new(&fibre, size)), false, false),
            Form::AllLengths(size) => all_lengths(&fibre, size),
            Form::Printed(size) => printed(&fibre, size),
            Form::Fit => Self::Fit(*optics),
        }
    }

    fn ours(tables: Tables, cubic: bool, by_cosine: bool) -> Self {
        Self::Ours { tables: Box::new(tables), cubic, by_cosine }
    }

    /// What it says that the fibre scatters, times cos θi.
    pub fn scatter(&self, angles: &Angles) -> [f64; 3] {
        match self {
            Self::Ours { tables, cubic, by_cosine } => {
                let [mut azimuth, row] = Tables::around_place(angles);
                if *by_cosine {
                    azimuth = 0.5 - 0.5 * libm::cos(angles.phi);
                }
                let read = |layer: &[[f32; PATHS]], at| match cubic {
                    true => cubic_between(layer, tables.size, at),
                    false => between(layer, tables.size, at),
                };
                let along = read(&tables.along, Tables::along_place(angles));
                tables.of_texels(along, read(&tables.around, [azimuth, row]), SIGMAS, angles)
            }
            Self::AllLengths { tables, lengths } => {
                let (size, place) = (tables.size, Tables::around_place(angles));
                let along = between(&tables.along, size, Tables::along_place(angles));
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
                    let [tt, trt] =
                        [(tt, through), (trt, within)].map(|(light, length)| Way { light, length }.left(sigma));
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

/// Ours, with texels evenly by cos φ.
fn by_cosine(fibre: &Fibre, size: usize) -> Tables {
    let mut tables = Tables::new(fibre, size);
    let share = |i: usize| i as f64 / (size - 1) as f64;
    let phis: Vec<f64> = (0..size).map(|i| libm::acos(1.0 - 2.0 * share(i))).collect();
    for j in 0..size {
        let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
        for p in 0..3 {
            for (i, way) in section.mean_ways(p, &phis, REFERENCE_SIGMA).into_iter().enumerate() {
                tables.around[j * size + i][p as usize] = way.light as f32;
                if p == 1 {
                    tables.around[j * size + i][3] = way.length as f32;
                }
            }
        }
    }
    tables
}

/// The same with the mean of each row's length of TT, by its light.
fn even_lengths(mut tables: Tables) -> Tables {
    for row in tables.around.chunks_mut(tables.size) {
        let light: f32 = row.iter().map(|of| of[1]).sum();
        let mean = row.iter().map(|of| of[3] * of[1]).sum::<f32>() / light.max(1e-20);
        row.iter_mut().for_each(|of| of[3] = mean);
    }
    tables
}

fn all_lengths(fibre: &Fibre, size: usize) -> Known {
    let share = |i: usize| i as f64 / (size - 1) as f64;
    let phis: Vec<f64> = (0..size).map(|i| PI * share(i)).collect();
    let mut lengths = Vec::with_capacity(size * size);
    for j in 0..size {
        let section = fibre.section(LEAST_COS_D + (1.0 - LEAST_COS_D) * share(j));
        let others = section.mean_rest(REFERENCE_SIGMA).length;
        lengths.extend(section.mean_ways(2, &phis, REFERENCE_SIGMA).into_iter().map(|way| [way.length, others]));
    }
    Known::AllLengths { tables: Box::new(Tables::new(fibre, size)), lengths }
}

fn printed(fibre: &Fibre, size: usize) -> Known {
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
        let [r, tt, trt] = [0, 1, 2].map(|p| section.mean_ways(p, &phis, REFERENCE_SIGMA));
        around.extend((0..size).map(|i| [r[i].light, tt[i].light, trt[i].light, tt[i].length, trt[i].length]));
    }
    Known::Printed { size, along, around }
}

/// Lobes that are no table, as a game engine has them (Karis 2016): Gaussians of sin θi + sin θo along the fibre, and
/// fits of the azimuth around it.
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
        // Its lobes are per radian of the eye's cosine; S has that of the light.
        let light = angles.from.1;
        (reflected + through * libm::exp(-sigma * chord) + within * libm::exp(-sigma * 3.2 / cos_d)) * light / cos_d
    })
}

/// How far a form is from the equations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// Relative L2 error over all fibres.
    pub error: f64,
    /// Of the worst.
    pub worst: f64,
    /// Mean of what is scattered over the truth's, less 1.
    pub energy: f64,
}

/// Pairs of directions with what the equations say of them, of one fibre.
pub struct Truth {
    pairs: Vec<(Angles, [f64; 3])>,
}

impl Truth {
    /// Of so many pairs.
    pub fn new(optics: &FibreOptics, count: usize) -> Self {
        use rayon::prelude::*;
        let fibre = optics.fibre();
        let pairs = (0..count).into_par_iter().map(|pair| {
            // A fibre is the same all around: one axis serves for all.
            let angles = Angles::between(DVec3::X, direction(2 * pair as u64), direction(2 * pair as u64 + 1));
            (angles, fibre.scatter(SIGMAS, &angles))
        });
        Self { pairs: pairs.collect() }
    }
}

/// Random, even over the sphere.
fn direction(number: u64) -> DVec3 {
    let [height, turn] = [0, 1].map(|what| f64::from(uniform(hash(0xf1b7, number), what)));
    let z = 2.0 * height - 1.0;
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * libm::cos(2.0 * PI * turn), across * libm::sin(2.0 * PI * turn), z)
}

/// How far a form is from the truths of [`FIBRES`].
pub fn off(form: Form, truths: &[Truth]) -> Off {
    use rayon::prelude::*;
    let of_fibres = FIBRES.iter().zip(truths).map(|(optics, truth)| {
        let known = Known::new(form, optics);
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
    Off {
        error: (all[0] / all[1]).sqrt(),
        worst: each.iter().map(|of| (of[0] / of[1]).sqrt()).fold(0.0, f64::max),
        energy: all[2] / all[3] - 1.0,
    }
}

/// The cells of a row, in the order of [`COLUMNS`].
pub fn cells(form: Form, off: &Off, nanoseconds: Option<f64>) -> Vec<Cell> {
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
    fn forms_are_as_far_off_as_they_are_said_to_be() {
        let truths: Vec<Truth> = FIBRES.iter().map(|optics| Truth::new(optics, 4_000)).collect();
        let of = |form| off(form, &truths);
        let (small, large) = (of(Form::Tables(64)), of(Form::Tables(128)));
        assert!(small.error < 0.02 && large.error < 0.007 && small.energy.abs() < 0.01, "{small:?} {large:?}");
        assert!(of(Form::Cubic(32)).error < of(Form::Tables(32)).error);
        let (all, even) = (of(Form::AllLengths(64)), of(Form::EvenLengths(64)));
        assert!(
            all.error < small.error && small.error < 1.1 * all.error && even.error > 1.5 * small.error,
            "{all:?} {even:?}"
        );
        let printed = of(Form::Printed(64));
        assert!(printed.error > 10.0 * small.error && of(Form::CosPhi(64)).error > small.error, "{printed:?}");
        assert!(of(Form::Fit).error.is_finite() && of(Form::Fit).error > printed.error * 0.1);
    }
}
