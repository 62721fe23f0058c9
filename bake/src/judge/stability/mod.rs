//! Where methods fail, and what we do there: drivers that take each method over its cliff, in the naive form and in ours.
//!
//! `pelage chart stability` prints what they find, and `tests/tests/stability/rows.rs` holds our form to its bound, and the naive one to
//! its failure: data that never reached the cliff would prove nothing. The naive forms stand here and nowhere else.

#[cfg(feature = "preview")]
pub mod animation;
pub mod direction_textures;
pub mod hair_simulation;
#[cfg(feature = "preview")]
pub mod ink;
#[cfg(feature = "preview")]
pub mod kajiya_kay;
#[cfg(feature = "preview")]
pub mod layer_shadows;
pub mod layers;
pub mod mip_levels;
pub mod opacity_product;
#[cfg(feature = "preview")]
pub mod shells;
#[cfg(feature = "preview")]
pub mod silhouette;
#[cfg(feature = "preview")]
pub mod soft_shadow;
pub mod solver;
#[cfg(feature = "preview")]
pub mod sphere_map;
pub mod surface;

use crate::BakeError;
use crate::recipe::{ColorParams, HairParams, SliceParams};
use crate::stages::hair::{Strands, VolumeParams, simulate};
use crate::stages::textures::{ShellSet, collect_layers};
use pelage_formats::TextureFormat;
#[cfg(feature = "preview")]
use pelage_runtime::{FrameParams, PassId};

/// Drives both forms over the cliff on the processor.
pub type Driver = fn() -> Result<Vec<Finding>, BakeError>;

/// The same by pictures, which it asks for.
#[cfg(feature = "preview")]
pub type DrawnDriver = fn(&mut Drawer<'_>) -> Result<Vec<Finding>, BakeError>;

/// Who draws, on an adapter that this library knows nothing of: `width * height` texels of linear light times opacity, and opacity, row-major from the
/// top, with ten bits at least.
#[cfg(feature = "preview")]
pub type Drawer<'a> = dyn FnMut(&Drawing<'_>) -> Result<Vec<[f32; 4]>, BakeError> + 'a;

/// A picture to draw over nothing: one copy of a package at rest.
#[cfg(feature = "preview")]
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// The package.
    pub package: &'a [u8],
    /// Camera, light and style.
    pub params: &'a FrameParams,
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// The passes to draw, in their order.
    pub passes: &'a [PassId],
}

/// A row of the table. `D` is how it is driven.
#[derive(Clone, Copy, Debug)]
pub struct Row<D = Driver> {
    /// The method.
    pub method: &'static str,
    /// Where it fails.
    pub cliff: &'static str,
    /// What the naive form does.
    pub naive: &'static str,
    /// What we do instead.
    pub safe: &'static str,
    /// Drives both forms over the cliff.
    pub drive: D,
}

/// What one drive found: errors of both forms by the same measure, 0 being perfect.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was driven over the cliff.
    pub case: String,
    /// What is measured, with unit.
    pub measure: &'static str,
    /// Error of the naive form; not a number where it gives none.
    pub naive: f64,
    /// Error of ours.
    pub safe: f64,
    /// What ours must stay within.
    pub bound: f64,
    /// What the naive form must exceed, for the data to have reached the cliff.
    pub fails_above: f64,
}

impl Finding {
    /// Whether our form stays within its bound.
    pub fn holds(&self) -> bool {
        self.safe <= self.bound
    }

    /// Whether the naive form fails, as it must.
    pub fn naive_fails(&self) -> bool {
        !self.naive.is_finite() || self.naive > self.fails_above
    }
}

/// All rows, in the order of the way through bake and a frame. Those of the runtime need the feature `preview`.
pub const ROWS: &[Row] = &[
    surface::ROW,
    solver::ROW,
    hair_simulation::ROW,
    opacity_product::ROW,
    layers::ROW,
    mip_levels::ROW,
    direction_textures::ROW,
    #[cfg(feature = "preview")]
    kajiya_kay::ROW,
    #[cfg(feature = "preview")]
    layer_shadows::ROW,
    #[cfg(feature = "preview")]
    soft_shadow::ROW,
    #[cfg(feature = "preview")]
    animation::ROW,
    #[cfg(feature = "preview")]
    sphere_map::ROW,
];

/// The rows that need pictures.
#[cfg(feature = "preview")]
pub const DRAWN_ROWS: &[Row<DrawnDriver>] = &[shells::ROW, ink::ROW];

/// Strands with default colours in a volume of `height`.
///
/// # Errors
///
/// As [`simulate`].
pub fn grow(hair: &HairParams, height: f32) -> Result<Strands, BakeError> {
    simulate(hair, &ColorParams::default(), &VolumeParams { height })
}

/// Their layers, uncompressed.
///
/// # Errors
///
/// As [`collect_layers`].
pub fn slice(strands: &Strands, layers: u32, tile_texels: u32) -> Result<ShellSet, BakeError> {
    let params = SliceParams { layers, tile_texels, ..SliceParams::default() };
    collect_layers(strands, &params, TextureFormat::Rgba8Unorm)
}

/// Opacity of a texel of a layer, 0..=1.
pub fn opacity(set: &ShellSet, layer: usize, level: usize, texel: usize) -> f64 {
    f64::from(set.layers[layer].color[level][4 * texel + 3]) / 255.0
}

/// Number of texels of a layer at a mip level.
pub fn texels(set: &ShellSet, level: usize) -> usize {
    (set.texels as usize >> level).pow(2)
}

/// Transmittance of all layers above the skin, texel by texel.
pub fn transmittances(set: &ShellSet, level: usize) -> Vec<f64> {
    let column = |texel| (1..set.layers.len()).map(|k| 1.0 - opacity(set, k, level, texel)).product();
    (0..texels(set, level)).map(column).collect()
}

/// Arithmetic mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
