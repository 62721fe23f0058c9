//! Topic `lighting`: error of the hair direction used for shading, compared with the strand's own, and the cost of
//! shading.
//!
//! Where a strand crosses a layer, its tangent and therefore eq. (1) of Yang 2006 are known exactly. Light per pixel
//! uses the filtered direction from the direction texture at that point. Light per vertex (Lengyel 2001) uses the
//! layer's mean direction. Both are read from the file that the runtime would read, block compression included.
//! Milliseconds are measured on the adapter.

use super::errors::Errors;
use super::{Cell, Panel};
use glam::{DVec3, Vec3};
use pelage_bake::recipe::{DirectionFormat, Recipe, ShellFormat};
use pelage_bake::stages::groom::Lengths;
use pelage_bake::stages::simulate::{Strands, VolumeParams, simulate_recipe};
use pelage_bake::stages::slice::shell_textures;
use pelage_formats::{Limits, Shading, TextureFormat, TextureView, decode_direction};
use pelage_import::BakeError;
use pelage_runtime::LightingStage;
use pelage_runtime::shared::kajiya_kay::{sin_power, sin_squared};
use rayon::prelude::*;

/// Directions towards lights: elevation above the surface and azimuth about its normal, degrees.
const LIGHTS_DEG: [(f64, f64); 6] =
    [(80.0, 10.0), (60.0, 130.0), (60.0, 250.0), (35.0, 40.0), (35.0, 160.0), (35.0, 280.0)];
/// Directions towards eyes, in the form of [`LIGHTS_DEG`]. Each light is combined with each eye.
const EYES_DEG: [(f64, f64); 3] = [(75.0, 90.0), (45.0, 200.0), (45.0, 320.0)];

/// Lighting method to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct LightingConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Stage at which light is computed: per pixel or per vertex.
    pub lighting: LightingStage,
    /// Changes to the base recipe, as arguments of `--set`.
    pub sets: Vec<String>,
    /// Recipe with the changes. Its colours are uncompressed, so that only the cost of directions varies.
    pub recipe: Recipe,
}

/// Columns of the chart.
pub const COLUMNS: [&str; 10] = [
    "lighting",
    "pack.direction_format",
    "slice.tile_texels",
    "slice.filter_width",
    "direction_error_deg",
    "rmse",
    "mean_error",
    "shells_milliseconds",
    "direction_bytes",
    "timing",
];

/// Panels of the chart.
pub const PANELS: [Panel; 2] = [
    Panel {
        cost: "shells_milliseconds",
        cost_label: "shells, milliseconds",
        error: "rmse",
        error_label: "RMSE of eq. (1) with the stored hair direction",
        only: None,
    },
    Panel {
        cost: "direction_bytes",
        cost_label: "direction texture, bytes",
        error: "direction_error_deg",
        error_label: "mean angle between stored and true hair direction, degrees",
        only: None,
    },
];

/// Lists what to measure, the unchanged recipe first.
///
/// # Errors
///
/// Same as [`Recipe::set`]; cannot occur with a valid base.
pub fn configurations(base: &Recipe) -> Result<Vec<LightingConfiguration>, BakeError> {
    let mut out: Vec<LightingConfiguration> = Vec::new();
    let mut add = |series, label: String, lighting, sets: &[String]| {
        let mut recipe = base.clone();
        sets.iter().try_for_each(|set| recipe.set(set))?;
        recipe.pack.shell_format = ShellFormat::Rgba8;
        if !out.iter().any(|c| c.lighting == lighting && c.recipe == recipe) {
            out.push(LightingConfiguration { series, label, lighting, sets: sets.to_vec(), recipe });
        }
        Ok::<_, BakeError>(())
    };
    add("as the recipe says", String::new(), LightingStage::Pixel, &[])?;
    for (series, lighting) in [("per pixel", LightingStage::Pixel), ("per vertex", LightingStage::Vertex)] {
        for format in DirectionFormat::ALL {
            add(series, format.word().into(), lighting, &[format!("pack.direction_format={}", format.word())])?;
        }
    }
    // Uncompressed colours, so that the adapter's handling of blocks does not hide the effect of the varied setting.
    let plain = || "pack.direction_format=rg8".to_owned();
    for texels in [16, 32, 64, 128, 256] {
        add(
            "texels of the tile",
            format!("{texels}²"),
            LightingStage::Pixel,
            &[plain(), format!("slice.tile_texels={texels}")],
        )?;
    }
    for width in [0.25, 0.5, 1.0, 2.0] {
        add(
            "filter width",
            width.to_string(),
            LightingStage::Pixel,
            &[plain(), format!("slice.filter_width={width:?}")],
        )?;
    }
    Ok(out)
}

/// Errors of a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightingErrors {
    /// Mean angle between the shading direction and the strand, degrees. Both are lines without orientation.
    pub direction_error_deg: f64,
    /// Errors of eq. (1) without its ambient term, for white hair under a white light of strength 1.
    pub light: Errors,
    /// Bytes of all mip levels of the direction texture.
    pub direction_bytes: u64,
}

