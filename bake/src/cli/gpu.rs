//! A device without a window, and a canvas to draw on and read back: what `render`, `bench` and `demo` share.

use super::exit::Failure;
use pelage_bake::BakeError;
use pelage_runtime::wgpu;

/// Colour of the canvas: linear values in, sRGB bytes out.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
/// Depth of the canvas.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Device, queue, and what the adapter can measure. A clone is another handle of the same device.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name, driver and kind of the adapter.
    pub info: wgpu::AdapterInfo,
}

impl Gpu {
    /// Opens the adapter that wgpu prefers; `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` choose another one.
    pub fn open() -> Result<Self, Failure> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(wgpu::util::initialize_adapter_from_env_or_default(&instance, None))
            .map_err(|error| Failure::NoAdapter(error.to_string()))?;
        let wanted = wgpu::Features::TEXTURE_COMPRESSION_BC
            | wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | wgpu::Features::PIPELINE_STATISTICS_QUERY;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("pelage"),
            required_features: wanted & adapter.features(),
            required_limits: adapter.limits(),
            ..Default::default()
        }))
        .map_err(|error| Failure::NoAdapter(error.to_string()))?;
        Ok(Self { device, queue, info: adapter.get_info() })
    }

    /// Blocks until everything submitted so far is done.
    pub fn wait(&self) -> Result<(), Failure> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(lost)
    }
}

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
    pub fn texels(&self, gpu: &Gpu) -> Result<Vec<u8>, Failure> {
        read_texture(gpu, &self.color, 0)
    }

    /// Reads the canvas back: `width * height` RGBA8, sRGB-encoded, straight alpha, rows from the top; as PNG wants it.
    pub fn read(&self, gpu: &Gpu) -> Result<image::RgbaImage, Failure> {
        let mut pixels = self.texels(gpu)?;
        pixels.chunks_exact_mut(4).for_each(unpremultiply);
        image::RgbaImage::from_raw(self.width, self.height, pixels)
            .ok_or_else(|| lost("the canvas was read back short"))
    }
}

/// A device that stopped answering: a fault of driver or machine that no input explains.
pub fn lost(error: impl std::fmt::Display) -> Failure {
    BakeError::Internal(format!("the graphics device failed: {error}")).into()
}

/// Maps a buffer that the device has finished writing and copies it out.
pub fn read_buffer(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, Failure> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result)));
    gpu.wait()?;
    receiver.recv().map_err(lost)?.map_err(lost)?;
    let bytes = buffer.slice(..).get_mapped_range().map_err(lost)?.to_vec();
    buffer.unmap();
    Ok(bytes)
}

/// The texels of one array layer of an uncompressed texture with `COPY_SRC`, row-major, without padding.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture, layer: u32) -> Result<Vec<u8>, Failure> {
    let (width, height) = (texture.width(), texture.height());
    let texel_bytes = texture.format().block_copy_size(None).ok_or_else(|| lost("a texture without a texel size"))?;
    let row_bytes = width * texel_bytes;
    let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("texture readback"),
        size: u64::from(padded) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: 0, z: layer }, ..texture.as_image_copy() },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = read_buffer(gpu, &buffer)?;
    Ok(bytes.chunks_exact(padded as usize).flat_map(|row| &row[..row_bytes as usize]).copied().collect())
}

/// Premultiplied, sRGB-encoded bytes to straight ones. The product with alpha was taken on linear light, so it is undone there.
fn unpremultiply(pixel: &mut [u8]) {
    let alpha = pixel[3];
    if alpha == 0 || alpha == 255 {
        return;
    }
    for channel in &mut pixel[..3] {
        let linear = pelage_formats::meaning::srgb_to_linear(*channel) / (f32::from(alpha) / 255.0);
        *channel = pelage_formats::meaning::linear_to_srgb(linear.min(1.0));
    }
}
