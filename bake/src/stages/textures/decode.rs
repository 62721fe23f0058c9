//! Textures of a package back into texels, for what looks at them without a GPU.

use crate::BakeError;
use pelage_formats::{TextureFormat, TextureView};

/// One array layer of one mip level as `width * height` RGBA8 texels, row-major from the top, encoded as they are stored. Of formats
/// with two components blue is 0 and alpha 255.
///
/// # Errors
/// [`BakeError::Internal`] for a level or layer that is not there, or if the decoder fails.
pub fn decode_texture(view: &TextureView<'_>, level: u32, layer: u32) -> Result<Vec<u8>, BakeError> {
    let (width, height) = view.level_size(level);
    let size = view.format.layer_bytes(width, height) as usize;
    let data =
        view.level(level).chunks_exact(size.max(1)).nth(layer as usize).ok_or_else(|| {
            BakeError::Internal(format!("level {level}, layer {layer} of a texture that has {view:?}"))
        })?;
    decode_texels(view.format, data, width, height)
}

/// As [`decode_texture`], from the bytes of one layer.
pub(super) fn decode_texels(format: TextureFormat, data: &[u8], width: u32, height: u32) -> Result<Vec<u8>, BakeError> {
    let (w, h) = (width as usize, height as usize);
    let mut bgra = vec![0u32; w * h];
    let decoded = match format {
        TextureFormat::Rgba8Srgb | TextureFormat::Rgba8Unorm => return Ok(data.to_vec()),
        TextureFormat::Rg8Unorm => return Ok(data.chunks_exact(2).flat_map(|t| [t[0], t[1], 0, 255]).collect()),
        TextureFormat::Bc5Unorm => texture2ddecoder::decode_bc5(data, w, h, &mut bgra),
        TextureFormat::Bc7Srgb | TextureFormat::Bc7Unorm => texture2ddecoder::decode_bc7(data, w, h, &mut bgra),
    };
    decoded.map_err(|error| BakeError::Internal(format!("texture decoder: {error}")))?;
    Ok(bgra.iter().flat_map(|t| [(t >> 16) as u8, (t >> 8) as u8, *t as u8, (t >> 24) as u8]).collect())
}