/// Measures a configuration at every crossing of a strand with a layer above the mesh surface.
///
/// # Errors
///
/// Errors of simulating, slicing and encoding.
pub fn measure(configuration: &LightingConfiguration, lengths: Lengths) -> Result<LightingErrors, BakeError> {
    let recipe = &configuration.recipe;
    let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
    let strands = simulate_recipe(recipe, &volume)?;
    let textures = shell_textures(&strands, None, &recipe.slice, &recipe.pack, false, &mut || ())?;
    let view = TextureView::parse(&textures.direction, 0, &Limits::default())
        .map_err(|e| BakeError::Internal(format!("cannot read back the direction texture: {e}")))?;
    let directions = Directions::new(&view, configuration.lighting);
    let shading = Shading::from(&recipe.shading);
    let pairs = pairs();
    let crossings = crossings(&strands, recipe.slice.layers);
    let of = |c: &Crossing| {
        let fast = directions.at(c.layer, c.u, c.v);
        let cosine = fast.as_dvec3().normalize_or_zero().dot(c.tangent).abs().min(1.0);
        let light =
            pairs.iter().map(|[l, h]| (light_at(fast, *l, *h, &shading), true_light(c.tangent, *l, *h, &shading)));
        (cosine.acos().to_degrees(), Errors::of(light))
    };
    let all: Vec<(f64, Errors)> = crossings.par_iter().map(of).collect();
    let sum = all.iter().map(|(angle, _)| angle).sum::<f64>();
    Ok(LightingErrors {
        direction_error_deg: sum / all.len().max(1) as f64,
        light: all.iter().fold(Errors::default(), |sum, (_, errors)| sum.and(*errors)),
        direction_bytes: view.gpu_bytes(),
    })
}

/// Returns the cells of a row, in the order of [`COLUMNS`]. `milliseconds` is the time of the shells, measured by the
/// clock named `timing`.
pub fn cells(
    configuration: &LightingConfiguration,
    measured: &LightingErrors,
    milliseconds: f64,
    timing: &str,
) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let recipe = &configuration.recipe;
    let word = match configuration.lighting {
        LightingStage::Pixel => "pixel",
        LightingStage::Vertex => "vertex",
    };
    vec![
        Cell::Text(word.into()),
        Cell::Text(recipe.pack.direction_format.word().into()),
        Cell::Number(recipe.slice.tile_texels.into()),
        Cell::Number(recipe.slice.filter_width.into()),
        Cell::Number(measured.direction_error_deg),
        number(measured.light.rmse()),
        number(measured.light.mean()),
        Cell::Number(milliseconds),
        Cell::Number(measured.direction_bytes as f64),
        Cell::Text(timing.into()),
    ]
}

/// Crossing of a strand with a layer.
struct Crossing {
    layer: u32,
    /// Tile coordinates, not wrapped.
    u: f32,
    v: f32,
    /// Tangent of the strand, unit length.
    tangent: DVec3,
}

/// Returns all crossings with layers 1.. of `layers`, which are evenly spaced up to the strands' height.
fn crossings(strands: &Strands, layers: u32) -> Vec<Crossing> {
    let mut out = Vec::new();
    let step = f64::from(strands.height) / f64::from(layers.max(2) - 1);
    for strand in 0..strands.len() {
        for ends in strands.points[strands.range(strand)].windows(2) {
            let [a, b] = [ends[0].as_dvec3(), ends[1].as_dvec3()];
            let Some(tangent) = (b - a).try_normalize() else { continue };
            let (low, high) = (a.z.min(b.z), a.z.max(b.z));
            let first = (low / step).ceil().max(1.0) as u32;
            // A height at which two segments meet belongs to the segment that begins there.
            for layer in (first..layers).take_while(|k| f64::from(*k) * step < high) {
                let p = a.lerp(b, (f64::from(layer) * step - a.z) / (b.z - a.z));
                out.push(Crossing { layer, u: p.x as f32, v: p.y as f32, tangent });
            }
        }
    }
    out
}

/// Returns pairs of unit vectors in the tile's frame: direction to the light, and half vector between light and eye.
fn pairs() -> Vec<[DVec3; 2]> {
    let unit = |(up, about): (f64, f64)| {
        let (up, about) = (up.to_radians(), about.to_radians());
        DVec3::new(up.cos() * about.cos(), up.cos() * about.sin(), up.sin())
    };
    let pair = |light, eye| [unit(light), (unit(light) + unit(eye)).normalize_or_zero()];
    LIGHTS_DEG.iter().flat_map(|light| EYES_DEG.iter().map(move |eye| pair(*light, *eye))).collect()
}

