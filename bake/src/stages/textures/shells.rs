//! Slicing joined to encoding: of a volume of any size only one layer stands in memory as texels.

use super::coat::Coat;
use super::encode::{AlphaMode, TextureEncoder};
use super::slice::{Layer, slice_for_package};
use crate::recipe::{DirectionFormat, PackParams, ShellFormat, SliceParams};
use crate::stages::hair::Strands;
use crate::stages::visibility::Visibility;
use pelage_formats::TextureFormat;
use pelage_import::BakeError;

/// How much light reaches the hair of a shell volume.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityTexture {
    /// A complete .ktx2 file: [`pelage_formats::meaning::encode_visibility`] of each texel.
    pub file: Vec<u8>,
    /// k of [`pelage_formats::meaning::above_horizon`].
    pub horizon: f32,
}

/// The texture arrays of a shell volume: complete .ktx2 files, skin first.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellTextures {
    /// Premultiplied colour and opacity.
    pub color: Vec<u8>,
    /// Hair directions.
    pub direction: Vec<u8>,
    /// How much light reaches the hair; `None` where that is not known.
    pub visibility: Option<VisibilityTexture>,
    /// What there is to say of the coat, which then is the last layer of all; `None` without.
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
/// * `with_visibility`: whether visibility is among them
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
/// * `visibility`: of these strands, for a texture of it
/// * `with_coat`: whether the far coat follows as the last array layer
/// * `on_layer`: called when a layer is done
///
/// # Errors
/// As [`slice_for_package`], and [`BakeError::Internal`] if the encoder fails.
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
    // Layers came outermost first, and then the coat.
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

/// The format of the visibility: as exact as the colours are.
fn visibility_format(pack: &PackParams) -> TextureFormat {
    match pack.shell_format {
        ShellFormat::Bc7 => TextureFormat::Bc7Unorm,
        ShellFormat::Rgba8 => TextureFormat::Rgba8Unorm,
    }
}

#[cfg(test)]
#[path = "shells_tests.rs"]
mod tests;
