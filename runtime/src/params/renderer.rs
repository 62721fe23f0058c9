//! Options set once per renderer.

use crate::error::RuntimeError;

/// Options that are set once; they describe the application's render pass. They must match the pass that
/// [`crate::Frame::draw`] records into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RendererOptions {
    /// Format of the single colour target (default `Rgba8UnormSrgb`). The shaders write linear light with premultiplied
    /// opacity; an sRGB format encodes it.
    pub color_format: wgpu::TextureFormat,
    /// Format of the depth buffer (default `Depth32Float`).
    pub depth_format: wgpu::TextureFormat,
    /// Samples per pixel of both targets (default 1).
    pub sample_count: u32,
    /// Whether depth is 1 at the near plane and 0 at the far plane (default false). If so, the pass must clear depth to
    /// 0.
    pub reversed_depth: bool,
    /// Anisotropy of the base-colour texture's sampler, 1..=16 (default 1). Hair textures are always sampled without
    /// anisotropy.
    pub anisotropy: u16,
    /// Maximum number of single fur strands per model (default 300 000); 0 for none. Guided hair is not affected.
    ///
    /// A model that would have up to twice as many gets a share of them, each correspondingly wider. Models with still
    /// more strands are drawn in layers at any distance.
    ///
    /// Strands are placed at load time, in about a microsecond each. A strand of nine points takes 176 bytes in GPU
    /// memory, and 320 to 660 more while it is drawn.
    pub max_strands: u32,
}

impl Default for RendererOptions {
    fn default() -> Self {
        Self {
            color_format: wgpu::TextureFormat::Rgba8UnormSrgb,
            depth_format: wgpu::TextureFormat::Depth32Float,
            sample_count: 1,
            reversed_depth: false,
            anisotropy: 1,
            max_strands: 300_000,
        }
    }
}

impl RendererOptions {
    pub(crate) fn check(&self, device: &wgpu::Device) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected| Err(RuntimeError::Options { field, found, expected });
        let color = self.color_format.guaranteed_format_features(device.features());
        let drawable = color.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT)
            && color.flags.contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
        if !drawable {
            return fail(
                "color_format",
                format!("{:?}", self.color_format),
                "a format that this device can draw to with blending",
            );
        }
        if !self.depth_format.has_depth_aspect() {
            return fail("depth_format", format!("{:?}", self.depth_format), "a depth format");
        }
        let specific = device.features().contains(wgpu::Features::TEXTURE_ADAPTER_SPECIFIC_FORMAT_FEATURES);
        let supported =
            color.flags.sample_count_supported(self.sample_count) || (specific && self.sample_count.is_power_of_two());
        if !supported {
            return fail(
                "sample_count",
                self.sample_count.to_string(),
                "1, 4, or what the adapter offers for this format",
            );
        }
        if !(1..=16).contains(&self.anisotropy) {
            return fail("anisotropy", self.anisotropy.to_string(), "1..=16");
        }
        Ok(())
    }
}
