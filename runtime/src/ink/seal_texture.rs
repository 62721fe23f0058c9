//! Uploaded image of a seal.

use crate::gpu::Gpu;
use pelage_formats::meaning::seal::SealImage;
use std::sync::Arc;

/// Texture of the image that was stamped last.
#[derive(Debug, Default)]
pub(crate) struct SealTexture(Option<(Arc<SealImage>, wgpu::TextureView)>);

impl SealTexture {
    /// Returns the texture of an image; uploads the image if it is another one.
    pub(crate) fn of(&mut self, gpu: &Gpu, image: &Arc<SealImage>) -> wgpu::TextureView {
        if let Some((_, view)) = self.0.as_ref().filter(|(last, _)| Arc::ptr_eq(last, image)) {
            return view.clone();
        }
        let [width, height] = image.size();
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let uploaded = gpu.texture(&wgpu::TextureDescriptor {
            label: Some("pelage ink seal"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8UnormSrgb,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * width), rows_per_image: Some(height) };
        gpu.queue.write_texture(uploaded.as_image_copy(), image.rgba(), layout, size);
        let view = uploaded.create_view(&wgpu::TextureViewDescriptor::default());
        self.0 = Some((image.clone(), view.clone()));
        view
    }
}
