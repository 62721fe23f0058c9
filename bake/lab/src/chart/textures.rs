//! Topic `textures`: error and cost of texel formats, encoder effort and mip filter, on a tile of hair.
//!
//! The truth is the sliced tile with eight bits per channel before any encoding; directions have all three components
//! and their length. Only the loss of the format is measured; the topics `lighting` and `shells` measure that of
//! slicing. The encoded file is read back and decoded.

use super::{Cell, Panel};
use crate::stability::{mean, opacity, texels, transmittances};
use glam::Vec3;
use pelage_bake::recipe::{BcQuality, DirectionFormat, Recipe, ShellFormat};
use pelage_bake::stages::simulate::Strands;
use pelage_bake::stages::slice::{AlphaMode, Layer, ShellSet, TextureEncoder, collect_layers, decode_texture};
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_formats::{Limits, TextureFormat, TextureView, decode_direction};
use pelage_import::BakeError;

/// Filter that makes a coarser level from the finer one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MipFilter {
    /// Filter of the bake: preserves the mean transmittance through all layers.
    Product,
    /// Averages each layer separately.
    Mean,
}

impl MipFilter {
    /// Returns the name of the filter in the table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Product => "product of layers",
            Self::Mean => "mean of each layer",
        }
    }
}

/// Textures to measure. If a setting affects only one texture, the other is omitted, because it would give the same
/// point repeatedly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Both,
    Shells,
    Directions,
}

/// Storage parameters of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturesConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Changes to the base recipe, as arguments of `--set`.
    pub sets: Vec<String>,
    /// Mip filter, which is not part of a recipe.
    pub mips: MipFilter,
    /// Recipe with the changes.
    pub recipe: Recipe,
    part: Part,
}

/// Number of mip levels whose coverage drift has its own column.
const LEVELS: usize = 6;

/// Columns of the chart.
pub const COLUMNS: [&str; 19] = [
    "pack.shell_format",
    "pack.direction_format",
    "pack.bc_quality",
    "mip_filter",
    "color_rmse",
    "color_psnr_db",
    "opacity_rmse",
    "coverage_drift",
    "coverage_drift_level_0",
    "coverage_drift_level_1",
    "coverage_drift_level_2",
    "coverage_drift_level_3",
    "coverage_drift_level_4",
    "coverage_drift_level_5",
    "direction_error_deg",
    "shell_bytes",
    "direction_bytes",
    "shell_encode_seconds",
    "direction_encode_seconds",
];

/// Panels of the chart.
pub const PANELS: [Panel; 4] = [
    Panel {
        cost: "shell_bytes",
        cost_label: "shell texture, bytes",
        error: "color_rmse",
        error_label: "RMSE of colour, in 1/255",
        only: None,
    },
    Panel {
        cost: "shell_encode_seconds",
        cost_label: "encoding the shell texture, seconds",
        error: "color_rmse",
        error_label: "RMSE of colour, in 1/255",
        only: None,
    },
    Panel {
        cost: "shell_bytes",
        cost_label: "shell texture, bytes",
        error: "coverage_drift",
        error_label: "largest change of coverage across the mips",
        only: None,
    },
    Panel {
        cost: "direction_bytes",
        cost_label: "direction texture, bytes",
        error: "direction_error_deg",
        error_label: "mean error of direction, degrees",
        only: None,
    },
];

/// Lists what to measure, the unchanged recipe first.
///
/// # Errors
///
/// Same as [`Recipe::set`]; cannot occur with a valid base.
pub fn configurations(base: &Recipe) -> Result<Vec<TexturesConfiguration>, BakeError> {
    let mut out = Vec::new();
    let mut add = |series, label: String, sets: &[String], mips, part| {
        let mut recipe = base.clone();
        sets.iter().try_for_each(|set| recipe.set(set))?;
        out.push(TexturesConfiguration { series, label, sets: sets.to_vec(), mips, recipe, part });
        Ok::<_, BakeError>(())
    };
    let quality = |quality: &BcQuality| format!("pack.bc_quality={}", quality.word());
    add("as the recipe says", String::new(), &[], MipFilter::Product, Part::Both)?;
    for format in ShellFormat::ALL {
        let set = format!("pack.shell_format={}", format.word());
        let plain = *format == ShellFormat::Rgba8;
        // Uncompressed texels do not depend on the effort.
        for effort in BcQuality::ALL.iter().take(if plain { 1 } else { usize::MAX }) {
            let label = if plain { format.word().into() } else { format!("{}, {}", format.word(), effort.word()) };
            add("colour and opacity", label, &[set.clone(), quality(effort)], MipFilter::Product, Part::Shells)?;
        }
        add("mips of each layer by itself", format.word().into(), &[set], MipFilter::Mean, Part::Shells)?;
    }
    for format in DirectionFormat::ALL {
        // The BC5 encoder has no effort setting.
        let set = format!("pack.direction_format={}", format.word());
        add("hair direction", format.word().into(), &[set], MipFilter::Product, Part::Directions)?;
    }
    Ok(out)
}

