//! Slicing joined to encoding: of a volume of any size only one layer stands in memory as texels.

use super::encode::{AlphaMode, RawLevel, TextureEncoder};
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
        let size = |level: usize| slice_params.tile_texels >> level;
        let levels = |levels: &[Vec<u8>], encoder: &mut TextureEncoder| {
            let raw = levels.iter().enumerate();
            let raw: Vec<_> = raw.map(|(l, texels)| RawLevel { width: size(l), height: size(l), texels }).collect();
            encoder.push_layer(&raw)
        };
        levels(&layer.color, &mut color)?;
        levels(&layer.direction, &mut direction)
    })?;
    Ok(ShellTextures { color: color.finish_reversed()?, direction: direction.finish_reversed()? })
}

#[cfg(test)]
#[path = "shells_tests.rs"]
mod tests;
