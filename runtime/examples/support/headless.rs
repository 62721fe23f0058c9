//! A device without a window, and pictures read back from it.

use pelage_runtime::{RendererOptions, wgpu};

/// A device of the best adapter.
pub struct Gpu {
    /// The adapter's description.
    pub info: wgpu::AdapterInfo,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
}

impl Gpu {
    /// Opens the adapter, with the features of `wanted` that it has.
    pub fn open(wanted: wgpu::Features) -> Result<Self, String> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        let instance = wgpu::Instance::new(descriptor);
        pollster::block_on(async {
            let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await;
            let adapter =
                adapter.map_err(|e| format!("no usable adapter: {e}; on Linux install mesa-vulkan-drivers"))?;
            let descriptor = wgpu::DeviceDescriptor {
                required_features: wanted & adapter.features(),
                ..wgpu::DeviceDescriptor::default()
            };
            let opened = adapter.request_device(&descriptor).await;
            let (device, queue) = opened.map_err(|e| format!("the adapter gives no device: {e}"))?;
            Ok(Self { info: adapter.get_info(), device, queue })
        })
    }

    /// Waits until everything submitted is done.
    pub fn wait(&self) {
        self.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    }

    /// Reads a whole buffer made with `MAP_READ`.
    pub fn map(&self, staging: &wgpu::Buffer) -> Vec<u8> {
        staging.slice(..).map_async(wgpu::MapMode::Read, Result::unwrap);
        self.wait();
        staging.slice(..).get_mapped_range().unwrap().to_vec()
    }

    /// Reads the texels of one array layer of a texture with `COPY_SRC`, row-major from the top.
    pub fn texels(&self, texture: &wgpu::Texture, layer: u32) -> Vec<u8> {
        let row = texture.width() * texture.format().block_copy_size(None).unwrap();
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(padded * texture.height()),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: 0, z: layer }, ..texture.as_image_copy() },
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
        );
        self.queue.submit([encoder.finish()]);
        let data = self.map(&staging);
        data.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect()
    }
}

/// Off-screen targets as an application would own them: colour, depth, and with several samples a resolved picture.
pub struct Targets {
    color: wgpu::TextureView,
    resolved: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
    picture: wgpu::Texture,
    reversed_depth: bool,
}

impl Targets {
    /// Targets that match `options`.
    pub fn new(gpu: &Gpu, size: (u32, u32), options: &RendererOptions) -> Self {
        let texture = |format, sample_count, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let picture = texture(options.color_format, 1, attachment | wgpu::TextureUsages::COPY_SRC);
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let depth = view(&texture(options.depth_format, options.sample_count, attachment));
        let (color, resolved) = if options.sample_count > 1 {
            (view(&texture(options.color_format, options.sample_count, attachment)), Some(view(&picture)))
        } else {
            (view(&picture), None)
        };
        Self { color, resolved, depth, picture, reversed_depth: options.reversed_depth }
    }

    /// Begins the application's pass: colour cleared to `clear`, depth to the far end.
    pub fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, clear: wgpu::Color) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("application"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: self.resolved.as_ref(),
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(if self.reversed_depth { 0.0 } else { 1.0 }),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Begins another pass behind [`Self::begin`]'s depth, which it goes on with: colour cleared to transparent, and the samples that pass
    /// the depth test counted by query 0 of `queries` between `begin_occlusion_query` and its end. One sample per pixel only.
    #[allow(dead_code, reason = "not every example counts")]
    pub fn count_behind<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        queries: &'e wgpu::QuerySet,
    ) -> wgpu::RenderPass<'e> {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("count"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            occlusion_query_set: Some(queries),
            ..Default::default()
        })
    }

    /// Reads the picture back: `width * height` texels of the colour format, row-major from the top.
    pub fn read(&self, gpu: &Gpu) -> Vec<u8> {
        gpu.texels(&self.picture, 0)
    }
}