/// Sliced tile before encoding, the truth of the measurement.
pub struct SlicedTile {
    set: ShellSet,
    strands: Strands,
    coverage: f64,
}

impl SlicedTile {
    /// Slices strands with the settings of `recipe`.
    ///
    /// # Errors
    ///
    /// Same as [`collect_layers`].
    pub fn new(recipe: &Recipe, strands: Strands) -> Result<Self, BakeError> {
        let set = collect_layers(&strands, &recipe.slice, TextureFormat::Rgba8Unorm)?;
        let coverage = 1.0 - mean(&transmittances(&set, 0));
        Ok(Self { set, strands, coverage })
    }
}

/// Errors and costs of the shell texture.
#[derive(Clone, Debug, Default, PartialEq)]
struct Shells {
    /// RMSE of premultiplied, encoded red, green and blue in the finest level of the layers above layer 0, in steps of
    /// 1/255.
    color_rmse: f64,
    /// RMSE of alpha in the finest level of the layers above layer 0, 0..=1.
    opacity_rmse: f64,
    /// Mean coverage of all layers above layer 0 at each mip level, minus the truth's at level 0.
    drift: Vec<f64>,
    bytes: u64,
    seconds: f64,
}

/// Errors and costs of the direction texture.
#[derive(Clone, Debug, Default, PartialEq)]
struct Directions {
    error_deg: f64,
    bytes: u64,
    seconds: f64,
}

/// Encodes a tile with a configuration, and compares the decoded result with the truth. Returns the cells of a row, in
/// the order of [`COLUMNS`].
///
/// * `now`: returns the seconds since a fixed time, for timing the encoder
///
/// # Errors
///
/// Errors of slicing, encoding and decoding.
pub fn measure(
    configuration: &TexturesConfiguration,
    truth: &SlicedTile,
    now: &dyn Fn() -> f64,
) -> Result<Vec<Cell>, BakeError> {
    let part = configuration.part;
    let shells = if part == Part::Directions { None } else { Some(shells(configuration, truth, now)?) };
    let directions = if part == Part::Shells { None } else { Some(directions(configuration, truth, now)?) };
    let pack = &configuration.recipe.pack;
    let of_shells = |f: &dyn Fn(&Shells) -> f64| shells.as_ref().map_or(Cell::Empty, |s| Cell::Number(f(s)));
    let of_directions =
        |f: &dyn Fn(&Directions) -> f64| directions.as_ref().map_or(Cell::Empty, |d| Cell::Number(f(d)));
    let blocks = shells.is_some() && pack.shell_format == ShellFormat::Bc7;
    let word = |there: bool, word: &str| if there { Cell::Text(word.into()) } else { Cell::Empty };
    let mut cells = vec![
        word(shells.is_some(), pack.shell_format.word()),
        word(directions.is_some(), pack.direction_format.word()),
        word(blocks, pack.bc_quality.word()),
        word(shells.is_some(), configuration.mips.word()),
        of_shells(&|s| s.color_rmse),
        // Identical textures have an infinite signal-to-noise ratio, which JSON cannot represent.
        if shells.as_ref().is_some_and(|s| s.color_rmse > 0.0) {
            of_shells(&|s| 20.0 * libm::log10(255.0 / s.color_rmse))
        } else {
            Cell::Empty
        },
        of_shells(&|s| s.opacity_rmse),
        of_shells(&|s| s.drift.iter().fold(0.0, |most: f64, d| most.max(d.abs()))),
    ];
    cells.extend((0..LEVELS).map(|level| {
        let drift = shells.as_ref().and_then(|s| s.drift.get(level));
        drift.map_or(Cell::Empty, |d| Cell::Number(*d))
    }));
    cells.extend([
        of_directions(&|d| d.error_deg),
        of_shells(&|s| s.bytes as f64),
        of_directions(&|d| d.bytes as f64),
        of_shells(&|s| s.seconds),
        of_directions(&|d| d.seconds),
    ]);
    Ok(cells)
}

fn shells(
    configuration: &TexturesConfiguration,
    truth: &SlicedTile,
    now: &dyn Fn() -> f64,
) -> Result<Shells, BakeError> {
    let pack = &configuration.recipe.pack;
    let set = match configuration.mips {
        MipFilter::Product => truth.set.clone(),
        MipFilter::Mean => averaged(&truth.set),
    };
    let (file, seconds) = timed(now, || {
        let mut encoder = TextureEncoder::new(pack.shell_format.into(), AlphaMode::Premultiplied, pack.bc_quality);
        set.layers.iter().try_for_each(|layer| encoder.push_square_layer(set.texels, &layer.color))?;
        encoder.finish()
    })?;
    let view = parse(&file)?;
    let decoded = decoded(&view)?;
    let (mut color, mut alpha) = (0.0, 0.0);
    for (layer, truth) in decoded.layers.iter().zip(&truth.set.layers).skip(1) {
        for (a, b) in layer.color[0].chunks_exact(4).zip(truth.color[0].chunks_exact(4)) {
            let square = |i: usize| (f64::from(a[i]) - f64::from(b[i])).powi(2);
            color += square(0) + square(1) + square(2);
            alpha += square(3);
        }
    }
    let count = ((set.layers.len() - 1) * texels(&set, 0)) as f64;
    let levels = 0..decoded.layers[0].color.len();
    Ok(Shells {
        color_rmse: (color / (3.0 * count)).sqrt(),
        opacity_rmse: (alpha / count).sqrt() / 255.0,
        drift: levels.map(|level| 1.0 - mean(&transmittances(&decoded, level)) - truth.coverage).collect(),
        bytes: view.gpu_bytes(),
        seconds,
    })
}

