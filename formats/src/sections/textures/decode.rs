//! Blocks back into texels: for who looks at a package without a GPU, and for devices that cannot sample blocks, or only slowly.

use super::format::TextureFormat;
use super::view::TextureView;

impl TextureFormat {
    /// The format without blocks that [`TextureView::rgba8`] decodes to: four bytes a texel, sRGB where this is.
    pub fn decoded(self) -> Self {
        if self.is_srgb() { Self::Rgba8Srgb } else { Self::Rgba8Unorm }
    }

    /// `width * height` texels of this format as RGBA8, row-major from the top, encoded as they are stored. Of formats with two components blue is 0
    /// and alpha 255. `None` where `data` is not as long as [`Self::layer_bytes`] says.
    pub fn to_rgba8(self, data: &[u8], width: u32, height: u32) -> Option<Vec<u8>> {
        if data.len() as u64 != self.layer_bytes(width, height) {
            return None;
        }
        let (w, h) = (width as usize, height as usize);
        let mut bgra = vec![0u32; w * h];
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm => return Some(data.to_vec()),
            Self::Rg8Unorm => return Some(data.chunks_exact(2).flat_map(|t| [t[0], t[1], 0, 255]).collect()),
            Self::Bc5Unorm => texture2ddecoder::decode_bc5(data, w, h, &mut bgra).ok()?,
            Self::Bc7Srgb | Self::Bc7Unorm => texture2ddecoder::decode_bc7(data, w, h, &mut bgra).ok()?,
        }
        Some(bgra.iter().flat_map(|t| [(t >> 16) as u8, (t >> 8) as u8, *t as u8, (t >> 24) as u8]).collect())
    }
}

impl TextureView<'_> {
    /// One array layer of one mip level as [`TextureFormat::to_rgba8`] has it; `None` for a level or layer that is not there.
    pub fn rgba8(&self, level: u32, layer: u32) -> Option<Vec<u8>> {
        let (width, height) = self.level_size(level);
        let size = usize::try_from(self.format.layer_bytes(width, height)).ok()?;
        let data = self.level(level).chunks_exact(size.max(1)).nth(layer as usize)?;
        self.format.to_rgba8(data, width, height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_texels_are_widened_and_wrong_lengths_refused() {
        let rg = [1, 2, 3, 4];
        assert_eq!(TextureFormat::Rg8Unorm.to_rgba8(&rg, 2, 1), Some(vec![1, 2, 0, 255, 3, 4, 0, 255]));
        assert_eq!(TextureFormat::Rgba8Srgb.to_rgba8(&rg, 1, 1), Some(rg.to_vec()));
        for format in TextureFormat::ALL {
            assert_eq!(format.to_rgba8(&[0; 7], 1, 1), None);
        }
    }

    /// A block of BC5 whose ends are 0 and 255 with all indices 0, and any block at all of BC7: no block is invalid.
    #[test]
    fn blocks_of_partial_levels_are_decoded() {
        let mut block = [0u8; 16];
        (block[0], block[1], block[8], block[9]) = (200, 10, 30, 90);
        assert_eq!(TextureFormat::Bc5Unorm.to_rgba8(&block, 2, 1), Some([200, 30, 0, 255].repeat(2)));
        for byte in 0..=255 {
            let texels = TextureFormat::Bc7Srgb.to_rgba8(&[byte; 16], 4, 4);
            assert_eq!(texels.map(|texels| texels.len()), Some(64));
        }
        assert_eq!(TextureFormat::Bc7Srgb.decoded(), TextureFormat::Rgba8Srgb);
        assert_eq!(TextureFormat::Bc5Unorm.decoded(), TextureFormat::Rgba8Unorm);
    }
}
