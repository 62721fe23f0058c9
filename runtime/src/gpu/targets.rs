//! Textures of the picture's size that passes hand on to each other.

use super::bind_groups::BindGroups;
use super::device::Gpu;
use std::sync::Arc;

/// A texture that a pass draws to and later ones read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) label: &'static str,
    pub(crate) format: wgpu::TextureFormat,
}

/// The textures of a frame. A frame keeps those that it draws from.
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
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            (*target, texture.create_view(&wgpu::TextureViewDescriptor::default()))
        };
        Self { size, views: wanted.iter().map(make).collect() }
    }

    /// The texture of a target; `None` where no pass of the frame's style has it.
    pub(crate) fn view(&self, target: &Target) -> Option<&wgpu::TextureView> {
        self.views.iter().find(|(found, _)| found == target).map(|(_, view)| view)
    }

    /// Bytes on the GPU.
    pub(crate) fn gpu_bytes(&self) -> u64 {
        let of_pixel: u32 = self.views.iter().map(|(t, _)| t.format.block_copy_size(None).unwrap_or(4)).sum();
        u64::from(self.size[0]) * u64::from(self.size[1]) * u64::from(of_pixel)
    }

    fn holds(&self, size: [u32; 2], wanted: &[Target]) -> bool {
        self.size == size && self.views.iter().map(|(target, _)| target).eq(wanted)
    }
}

/// Keeps the textures of the last frame for the next of the same size.
#[derive(Debug, Default)]
pub(crate) struct TargetPool {
    last: Option<Arc<TargetSet>>,
}

impl TargetPool {
    /// The `wanted` textures, unless a living frame still draws from those of the last.
    pub(crate) fn take(
        &mut self,
        gpu: &Gpu,
        bind_groups: &mut BindGroups,
        size: [u32; 2],
        wanted: &[Target],
    ) -> Arc<TargetSet> {
        if wanted.is_empty() {
            return Arc::default();
        }
        let free = self.last.take().filter(|set| set.holds(size, wanted) && Arc::strong_count(set) == 1);
        let set = free.unwrap_or_else(|| {
            bind_groups.clear();
            Arc::new(TargetSet::new(gpu, size, wanted))
        });
        self.last = Some(set.clone());
        set
    }
}
