//! Slicing combined with encoding. Only one layer is in memory as texels, whatever the size of the volume.

use super::encode::{AlphaMode, TextureEncoder};
use super::far_fur::FarFurStats;
use super::volume::{Layer, slice_for_package};
use crate::recipe::{DirectionFormat, PackParams, ShellFormat, SliceParams};
use crate::stages::simulate::Strands;
use crate::stages::visibility::Visibility;
use pelage_formats::TextureFormat;
use pelage_import::BakeError;

/// Light that reaches the hair of a shell volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityTexture {
    /// Complete .ktx2 file with the encoded visibility of each texel ([`pelage_formats::meaning::encode_visibility`]).
    pub file: Vec<u8>,
    /// Constant k of [`pelage_formats::meaning::above_horizon`].
    pub horizon: f32,
}

/// Texture arrays of a shell volume: complete .ktx2 files, with the mesh surface as the first layer.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellTextures {
    /// Premultiplied colour and opacity.
    pub color: Vec<u8>,
    /// Hair directions.
    pub direction: Vec<u8>,
    /// Visibility: light that reaches the hair; `None` if unknown.
    pub visibility: Option<VisibilityTexture>,
    /// Statistics of the far fur, which is then the last array layer; `None` without far fur.
    pub coat: Option<FarFurStats>,
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

/// Returns the size of one volume's shell textures with mip levels, bytes: the output of [`shell_textures`] without
/// file headers.
///
/// * `with_coat`: whether the far fur is added as the last array layer
/// * `with_visibility`: whether visibility is included
pub fn shell_bytes(slice_params: &SliceParams, pack: &PackParams, with_coat: bool, with_visibility: bool) -> u64 {
    let n = slice_params.tile_texels;
    let of =
        |format: TextureFormat| (0..=n.ilog2()).map(|level| format.layer_bytes(n >> level, n >> level)).sum::<u64>();
    let seen = if with_visibility { of(visibility_format(pack)) } else { 0 };
    let layer = of(pack.shell_format.into()) + of(pack.direction_format.into()) + seen;
    layer * u64::from(slice_params.layers + u32::from(with_coat))
}

/// Slices `strands` and encodes the layers one by one.
///
/// * `visibility`: visibility of these strands, to be stored in a texture
/// * `with_coat`: whether the far fur is added as the last array layer
/// * `on_layer`: callback after each layer
///
/// Fails like [`slice_for_package`], and with [`BakeError::Internal`] if the encoder fails.
pub fn shell_textures(
    strands: &Strands,
    visibility: Option<&Visibility>,
    slice_params: &SliceParams,
    pack: &PackParams,
    with_coat: bool,
    on_layer: &mut dyn FnMut(),
) -> Result<ShellTextures, BakeError> {
    pack.validate()?;
    let direction_format = TextureFormat::from(pack.direction_format);
    let encoder = |format, alpha| TextureEncoder::new(format, alpha, pack.bc_quality);
    let mut color = encoder(pack.shell_format.into(), AlphaMode::Premultiplied);
    let mut direction = encoder(direction_format, AlphaMode::Straight);
    let mut seen = visibility.map(|_| encoder(visibility_format(pack), AlphaMode::Straight));
    let coat = slice_for_package(strands, visibility, slice_params, direction_format, with_coat, |layer: Layer| {
        color.push_square_layer(slice_params.tile_texels, &layer.color)?;
        direction.push_square_layer(slice_params.tile_texels, &layer.direction)?;
        if let Some(seen) = &mut seen {
            seen.push_square_layer(slice_params.tile_texels, &layer.visibility)?;
        }
        on_layer();
        Ok(())
    })?;
    // Layers arrive outermost first, then the far fur.
    let finish = |encoder: TextureEncoder| {
        if with_coat { encoder.finish_reversed_but_last() } else { encoder.finish_reversed() }
    };
    Ok(ShellTextures {
        color: finish(color)?,
        direction: finish(direction)?,
        visibility: match (seen, visibility) {
            (Some(encoder), Some(found)) => Some(VisibilityTexture { file: finish(encoder)?, horizon: found.horizon }),
            _ => None,
        },
        coat,
    })
}

/// Returns the format of the visibility, which is as precise as that of the colours.
fn visibility_format(pack: &PackParams) -> TextureFormat {
    match pack.shell_format {
        ShellFormat::Bc7 => TextureFormat::Bc7Unorm,
        ShellFormat::Rgba8 => TextureFormat::Rgba8Unorm,
    }
}

#[cfg(test)]
#[path = "shells_tests.rs"]
mod tests;