/// Evaluates eq. (1) as the runtime does, with the runtime's own functions.
fn light_at(direction: Vec3, light: DVec3, half: DVec3, shading: &Shading) -> f64 {
    let power = |to: DVec3, exponent: f32| sin_power(sin_squared(direction, to.as_vec3()), 0.5 * exponent);
    let terms =
        [(shading.diffuse, light, shading.diffuse_exponent), (shading.specular, half, shading.specular_exponent)];
    terms.iter().map(|(k, to, exponent)| f64::from(k.iter().sum::<f32>() / 3.0 * power(*to, *exponent))).sum()
}

/// Evaluates eq. (1) in double precision, with the sine computed directly.
fn true_light(tangent: DVec3, light: DVec3, half: DVec3, shading: &Shading) -> f64 {
    let power = |to: DVec3, exponent: f32| tangent.cross(to).length().min(1.0).powf(exponent.into());
    let mean = |k: [f32; 3]| k.iter().map(|x| f64::from(*x)).sum::<f64>() / 3.0;
    mean(shading.diffuse) * power(light, shading.diffuse_exponent)
        + mean(shading.specular) * power(half, shading.specular_exponent)
}

/// Single mip level of the direction texture, as an adapter reads it.
struct Directions {
    size: usize,
    format: TextureFormat,
    /// `layers * size * size` texels, components in 0..=1.
    texels: Vec<[f32; 4]>,
}

impl Directions {
    /// Reads the finest mip level for light per pixel, and the coarsest for light per vertex.
    fn new(view: &TextureView<'_>, lighting: LightingStage) -> Self {
        let level = if lighting == LightingStage::Vertex { view.levels - 1 } else { 0 };
        let size = view.level_size(level).0 as usize;
        let data = view.level(level);
        let number = |byte: u8| f32::from(byte) / 255.0;
        let texels = match view.format {
            TextureFormat::Bc5Unorm => bc5(data, size),
            TextureFormat::Rg8Unorm => data.chunks_exact(2).map(|t| [number(t[0]), number(t[1]), 0.0, 1.0]).collect(),
            _ => data.chunks_exact(4).map(|t| [t[0], t[1], t[2], t[3]].map(number)).collect(),
        };
        Self { size, format: view.format, texels }
    }

    /// Samples bilinearly, repeating at the tile's borders.
    fn at(&self, layer: u32, u: f32, v: f32) -> Vec3 {
        let n = self.size;
        let place = |x: f32| {
            let x = x.rem_euclid(1.0) * n as f32 - 0.5;
            (x.floor().rem_euclid(n as f32) as usize % n, x - x.floor())
        };
        let ((x, fx), (y, fy)) = (place(u), place(v));
        let texel = |x: usize, y: usize| self.texels[(layer as usize * n + y % n) * n + x % n];
        let corners = [
            (texel(x, y), (1.0 - fx) * (1.0 - fy)),
            (texel(x + 1, y), fx * (1.0 - fy)),
            (texel(x, y + 1), (1.0 - fx) * fy),
            (texel(x + 1, y + 1), fx * fy),
        ];
        let mean = std::array::from_fn(|i| corners.iter().map(|(t, weight)| t[i] * weight).sum());
        decode_direction(mean, self.format)
    }
}

/// Decodes layers of `size * size` texels from two-component blocks of 16 bytes (RGTC2, Khronos Data Format 1.3, §19).
fn bc5(data: &[u8], size: usize) -> Vec<[f32; 4]> {
    let blocks = size.div_ceil(4);
    let layer_bytes = blocks * blocks * 16;
    let mut out = vec![[0.0, 0.0, 0.0, 1.0]; data.len() / layer_bytes * size * size];
    for (i, texel) in out.iter_mut().enumerate() {
        let (layer, y, x) = (i / (size * size), i / size % size, i % size);
        let block = &data[layer * layer_bytes + (y / 4 * blocks + x / 4) * 16..][..16];
        for (component, half) in block.chunks_exact(8).enumerate() {
            texel[component] = bc4(half, y % 4 * 4 + x % 4);
        }
    }
    out
}

/// Decodes a texel of a one-component block, 0..=1.
fn bc4(block: &[u8], index: usize) -> f32 {
    let ends = [f32::from(block[0]), f32::from(block[1])];
    let bits = block[2..8].iter().rev().fold(0u64, |bits, byte| bits << 8 | u64::from(*byte));
    let code = (bits >> (3 * index) & 7) as f32;
    let value = match (code as u32, block[0] > block[1]) {
        (0, _) => ends[0],
        (1, _) => ends[1],
        (_, true) => ((8.0 - code) * ends[0] + (code - 1.0) * ends[1]) / 7.0,
        (6, false) => 0.0,
        (7, false) => 255.0,
        (_, false) => ((6.0 - code) * ends[0] + (code - 1.0) * ends[1]) / 5.0,
    };
    value / 255.0
}

#[cfg(test)]
#[path = "lighting_tests.rs"]
mod tests;