fn directions(
    configuration: &TexturesConfiguration,
    truth: &SlicedTile,
    now: &dyn Fn() -> f64,
) -> Result<Directions, BakeError> {
    let (pack, slice) = (&configuration.recipe.pack, &configuration.recipe.slice);
    let format = TextureFormat::from(pack.direction_format);
    let set = collect_layers(&truth.strands, slice, format)?;
    let (file, seconds) = timed(now, || {
        let mut encoder = TextureEncoder::new(format, AlphaMode::Straight, pack.bc_quality);
        set.layers.iter().try_for_each(|layer| encoder.push_square_layer(set.texels, &layer.direction))?;
        encoder.finish()
    })?;
    let view = parse(&file)?;
    let (mut sum, mut weights) = (0.0, 0.0);
    for (k, layer) in truth.set.layers.iter().enumerate().skip(1) {
        let decoded = decode_texture(&view, 0, k as u32)?;
        for (i, (a, b)) in decoded.chunks_exact(4).zip(layer.direction[0].chunks_exact(4)).enumerate() {
            let direction = |t: &[u8], format| decode_direction([0, 1, 2, 3].map(|i| f32::from(t[i]) / 255.0), format);
            let (a, b) = (direction(a, format), direction(b, TextureFormat::Rgba8Unorm));
            // A zero mean, where opposing directions cancel, has no direction.
            let (Some(a), Some(b)) = (a.try_normalize(), b.try_normalize()) else { continue };
            let weight = opacity(&truth.set, k, 0, i);
            sum += weight * angle_deg(a, b);
            weights += weight;
        }
    }
    Ok(Directions { error_deg: sum / f64::max(weights, f64::MIN_POSITIVE), bytes: view.gpu_bytes(), seconds })
}

/// Returns the angle between two lines, degrees.
fn angle_deg(a: Vec3, b: Vec3) -> f64 {
    let (a, b) = (a.as_dvec3(), b.as_dvec3());
    // Uses the sine as well, because the cosine of small angles rounds to 1.
    a.cross(b).length().atan2(a.dot(b).abs()).to_degrees()
}

/// Maximum number of encoder runs, of which the fastest counts.
const RUNS: usize = 3;
/// Total duration after which no further run begins, seconds.
const LONG_S: f64 = 1.0;

fn timed(now: &dyn Fn() -> f64, run: impl Fn() -> Result<Vec<u8>, BakeError>) -> Result<(Vec<u8>, f64), BakeError> {
    let (mut least, mut total) = (f64::INFINITY, 0.0);
    let mut file = Vec::new();
    for _ in 0..RUNS {
        if total >= LONG_S {
            break;
        }
        let begun = now();
        file = run()?;
        let seconds = now() - begun;
        least = least.min(seconds);
        total += seconds;
    }
    Ok((file, least))
}

fn parse(file: &[u8]) -> Result<TextureView<'_>, BakeError> {
    let view = TextureView::parse(file, 0, &Limits::default());
    view.map_err(|e| BakeError::Internal(format!("cannot read back the texture: {e}")))
}

/// Decodes the colours of a file into a set of layers.
fn decoded(view: &TextureView<'_>) -> Result<ShellSet, BakeError> {
    let layer = |index: u32| {
        let color = (0..view.levels).map(|level| decode_texture(view, level, index)).collect::<Result<_, _>>()?;
        Ok(Layer { index, color, direction: Vec::new(), visibility: Vec::new() })
    };
    Ok(ShellSet { texels: view.width, layers: (0..view.layers).map(layer).collect::<Result<_, BakeError>>()? })
}

/// Returns a set with the same finest level, in whose coarser levels the opacity and light of each layer are averaged
/// separately.
fn averaged(set: &ShellSet) -> ShellSet {
    let mut out = set.clone();
    for layer in &mut out.layers {
        for level in 1..layer.color.len() {
            let (n, fine) = ((set.texels >> level) as usize, layer.color[level - 1].clone());
            for (i, texel) in layer.color[level].chunks_exact_mut(4).enumerate() {
                let at = |dx: usize, dy: usize| 4 * ((i / n * 2 + dy) * 2 * n + i % n * 2 + dx);
                let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                for c in 0..3 {
                    texel[c] = linear_to_srgb(four.iter().map(|at| srgb_to_linear(fine[at + c])).sum::<f32>() / 4.0);
                }
                texel[3] = ((four.iter().map(|at| u32::from(fine[at + 3])).sum::<u32>() + 2) / 4) as u8;
            }
        }
    }
    out
}

#[cfg(test)]
#[path = "textures_tests.rs"]
mod tests;
