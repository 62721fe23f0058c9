//! Targets to draw on without a window, and to read back.

use crate::{Gpu, StageError};
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_runtime::wgpu;

/// Colour of the canvas: linear values in, sRGB bytes out.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Depth of the canvas.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Colour and depth targets of one size.
#[derive(Debug)]
pub struct Canvas {
    width: u32,
    height: u32,
    color: wgpu::Texture,
    color_view: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
    depth_view: wgpu::TextureView,
}

impl Canvas {
    /// Targets of `width × height` pixels with `sample_count` samples each, in [`COLOR_FORMAT`].
    pub fn new(gpu: &Gpu, width: u32, height: u32, sample_count: u32) -> Self {
        Self::in_format(gpu, COLOR_FORMAT, width, height, sample_count)
    }

    /// As [`Self::new`], in another format of colour.
    pub fn in_format(gpu: &Gpu, format: wgpu::TextureFormat, width: u32, height: u32, sample_count: u32) -> Self {
        let texture = |label, format, samples, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let none = wgpu::TextureUsages::empty();
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let color = texture("canvas colour", format, 1, wgpu::TextureUsages::COPY_SRC);
        let multisampled = (sample_count > 1).then(|| view(&texture("canvas samples", format, sample_count, none)));
        let depth_view = view(&texture("canvas depth", DEPTH_FORMAT, sample_count, none));
        Self { width, height, color_view: view(&color), color, multisampled, depth_view }
    }

    /// Begins a pass on the canvas. With `clear`, colour starts at that premultiplied linear RGBA and depth at the far end of
    /// `reversed_depth`'s range; without, both go on from the pass before.
    pub fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<[f64; 4]>,
        reversed_depth: bool,
    ) -> wgpu::RenderPass<'e> {
        let (view, resolve_target) = match &self.multisampled {
            Some(samples) => (samples, Some(&self.color_view)),
            None => (&self.color_view, None),
        };
        let color_load =
            clear.map_or(wgpu::LoadOp::Load, |[r, g, b, a]| wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a }));
        let far = if reversed_depth { 0.0 } else { 1.0 };
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

    /// Reads the canvas back as it is: `width * height` texels of its format, rows from the top.
    pub fn texels(&self, gpu: &Gpu) -> Result<Vec<u8>, StageError> {
        gpu.read_texture(&self.color, 0)
    }

    /// Reads the canvas back: `width * height` RGBA8, sRGB-encoded, straight alpha, rows from the top; as PNG wants it.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, StageError> {
        let mut pixels = self.texels(gpu)?;
        pixels.chunks_exact_mut(4).for_each(unpremultiply);
        Ok(pixels)
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }
}

/// Premultiplied, sRGB-encoded bytes to straight ones. The product with alpha was taken on linear light, so it is undone there.
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
