//! Textures of the picture's size or a fraction of it, in which passes store results for later passes.

use super::device::Gpu;
use super::pool::Pool;
use std::sync::Arc;

/// Texture that a pass draws to and later passes read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    pub(crate) label: &'static str,
    pub(crate) format: wgpu::TextureFormat,
    /// Pixels of the picture per texel, along each axis.
    pub(crate) step: u32,
}

impl Target {
    /// Returns a target of the picture's size.
    pub(crate) const fn new(label: &'static str, format: wgpu::TextureFormat) -> Self {
        Self { label, format, step: 1 }
    }

    /// Returns a target with one texel per `step` pixels along each axis.
    pub(crate) const fn reduced(label: &'static str, format: wgpu::TextureFormat, step: u32) -> Self {
        Self { label, format, step }
    }

    fn size(&self, picture: [u32; 2]) -> [u32; 2] {
        picture.map(|side| side.div_ceil(self.step))
    }
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
            let [width, height] = target.size(size);
            let texture = gpu.texture(&wgpu::TextureDescriptor {
                label: Some(target.label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
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
        let of_target = |(target, _): &(Target, wgpu::TextureView)| {
            let [width, height] = target.size(self.size).map(u64::from);
            width * height * u64::from(target.format.block_copy_size(None).unwrap_or(4))
        };
        self.views.iter().map(of_target).sum()
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
