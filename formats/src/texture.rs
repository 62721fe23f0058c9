//! `KTX2` sections: complete .ktx2 files, read with the `ktx2` crate and narrowed to what the runtime can upload as it is.

use crate::container::Tag;
use crate::{FormatError, Limits};

/// Texel formats that packages hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureFormat {
    /// Four bytes a texel, colour sRGB-encoded.
    Rgba8Srgb,
    /// Four bytes a texel.
    Rgba8Unorm,
    /// Two bytes a texel.
    Rg8Unorm,
    /// 16 bytes per 4×4 block, RGBA, colour sRGB-encoded.
    Bc7Srgb,
    /// 16 bytes per 4×4 block, RGBA.
    Bc7Unorm,
    /// 16 bytes per 4×4 block, two components.
    Bc5Unorm,
}

impl TextureFormat {
    /// All of them, for tables.
    pub const ALL: [Self; 6] =
        [Self::Rgba8Srgb, Self::Rgba8Unorm, Self::Rg8Unorm, Self::Bc7Srgb, Self::Bc7Unorm, Self::Bc5Unorm];

    fn from_ktx2(format: ktx2::Format) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.ktx2() == format)
    }

    /// The same format in the `ktx2` crate's words.
    pub fn ktx2(self) -> ktx2::Format {
        match self {
            Self::Rgba8Srgb => ktx2::Format::R8G8B8A8_SRGB,
            Self::Rgba8Unorm => ktx2::Format::R8G8B8A8_UNORM,
            Self::Rg8Unorm => ktx2::Format::R8G8_UNORM,
            Self::Bc7Srgb => ktx2::Format::BC7_SRGB_BLOCK,
            Self::Bc7Unorm => ktx2::Format::BC7_UNORM_BLOCK,
            Self::Bc5Unorm => ktx2::Format::BC5_UNORM_BLOCK,
        }
    }

    /// Texels along a block's edge: 1 or 4.
    pub fn block_size(self) -> u32 {
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm | Self::Rg8Unorm => 1,
            Self::Bc7Srgb | Self::Bc7Unorm | Self::Bc5Unorm => 4,
        }
    }

    /// Bytes of one block.
    pub fn block_bytes(self) -> u32 {
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm => 4,
            Self::Rg8Unorm => 2,
            Self::Bc7Srgb | Self::Bc7Unorm | Self::Bc5Unorm => 16,
        }
    }

    /// Channels a sampler returns that carry data.
    pub fn components(self) -> u32 {
        match self {
            Self::Rg8Unorm | Self::Bc5Unorm => 2,
            Self::Rgba8Srgb | Self::Rgba8Unorm | Self::Bc7Srgb | Self::Bc7Unorm => 4,
        }
    }

    /// Name in WebGPU.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgba8Srgb => "rgba8unorm-srgb",
            Self::Rgba8Unorm => "rgba8unorm",
            Self::Rg8Unorm => "rg8unorm",
            Self::Bc7Srgb => "bc7-rgba-unorm-srgb",
            Self::Bc7Unorm => "bc7-rgba-unorm",
            Self::Bc5Unorm => "bc5-rg-unorm",
        }
    }

    /// Bytes of one layer of `width × height` texels.
    pub fn layer_bytes(self, width: u32, height: u32) -> u64 {
        let blocks = |texels: u32| u64::from(texels.div_ceil(self.block_size()));
        blocks(width) * blocks(height) * u64::from(self.block_bytes())
    }
}

/// A texture of an opened package. Its levels are slices of the package's bytes.
#[derive(Clone, Copy, Debug)]
pub struct TextureView<'a> {
    /// Texel format.
    pub format: TextureFormat,
    /// Width of level 0, texels.
    pub width: u32,
    /// Height of level 0, texels.
    pub height: u32,
    /// Array layers, at least 1.
    pub layers: u32,
    /// Mip levels, at least 1.
    pub levels: u32,
    /// The whole .ktx2 file.
    pub ktx2: &'a [u8],
}

