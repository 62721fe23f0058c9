//! Upload of buffers and textures of a package, checked against the device limits.

use crate::error::RuntimeError;
use crate::gpu::Gpu;
use pelage_formats::{FurTextures, Package, TextureFormat, TextureView};

/// Uploads the contents of a package directly from the slices that it borrows, without a copy.
pub(crate) struct Uploader<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) package: &'a Package<'a>,
}

impl Uploader<'_> {
    pub(super) fn content(&self, what: String, reason: String) -> RuntimeError {
        RuntimeError::Content { package: self.package.manifest().model.clone(), what, reason }
    }

    fn texture_name(&self, index: u32) -> &str {
        self.package.manifest().textures.get(index as usize).map_or("", |t| &t.name)
    }

    fn within(
        &self,
        what: impl Fn() -> String,
        found: u64,
        limit: &'static str,
        allowed: u64,
    ) -> Result<(), RuntimeError> {
        if found > allowed {
            return Err(RuntimeError::DeviceLimit { what: what(), found, limit, allowed });
        }
        Ok(())
    }

    pub(crate) fn buffer(
        &self,
        name: &str,
        contents: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, RuntimeError> {
        let limits = self.gpu.device.limits();
        let what = || format!("size in bytes of the {name} of package {:?}", self.package.manifest().model);
        self.within(what, contents.len() as u64, "max_buffer_size", limits.max_buffer_size)?;
        if usage.contains(wgpu::BufferUsages::STORAGE) {
            let allowed = limits.max_storage_buffer_binding_size;
            self.within(what, contents.len() as u64, "max_storage_buffer_binding_size", allowed)?;
        }
        let label = format!("pelage {name}");
        Ok(self.gpu.buffer_of(&label, contents, usage))
    }

    /// Returns the texture format to use on the device. Compressed blocks are decoded here, once, if the device cannot
    /// sample them or is a software rasteriser, which would decode them at every texel fetch.
    ///
    /// On software rasterisers, two-byte texels are expanded to four bytes. Four-byte texels are fetched eight at a
    /// time, two-byte texels one by one, which makes reading directions a quarter slower.
    fn device_format(&self, format: TextureFormat) -> TextureFormat {
        let software = self.gpu.device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let samples_blocks = self.gpu.device.features().contains(wgpu::Features::TEXTURE_COMPRESSION_BC);
        if format == TextureFormat::Rgba16Float {
            return format;
        }
        let plain = format.block_size() == 1;
        if software || !(plain || samples_blocks) { format.decoded() } else { format }
    }

    pub(super) fn device_bytes(&self, view: &TextureView<'_>) -> u64 {
        view.gpu_bytes_as(self.device_format(view.format))
    }

    /// Returns the size of the colour and direction textures on the device, bytes.
    pub(super) fn hair_bytes(&self, textures: &FurTextures<'_>) -> u64 {
        self.device_bytes(&textures.color).saturating_add(self.device_bytes(&textures.direction))
    }

    /// Uploads the colours and directions of hair as array textures.
    pub(super) fn hair(
        &self,
        color: u32,
        direction: u32,
        textures: &FurTextures<'_>,
    ) -> Result<[wgpu::TextureView; 2], RuntimeError> {
        Ok([self.array(color, &textures.color)?, self.array(direction, &textures.direction)?])
    }

    /// Uploads a texture with all its array layers.
    pub(super) fn array(&self, index: u32, view: &TextureView<'_>) -> Result<wgpu::TextureView, RuntimeError> {
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        let all = wgpu::TextureViewDescriptor { dimension, ..Default::default() };
        Ok(self.texture(index, view)?.create_view(&all))
    }

    pub(crate) fn texture(&self, index: u32, view: &TextureView<'_>) -> Result<wgpu::Texture, RuntimeError> {
        let name = self.texture_name(index);
        let limits = self.gpu.device.limits();
        let edge = view.width.max(view.height);
        let what = |what: &str| format!("{what} of texture {name:?} of package {:?}", self.package.manifest().model);
        self.within(
            || what("size in texels"),
            edge.into(),
            "max_texture_dimension_2d",
            limits.max_texture_dimension_2d.into(),
        )?;
        let (layers, allowed) = (view.layers.into(), limits.max_texture_array_layers.into());
        self.within(|| what("array layers"), layers, "max_texture_array_layers", allowed)?;
        let format = self.device_format(view.format);
        let block = format.block_size();
        if !view.width.is_multiple_of(block) || !view.height.is_multiple_of(block) {
            let reason = format!(
                "{} x {} texels of {}, expected multiples of {block}: WebGPU has no partial blocks",
                view.width,
                view.height,
                view.format.name()
            );
            return Err(self.content(format!("texture {name:?}"), reason));
        }
        let texture = self.gpu.texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width: view.width, height: view.height, depth_or_array_layers: view.layers },
            mip_level_count: view.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu_format(format),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for level in 0..view.levels {
            let (width, height) = view.level_size(level);
            let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
            let decoded: Vec<u8>;
            let texels = if format == view.format {
                view.level(level)
            } else {
                let layers: Option<Vec<_>> = (0..view.layers).map(|layer| view.rgba8(level, layer)).collect();
                let fault = || self.content(format!("texture {name:?}"), format!("level {level} cannot be decoded"));
                decoded = layers.ok_or_else(fault)?.concat();
                &decoded
            };
            self.gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: level,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                },
                texels,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(columns * format.block_bytes()),
                    rows_per_image: Some(rows),
                },
                // The extent covers whole blocks, because small mip levels of compressed textures are stored in whole
                // blocks.
                wgpu::Extent3d { width: columns * block, height: rows * block, depth_or_array_layers: view.layers },
            );
        }
        Ok(texture)
    }
}

fn wgpu_format(format: TextureFormat) -> wgpu::TextureFormat {
    match format {
        TextureFormat::Rgba8Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
        TextureFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        TextureFormat::Rg8Unorm => wgpu::TextureFormat::Rg8Unorm,
        TextureFormat::Bc7Srgb => wgpu::TextureFormat::Bc7RgbaUnormSrgb,
        TextureFormat::Bc7Unorm => wgpu::TextureFormat::Bc7RgbaUnorm,
        TextureFormat::Bc5Unorm => wgpu::TextureFormat::Bc5RgUnorm,
        TextureFormat::Rgba16Float => wgpu::TextureFormat::Rgba16Float,
    }
}
