//! Slicing of strands into layers of texels.

use super::far_fur::FarFurStats;
use super::layer::{LevelBytes, Transmittance};
use super::splat::{DrawInput, LayerIndex, Sums};
use crate::recipe::SliceParams;
use crate::stages::simulate::Strands;
use crate::stages::visibility::Visibility;
use pelage_formats::TextureFormat;
use pelage_import::BakeError;

/// Layer with its mip levels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Index, 0 on the mesh surface.
    pub index: u32,
    /// Colour per mip level, finest first down to 1×1: `size * size` RGBA8 texels, row-major, v down. Colour is linear
    /// light times opacity, then sRGB-encoded. Alpha is linear opacity.
    pub color: Vec<Vec<u8>>,
    /// Directions per mip level, `size * size` texels in the requested format, with one byte per component.
    pub direction: Vec<Vec<u8>>,
    /// Visibility coefficients per mip level, `size * size` texels of four bytes; empty if not requested.
    pub visibility: Vec<Vec<u8>>,
}

/// All layers of a sliced volume, for volumes that fit in memory.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ShellSet {
    /// Width and height of a layer at level 0, texels.
    pub texels: u32,
    /// Layers, beginning with that of the mesh surface.
    pub layers: Vec<Layer>,
}

/// Slices strands into layers, outermost first, and passes each layer to `sink` with all mip levels.
///
/// * `direction_format`: format of two or four components; only four components preserve the length of mean directions
///
/// The layers are evenly spaced from the mesh surface (layer 0, opaque) to `strands.height`. Texels wrap at the tile's
/// borders. The memory needed in addition to the strands is about 80 bytes per texel of one layer, and 4 bytes for each
/// segment in each layer that it crosses.
///
/// Fails with [`BakeError::Params`] for a value outside its range, [`BakeError::Internal`] for inconsistent strands,
/// and any error of `sink`.
pub fn slice(
    strands: &Strands,
    params: &SliceParams,
    direction_format: TextureFormat,
    sink: impl FnMut(Layer) -> Result<(), BakeError>,
) -> Result<(), BakeError> {
    slice_layers(strands, None, params, direction_format, sink).map(drop)
}

/// Does the same as [`slice()`], and adds the coefficients of `visibility` if given. If `with_coat` is set, it also
/// passes the far fur to `sink` as a last layer with index `params.layers`, and returns its statistics.
///
/// Fails like [`slice()`].
pub fn slice_for_package(
    strands: &Strands,
    visibility: Option<&Visibility>,
    params: &SliceParams,
    direction_format: TextureFormat,
    with_coat: bool,
    mut sink: impl FnMut(Layer) -> Result<(), BakeError>,
) -> Result<Option<FarFurStats>, BakeError> {
    let transmittance = slice_layers(strands, visibility, params, direction_format, &mut sink)?;
    if !with_coat {
        return Ok(None);
    }
    let (levels, coat) = transmittance.coat(params.tile_texels);
    sink(layer(params.layers, levels, direction_format, visibility.is_some()))?;
    Ok(Some(coat))
}

/// Converts a layer to its output form. Directions have one byte for each component of their format.
fn layer(index: u32, levels: Vec<LevelBytes>, direction_format: TextureFormat, with_visibility: bool) -> Layer {
    let (mut color, mut direction, mut visibility) = (Vec::new(), Vec::new(), Vec::new());
    for level in levels {
        color.push(level.color);
        direction.push(level.direction);
        visibility.push(level.visibility);
    }
    if !with_visibility {
        visibility.clear();
    }
    if direction_format.components() == 2 {
        direction.iter_mut().for_each(|level| *level = level.chunks_exact(4).flat_map(|t| [t[0], t[1]]).collect());
    }
    Layer { index, color, direction, visibility }
}

fn slice_layers(
    strands: &Strands,
    visibility: Option<&Visibility>,
    params: &SliceParams,
    direction_format: TextureFormat,
    mut sink: impl FnMut(Layer) -> Result<(), BakeError>,
) -> Result<Transmittance, BakeError> {
    params.validate()?;
    strands.validate()?;
    let drawn = DrawInput { strands, visibility: visibility.map(|found| found.points.as_slice()) };
    if let Some(found) = drawn.visibility.filter(|found| found.len() != strands.points.len()) {
        let text = format!("visibility of {} points, expected {}", found.len(), strands.points.len());
        return Err(BakeError::Internal(text));
    }
    let n = params.tile_texels;
    let index = LayerIndex::new(strands, params.layers);
    let halvings = halvings(n);
    let fine = n << halvings;
    let (fine_filter, blur) = filter(params.filter_width, halvings);
    let mut transmittance = Transmittance::new(n, halvings, blur, direction_format);
    let mut sums = Vec::new();
    for k in (0..params.layers).rev() {
        // The mesh surface is opaque. Its hair direction is that of the roots just above it.
        sums.resize(fine as usize * fine as usize, Sums::default());
        index.draw(drawn, k.max(1) as usize, fine, fine_filter, &mut sums);
        let skin = (k == 0).then_some(strands.root_color);
        let mut levels = transmittance.layer(&mut sums, n, skin);
        if let Some(visibility) = visibility.filter(|_| k == 0) {
            // The texels between the roots show the mesh surface, which has its own visibility.
            levels.iter_mut().zip(visibility.skin_levels(n)).for_each(|(level, bytes)| level.visibility = bytes);
        }
        sink(layer(k, levels, direction_format, visibility.is_some()))?;
    }
    Ok(transmittance)
}

/// Oversampling of the texels that strands are rasterised to, as a number of halvings. The transmittance of a coarse
/// texel is the mean of its fine ones; the transmittance of their mean depth would be lower. So fur is as dense in
/// coarse texels as in fine ones.
const OVERSAMPLING: u32 = 2;
/// Texels per side that suffice to resolve strands. Oversampling does not exceed this number, so finer textures are not
/// oversampled.
const FINE: u32 = 512;

fn halvings(texels: u32) -> u32 {
    OVERSAMPLING.min((FINE / texels).max(1).ilog2())
}

/// Splits the filter width for drawing strands into two widths. The first is the standard deviation with which strands
/// are drawn, in fine texels. The second is the variance of the blur after the halvings, in stored texels². A width of
/// up to half a texel only keeps strands from breaking up between fine texels; any excess becomes blur.
fn filter(width: f32, halvings: u32) -> (f32, f32) {
    if halvings == 0 { (width, 0.0) } else { (width.min(0.5), (width * width - 0.25).max(0.0)) }
}

/// Slices like [`slice()`], with all layers in memory.
///
/// Fails like [`slice()`].
pub fn collect_layers(
    strands: &Strands,
    params: &SliceParams,
    direction_format: TextureFormat,
) -> Result<ShellSet, BakeError> {
    let mut layers = Vec::new();
    slice(strands, params, direction_format, |layer| {
        layers.push(layer);
        Ok(())
    })?;
    layers.reverse();
    Ok(ShellSet { texels: params.tile_texels, layers })
}

#[cfg(test)]
#[path = "volume_tests.rs"]
mod tests;
