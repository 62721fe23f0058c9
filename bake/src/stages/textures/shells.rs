//! Slicing joined to encoding: of a volume of any size only one layer stands in memory as texels.

use super::coat::Coat;
use super::encode::{AlphaMode, TextureEncoder};
use super::slice::{Layer, slice, slice_with_coat};
use crate::BakeError;
use crate::recipe::{DirectionFormat, PackParams, ShellFormat, SliceParams};
use crate::stages::hair::Strands;
use pelage_formats::TextureFormat;

/// The two texture arrays of a shell volume: complete .ktx2 files, skin first.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellTextures {
    /// Premultiplied colour and opacity.
    pub color: Vec<u8>,
    /// Hair directions.
    pub direction: Vec<u8>,
    /// What there is to say of the coat, which then is the last layer of both; `None` without.
    pub coat: Option<Coat>,
}

impl From<ShellFormat> for TextureFormat {
    fn from(format: ShellFormat) -> Self {
        match format {
            ShellFormat::Bc7 => Self::Bc7Srgb,
            ShellFormat::Rgba8 => Self::Rgba8Srgb,
        }
    }
}

impl From<DirectionFormat> for TextureFormat {
    fn from(format: DirectionFormat) -> Self {
        match format {
            DirectionFormat::Bc5 => Self::Bc5Unorm,
            DirectionFormat::Rg8 => Self::Rg8Unorm,
            DirectionFormat::Rgba8 => Self::Rgba8Unorm,
        }
    }
}

/// Bytes of texels that the shell textures of one volume will have, with their mip levels: what [`shell_textures`] makes, but for the heads of its files.
///
/// * `with_coat`: whether the far coat follows as the last array layer
pub fn shell_bytes(slice_params: &SliceParams, pack: &PackParams, with_coat: bool) -> u64 {
    let n = slice_params.tile_texels;
    let of =
        |format: TextureFormat| (0..=n.ilog2()).map(|level| format.layer_bytes(n >> level, n >> level)).sum::<u64>();
    let layer = of(pack.shell_format.into()) + of(pack.direction_format.into());
    layer * u64::from(slice_params.layers + u32::from(with_coat))
}

/// Slices `strands` and encodes the layers one by one.
///
/// * `with_coat`: whether the far coat follows as the last array layer
/// * `on_layer`: called when a layer is done
///
/// # Errors
/// As [`slice()`], and [`BakeError::Internal`] if the encoder fails.
pub fn shell_textures(
    strands: &Strands,
    slice_params: &SliceParams,
    pack: &PackParams,
    with_coat: bool,
    on_layer: &mut dyn FnMut(),
) -> Result<ShellTextures, BakeError> {
    pack.validate()?;
    let direction_format = TextureFormat::from(pack.direction_format);
    let mut color = TextureEncoder::new(pack.shell_format.into(), AlphaMode::Premultiplied, pack.bc_quality);
    let mut direction = TextureEncoder::new(direction_format, AlphaMode::Straight, pack.bc_quality);
    let sink = |layer: Layer| {
        color.push_square_layer(slice_params.tile_texels, &layer.color)?;
        direction.push_square_layer(slice_params.tile_texels, &layer.direction)?;
        on_layer();
        Ok(())
    };
    if with_coat {
        let coat = slice_with_coat(strands, slice_params, direction_format, sink)?;
        let (color, direction) = (color.finish_reversed_but_last()?, direction.finish_reversed_but_last()?);
        return Ok(ShellTextures { color, direction, coat: Some(coat) });
    }
    slice(strands, slice_params, direction_format, sink)?;
    Ok(ShellTextures { color: color.finish_reversed()?, direction: direction.finish_reversed()?, coat: None })
}

#[cfg(test)]
#[path = "shells_tests.rs"]
mod tests;
