//! Offscreen render targets that can be read back.

use crate::{Gpu, StageError};
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_runtime::{RendererOptions, wgpu};

/// Colour format of the canvas. Shaders write linear values; the bytes are sRGB-encoded.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Depth format of the canvas.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Options of a canvas. They must match the [`RendererOptions`] of the renderers that draw on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanvasOptions {
    /// Colour format; must be uncompressed.
    pub color_format: wgpu::TextureFormat,
    /// Depth format.
    pub depth_format: wgpu::TextureFormat,
    /// Samples per pixel, 1 or 4.
    pub sample_count: u32,
    /// Whether depth is reversed: 1 at the near plane and 0 at the far plane.
    pub reversed_depth: bool,
}

impl Default for CanvasOptions {
    /// Returns [`COLOR_FORMAT`] and [`DEPTH_FORMAT`] with one sample and reversed depth. Reversed depth distributes
    /// precision evenly over distance, which avoids depth fighting between shells far from the camera.
    fn default() -> Self {
        Self { color_format: COLOR_FORMAT, depth_format: DEPTH_FORMAT, sample_count: 1, reversed_depth: true }
    }
}

impl From<&RendererOptions> for CanvasOptions {
    fn from(options: &RendererOptions) -> Self {
        let RendererOptions { color_format, depth_format, sample_count, reversed_depth, .. } = *options;
        Self { color_format, depth_format, sample_count, reversed_depth }
    }
}

impl CanvasOptions {
    /// Returns renderer options that match this canvas.
    pub fn renderer(&self) -> RendererOptions {
        let Self { color_format, depth_format, sample_count, reversed_depth } = *self;
        RendererOptions { color_format, depth_format, sample_count, reversed_depth, ..RendererOptions::default() }
    }
}

/// Colour and depth targets of the same size.
#[derive(Debug)]
pub struct Canvas {
    size: (u32, u32),
    color: wgpu::Texture,
    color_view: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
    depth_view: wgpu::TextureView,
    reversed_depth: bool,
}

impl Canvas {
    /// Creates targets of `size` pixels, width and height.
    pub fn new(gpu: &Gpu, size: (u32, u32), options: &CanvasOptions) -> Self {
        let ((width, height), samples) = (size, options.sample_count);
        let plain = [options.color_format.remove_srgb_suffix()];
        let texture = |label, format: wgpu::TextureFormat, samples, usage: wgpu::TextureUsages| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                // A window shows the encoded bytes of the picture, so it needs a view without sRGB decoding.
                view_formats: if usage.contains(wgpu::TextureUsages::TEXTURE_BINDING) { &plain } else { &[] },
            })
        };
        let none = wgpu::TextureUsages::empty();
        let shown = wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::TEXTURE_BINDING;
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let color = texture("canvas colour", options.color_format, 1, shown);
        let format = options.color_format;
        let multisampled = (samples > 1).then(|| view(&texture("canvas samples", format, samples, none)));
        let depth_view = view(&texture("canvas depth", options.depth_format, samples, none));
        Self { size, color_view: view(&color), color, multisampled, depth_view, reversed_depth: options.reversed_depth }
    }

    /// Begins a pass on the canvas. With `clear`, colour starts at this premultiplied linear colour and depth at the
    /// far plane. Otherwise both keep the contents of the previous pass.
    pub fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<wgpu::Color>,
    ) -> wgpu::RenderPass<'e> {
        let (view, resolve_target) = match &self.multisampled {
            Some(samples) => (samples, Some(&self.color_view)),
            None => (&self.color_view, None),
        };
        let color_load = clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
        let far = if self.reversed_depth { 0.0 } else { 1.0 };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: color_load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: clear.map_or(wgpu::LoadOp::Load, |_| wgpu::LoadOp::Clear(far)),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// Begins a pass that keeps the depth of the previous one and clears colour to transparent. `queries` counts the
    /// samples that pass the depth test between `begin_occlusion_query` and `end_occlusion_query`. Requires one sample
    /// per pixel.
    pub fn count_behind<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        queries: &'e wgpu::QuerySet,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("count"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            occlusion_query_set: Some(queries),
            ..Default::default()
        })
    }

    /// Reads the canvas back unchanged: `width * height` texels in its format, rows from the top.
    pub fn texels(&self, gpu: &Gpu) -> Result<Vec<u8>, StageError> {
        gpu.read_texture(&self.color, 0)
    }

    /// Reads back a canvas in [`COLOR_FORMAT`]: `width * height` RGBA8 pixels, sRGB-encoded, straight alpha, rows from
    /// the top, as PNG requires.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, StageError> {
        let mut pixels = self.texels(gpu)?;
        pixels.chunks_exact_mut(4).for_each(unpremultiply);
        Ok(pixels)
    }

    /// Returns a view of the picture's encoded bytes, for display on a screen.
    pub fn encoded(&self) -> wgpu::TextureView {
        let format = Some(self.color.format().remove_srgb_suffix());
        self.color.create_view(&wgpu::TextureViewDescriptor { format, ..Default::default() })
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }
}

/// Converts premultiplied, sRGB-encoded bytes to straight alpha. Divides by alpha in linear light, where it was
/// multiplied.
fn unpremultiply(pixel: &mut [u8]) {
    let alpha = pixel[3];
    if alpha == 0 || alpha == 255 {
        return;
    }
    for channel in &mut pixel[..3] {
        let linear = srgb_to_linear(*channel) / (f32::from(alpha) / 255.0);
        *channel = linear_to_srgb(linear.min(1.0));
    }
}
