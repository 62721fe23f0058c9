//! Texel formats.

/// Texel format of a texture in a package.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureFormat {
    /// Four bytes per texel, RGBA, colour sRGB-encoded.
    Rgba8Srgb,
    /// Four bytes per texel, RGBA.
    Rgba8Unorm,
    /// Two bytes per texel, two components.
    Rg8Unorm,
    /// 16 bytes per 4×4 block, RGBA, colour sRGB-encoded.
    Bc7Srgb,
    /// 16 bytes per 4×4 block, RGBA.
    Bc7Unorm,
    /// 16 bytes per 4×4 block, two components.
    Bc5Unorm,
    /// Eight bytes per texel: four IEEE 754 binary16 numbers.
    Rgba16Float,
}

impl TextureFormat {
    /// All formats, for tables.
    pub const ALL: [Self; 7] = [
        Self::Rgba8Srgb,
        Self::Rgba8Unorm,
        Self::Rg8Unorm,
        Self::Bc7Srgb,
        Self::Bc7Unorm,
        Self::Bc5Unorm,
        Self::Rgba16Float,
    ];

    pub(super) fn from_ktx2(format: ktx2::Format) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.ktx2() == format)
    }

    /// Returns the format as a type of the `ktx2` crate.
    pub fn ktx2(self) -> ktx2::Format {
        match self {
            Self::Rgba8Srgb => ktx2::Format::R8G8B8A8_SRGB,
            Self::Rgba8Unorm => ktx2::Format::R8G8B8A8_UNORM,
            Self::Rg8Unorm => ktx2::Format::R8G8_UNORM,
            Self::Bc7Srgb => ktx2::Format::BC7_SRGB_BLOCK,
            Self::Bc7Unorm => ktx2::Format::BC7_UNORM_BLOCK,
            Self::Bc5Unorm => ktx2::Format::BC5_UNORM_BLOCK,
            Self::Rgba16Float => ktx2::Format::R16G16B16A16_SFLOAT,
        }
    }

    /// Returns the edge length of a compressed block, texels: 4, or 1 for uncompressed formats.
    pub fn block_size(self) -> u32 {
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm | Self::Rg8Unorm | Self::Rgba16Float => 1,
            Self::Bc7Srgb | Self::Bc7Unorm | Self::Bc5Unorm => 4,
        }
    }

    /// Returns the size of a block, bytes. In uncompressed formats, a block is a texel.
    pub fn block_bytes(self) -> u32 {
        match self {
            Self::Rgba8Srgb | Self::Rgba8Unorm => 4,
            Self::Rg8Unorm => 2,
            Self::Rgba16Float => 8,
            Self::Bc7Srgb | Self::Bc7Unorm | Self::Bc5Unorm => 16,
        }
    }

    /// Returns the size of one number in a texel, bytes: 1 or 2. A big-endian machine would have to swap the bytes of
    /// each number.
    pub fn type_size(self) -> u32 {
        if self == Self::Rgba16Float { 2 } else { 1 }
    }

    /// Returns the number of channels of a sampler's result that carry data.
    pub fn components(self) -> u32 {
        match self {
            Self::Rg8Unorm | Self::Bc5Unorm => 2,
            Self::Rgba8Srgb | Self::Rgba8Unorm | Self::Bc7Srgb | Self::Bc7Unorm | Self::Rgba16Float => 4,
        }
    }

    /// Returns the name in WebGPU.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rgba8Srgb => "rgba8unorm-srgb",
            Self::Rgba8Unorm => "rgba8unorm",
            Self::Rg8Unorm => "rg8unorm",
            Self::Bc7Srgb => "bc7-rgba-unorm-srgb",
            Self::Bc7Unorm => "bc7-rgba-unorm",
            Self::Bc5Unorm => "bc5-rg-unorm",
            Self::Rgba16Float => "rgba16float",
        }
    }

    /// Whether a sampler decodes sRGB.
    pub fn is_srgb(self) -> bool {
        matches!(self, Self::Rgba8Srgb | Self::Bc7Srgb)
    }

    /// Returns the size of one layer of `width × height` texels, bytes; `u64::MAX` if larger.
    pub fn layer_bytes(self, width: u32, height: u32) -> u64 {
        let blocks = |texels: u32| u64::from(texels.div_ceil(self.block_size()));
        (blocks(width) * blocks(height)).saturating_mul(self.block_bytes().into())
    }
}
