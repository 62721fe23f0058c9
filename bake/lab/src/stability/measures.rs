//! Strands and layers for testing methods, and measures of them.

use glam::DVec3;
use pelage_bake::recipe::{Coat, ColorParams, HairParams, Recipe, SliceParams};
use pelage_bake::stages::simulate::{Strands, VolumeParams, simulate};
use pelage_bake::stages::slice::{ShellSet, collect_layers};
use pelage_formats::TextureFormat;
use pelage_import::BakeError;

/// Returns parameters of few, thick hairs of one kind, so that single hairs are distinguishable.
///
/// # Errors
///
/// Same as [`Recipe::of_coat`].
pub fn natural_hair() -> Result<HairParams, BakeError> {
    Ok(Recipe::of_coat(Coat::Natural)?.hair)
}

/// Grows strands with default colours in a volume of height `height`, tile widths.
///
/// # Errors
///
/// Same as [`simulate`].
pub fn grow(hair: &HairParams, height: f32) -> Result<Strands, BakeError> {
    simulate(hair, &ColorParams::default(), &VolumeParams { height })
}

/// Slices strands into uncompressed layers.
///
/// # Errors
///
/// Same as [`collect_layers`].
pub fn slice(strands: &Strands, layers: u32, tile_texels: u32) -> Result<ShellSet, BakeError> {
    let params = SliceParams { layers, tile_texels, ..SliceParams::default() };
    collect_layers(strands, &params, TextureFormat::Rgba8Unorm)
}

/// Returns the opacity of a texel of a layer, 0..=1.
pub fn opacity(set: &ShellSet, layer: usize, level: usize, texel: usize) -> f64 {
    f64::from(set.layers[layer].color[level][4 * texel + 3]) / 255.0
}

/// Returns the number of texels of a layer at a mip level.
pub fn texels(set: &ShellSet, level: usize) -> usize {
    (set.texels as usize >> level).pow(2)
}

/// Returns the transmittance through all layers above layer 0, for each texel.
pub fn transmittances(set: &ShellSet, level: usize) -> Vec<f64> {
    let column = |texel| (1..set.layers.len()).map(|k| 1.0 - opacity(set, k, level, texel)).product();
    (0..texels(set, level)).map(column).collect()
}

/// Returns unit direction `i` of `count` directions spread evenly over the sphere (Fibonacci lattice).
pub fn even_direction(i: u32, count: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
    let (r, turn) = ((1.0 - z * z).sqrt(), f64::from(i) * 2.399_963_229_728_653);
    DVec3::new(r * libm::cos(turn), r * libm::sin(turn), z)
}

/// Returns the arithmetic mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
