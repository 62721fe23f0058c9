//! Slicing joined to encoding: of a volume of any size only one layer stands in memory as texels.

use super::encode::{AlphaMode, TextureEncoder};
use super::slice::slice;
use crate::BakeError;
use crate::hair::Strands;
use crate::recipe::{DirectionFormat, PackParams, ShellFormat, SliceParams};
use pelage_formats::TextureFormat;

/// The two texture arrays of a shell volume: complete .ktx2 files, skin first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShellTextures {
    /// Premultiplied colour and opacity.
    pub color: Vec<u8>,
    /// Hair directions.
    pub direction: Vec<u8>,
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

/// Slices `strands` and encodes the layers one by one.
///
/// # Errors
/// As [`slice()`], and [`BakeError::Internal`] if the encoder fails.
pub fn shell_textures(
    strands: &Strands,
    slice_params: &SliceParams,
    pack: &PackParams,
) -> Result<ShellTextures, BakeError> {
    pack.validate()?;
    let direction_format = TextureFormat::from(pack.direction_format);
    let mut color = TextureEncoder::new(pack.shell_format.into(), AlphaMode::Premultiplied, pack.bc_quality);
    let mut direction = TextureEncoder::new(direction_format, AlphaMode::Straight, pack.bc_quality);
    slice(strands, slice_params, direction_format, |layer| {
        color.push_square_layer(slice_params.tile_texels, &layer.color)?;
        direction.push_square_layer(slice_params.tile_texels, &layer.direction)
    })?;
    Ok(ShellTextures { color: color.finish_reversed()?, direction: direction.finish_reversed()? })
}

#[cfg(test)]
#[path = "shells_tests.rs"]
mod tests;
