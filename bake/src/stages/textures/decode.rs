//! Textures of a package back into texels, for what looks at them without a GPU.

use pelage_formats::TextureView;
use pelage_import::BakeError;

/// One array layer of one mip level as [`TextureView::rgba8`] has it.
///
/// # Errors
/// [`BakeError::Internal`] for a level or layer that is not there.
pub fn decode_texture(view: &TextureView<'_>, level: u32, layer: u32) -> Result<Vec<u8>, BakeError> {
    let missing = || BakeError::Internal(format!("level {level}, layer {layer} of a texture that has {view:?}"));
    view.rgba8(level, layer).ok_or_else(missing)
}