impl<'a> TextureView<'a> {
    /// Reads a .ktx2 file that begins at `offset` of the package.
    pub(crate) fn parse(ktx2: &'a [u8], offset: u64, limits: &Limits) -> Result<Self, FormatError> {
        let fail = |at: u64, reason: String| FormatError::Content { tag: Tag::TEXTURE, offset: offset + at, reason };
        let reader = ktx2::Reader::new(ktx2).map_err(|e| fail(0, format!("not a readable KTX2 file: {e}")))?;
        let header = reader.header();
        let format = header.format.and_then(TextureFormat::from_ktx2).ok_or_else(|| {
            let names: Vec<_> = TextureFormat::ALL.iter().map(|f| f.name()).collect();
            fail(12, format!("texel format is {:?}, expected one of {}", header.format, names.join(", ")))
        })?;
        if let Some(scheme) = header.supercompression_scheme {
            return Err(fail(44, format!("supercompressed with {scheme:?}, expected data ready to upload")));
        }
        let (depth, faces) = (header.pixel_depth, header.face_count);
        if depth != 0 || faces != 1 || header.pixel_height == 0 {
            let found = format!("height {}, depth {depth} and {faces} faces", header.pixel_height);
            return Err(fail(24, format!("{found}, expected a 2D texture or 2D array")));
        }
        let view = Self {
            format,
            width: header.pixel_width,
            height: header.pixel_height,
            layers: header.layer_count.max(1),
            levels: header.level_count.max(1),
            ktx2,
        };
        for (what, at, found, limit) in [
            ("texture width", 20, view.width, limits.texture_size),
            ("texture height", 24, view.height, limits.texture_size),
            ("texture layers", 32, view.layers, limits.texture_layers),
        ] {
            if found > limit {
                let (found, limit) = (found.into(), limit.into());
                return Err(FormatError::Limit { what, offset: offset + at, found, limit });
            }
        }
        let full_chain = 32 - view.width.max(view.height).leading_zeros();
        if view.levels > full_chain {
            return Err(fail(40, format!("{} mip levels, expected at most {full_chain}", view.levels)));
        }
        for (level, data) in reader.levels().enumerate() {
            let expected = view.level_bytes(level as u32);
            if data.data.len() as u64 != expected {
                let at = ktx2::Header::LENGTH as u64 + 24 * level as u64;
                return Err(fail(at, format!("level {level} has {} bytes, expected {expected}", data.data.len())));
            }
        }
        Ok(view)
    }

    /// Width and height of a level, texels.
    pub fn level_size(&self, level: u32) -> (u32, u32) {
        ((self.width >> level).max(1), (self.height >> level).max(1))
    }

    /// Bytes of a level, all layers.
    pub fn level_bytes(&self, level: u32) -> u64 {
        let (width, height) = self.level_size(level);
        self.format.layer_bytes(width, height) * u64::from(self.layers)
    }

    /// Bytes of all levels: what the texture takes on the GPU.
    pub fn gpu_bytes(&self) -> u64 {
        (0..self.levels).map(|level| self.level_bytes(level)).sum()
    }

    /// Data of a level: layer after layer, rows of blocks without padding. Empty for a level that does not exist.
    pub fn level(&self, level: u32) -> &'a [u8] {
        let entry = ktx2::Header::LENGTH + 24 * level as usize;
        // Bounds were checked by `parse`; a view cannot be made otherwise, so a failure here means `level >= levels`.
        let bytes = |at: usize| self.ktx2.get(at..at + 8).map_or(0, bytemuck::pod_read_unaligned::<u64>) as usize;
        if level >= self.levels {
            return &[];
        }
        let (offset, length) = (bytes(entry), bytes(entry + 8));
        self.ktx2.get(offset..offset + length).unwrap_or(&[])
    }
}
