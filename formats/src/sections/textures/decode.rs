//! Decoding of compressed texture blocks into texels. For readers without a GPU, and for devices that cannot sample
//! such blocks or sample them slowly.

use super::format::TextureFormat;
use super::view::TextureView;

impl TextureFormat {
    /// Returns the uncompressed format that [`TextureView::rgba8`] decodes to: four bytes per texel, sRGB if `self` is.
    pub fn decoded(self) -> Self {
        if self.is_srgb() { Self::Rgba8Srgb } else { Self::Rgba8Unorm }
    }

    /// Decodes `width * height` texels of this format to RGBA8, row-major from the top; the sRGB encoding is unchanged.
    /// For formats with two components, blue is 0 and alpha 255. For half floats, 0 to 255 represent 0 to 1. `None` if
    /// the length of `data` is not [`Self::layer_bytes`].
    pub fn to_rgba8(self, data: &[u8], width: u32, height: u32) -> Option<Vec<u8>> {
        if data.len() as u64 != self.layer_bytes(width, height) {
            return None;
        }
        let (w, h) = (width as usize, height as usize);
        let mut bgra = vec![0u32; w * h];
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm => return Some(data.to_vec()),
            Self::Rg8Unorm => return Some(data.chunks_exact(2).flat_map(|t| [t[0], t[1], 0, 255]).collect()),
            Self::Rgba16Float => {
                let byte = |half: &[u8]| (255.0 * half_to_f32([half[0], half[1]]).clamp(0.0, 1.0) + 0.5) as u8;
                return Some(data.chunks_exact(2).map(byte).collect());
            }
            Self::Bc5Unorm => texture2ddecoder::decode_bc5(data, w, h, &mut bgra).ok()?,
            Self::Bc7Srgb | Self::Bc7Unorm => texture2ddecoder::decode_bc7(data, w, h, &mut bgra).ok()?,
        }
        Some(bgra.iter().flat_map(|t| [(t >> 16) as u8, (t >> 8) as u8, *t as u8, (t >> 24) as u8]).collect())
    }
}

/// Decodes a little-endian IEEE 754 binary16 number.
pub(crate) fn half_to_f32(bytes: [u8; 2]) -> f32 {
    let half = u32::from(u16::from_le_bytes(bytes));
    let (sign, exponent, fraction) = ((half & 0x8000) << 16, half >> 10 & 0x1f, half & 0x3ff);
    match exponent {
        // A subnormal number is a multiple of 2^-24.
        0 => f32::from_bits(sign | (fraction as f32 / 16_777_216.0).to_bits()),
        31 => f32::from_bits(sign | 0x7f80_0000 | fraction << 13),
        _ => f32::from_bits(sign | (exponent + 112) << 23 | fraction << 13),
    }
}

impl TextureView<'_> {
    /// Returns a layer of level 0 of half floats, four numbers per texel. `None` if the layer does not exist, or for
    /// another format.
    pub fn floats(&self, layer: u32) -> Option<Vec<[f32; 4]>> {
        let size = usize::try_from(self.format.layer_bytes(self.width, self.height)).ok()?;
        let data = self.level(0).chunks_exact(size.max(1)).nth(layer as usize)?;
        let texel = |t: &[u8]| core::array::from_fn(|i| half_to_f32([t[2 * i], t[2 * i + 1]]));
        (self.format == TextureFormat::Rgba16Float).then(|| data.chunks_exact(8).map(texel).collect())
    }

    /// Decodes an array layer of a mip level with [`TextureFormat::to_rgba8`]; `None` for a level or layer that does
    /// not exist.
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

    #[test]
    fn half_floats_are_decoded_exactly() {
        let of = |bits: u16| half_to_f32(bits.to_le_bytes());
        let (least, most) = (1.0 / 16_777_216.0, 65504.0);
        assert_eq!(
            [0x0000, 0x3c00, 0xc000, 0x7bff, 0x0001, 0x03ff].map(of),
            [0.0, 1.0, -2.0, most, least, 1023.0 * least]
        );
        assert!(of(0x7c01).is_nan() && of(0xfc00) == f32::NEG_INFINITY);
        let texel = [0x3c00u16, 0x3800, 0xbc00, 0x4000].map(u16::to_le_bytes).concat();
        assert_eq!(TextureFormat::Rgba16Float.to_rgba8(&texel, 1, 1), Some(vec![255, 128, 0, 255]));
    }

    /// Decodes a BC5 block with endpoints 0 and 255 and all indices 0, and arbitrary BC7 blocks: no block is invalid.
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
