//! Textures of the picture's size, in which passes store results for later passes.

use super::device::Gpu;
use super::pool::Pool;
use std::sync::Arc;

/// Texture that a pass draws to and later passes read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) label: &'static str,
    pub(crate) format: wgpu::TextureFormat,
}

/// Textures of a frame. A frame holds references to those textures that it draws from.
#[derive(Debug, Default)]
pub(crate) struct TargetSet {
    size: [u32; 2],
    views: Vec<(Target, wgpu::TextureView)>,
}

impl TargetSet {
    fn new(gpu: &Gpu, size: [u32; 2], wanted: &[Target]) -> Self {
        let make = |target: &Target| {
            let texture = gpu.texture(&wgpu::TextureDescriptor {
                label: Some(target.label),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: target.format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                    | wgpu::TextureUsages::TEXTURE_BINDING
                    | if cfg!(test) { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() },
                view_formats: &[],
            });
            (*target, texture.create_view(&wgpu::TextureViewDescriptor::default()))
        };
        Self { size, views: wanted.iter().map(make).collect() }
    }

    /// Returns the texture of a target; `None` if no pass of the frame's style uses it.
    pub(crate) fn view(&self, target: &Target) -> Option<&wgpu::TextureView> {
        self.views.iter().find(|(found, _)| found == target).map(|(_, view)| view)
    }

    pub(crate) fn gpu_bytes(&self) -> u64 {
        let of_pixel: u32 = self.views.iter().map(|(t, _)| t.format.block_copy_size(None).unwrap_or(4)).sum();
        u64::from(self.size[0]) * u64::from(self.size[1]) * u64::from(of_pixel)
    }

    fn holds(&self, size: [u32; 2], wanted: &[Target]) -> bool {
        self.size == size && self.views.iter().map(|(target, _)| target).eq(wanted)
    }
}

/// Returns a set that has the `wanted` textures and that no existing frame draws from.
pub(crate) fn take_targets(
    shelf: &mut Pool<TargetSet>,
    gpu: &Gpu,
    size: [u32; 2],
    wanted: &[Target],
) -> Arc<TargetSet> {
    if wanted.is_empty() {
        return Arc::default();
    }
    let set = shelf.take(|set| set.holds(size, wanted)).unwrap_or_else(|| TargetSet::new(gpu, size, wanted));
    shelf.put(set)
}
