//! Decoding of a package's textures to texels, for use without a GPU.

use pelage_formats::TextureView;
use pelage_import::BakeError;

/// Decodes one array layer of one mip level, in the form of [`TextureView::rgba8`].
///
/// Fails with [`BakeError::Internal`] for a level or layer that does not exist.
pub fn decode_texture(view: &TextureView<'_>, level: u32, layer: u32) -> Result<Vec<u8>, BakeError> {
    let missing = || BakeError::Internal(format!("level {level}, layer {layer} does not exist in texture {view:?}"));
    view.rgba8(level, layer).ok_or_else(missing)
}
