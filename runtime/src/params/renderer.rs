//! What is set once.

use crate::error::RuntimeError;

/// Set once: what the application's render pass looks like. It must match the pass that [`crate::Frame::draw`] records into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RendererOptions {
    /// Format of the one colour target (default `Rgba8UnormSrgb`). The shaders write linear light with premultiplied opacity;
    /// an sRGB format encodes it.
    pub color_format: wgpu::TextureFormat,
    /// Format of the depth buffer (default `Depth32Float`).
    pub depth_format: wgpu::TextureFormat,
    /// Samples per pixel of both (default 1).
    pub sample_count: u32,
    /// Near is 1 and far is 0 (default false): the pass clears depth to 0, nearer is greater.
    pub reversed_depth: bool,
    /// Anisotropy of the base-colour texture's sampler, 1..=16 (default 1). Hair textures are always read with 1.
    pub anisotropy: u16,
    /// How many single strands of a coat a model may have (default 300 000). Of one that would have more, but not twice as many, a share stands for all,
    /// each as much wider; others keep their layers near by. Each is planted when the model is loaded, in about a microsecond, and takes 176 bytes
    /// on the GPU where it has nine points, while it is drawn 320 to 660 more. 0 plants none. It does not concern hair on guides.
    pub most_strands: u32,
}

impl Default for RendererOptions {
    fn default() -> Self {
        Self {
            color_format: wgpu::TextureFormat::Rgba8UnormSrgb,
            depth_format: wgpu::TextureFormat::Depth32Float,
            sample_count: 1,
            reversed_depth: false,
            anisotropy: 1,
            most_strands: 300_000,
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
