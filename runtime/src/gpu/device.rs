//! Device and queue; counts the GPU objects that are created.

use super::binding_resource::BindingResource;
use crate::report::CreatedObjects;
use std::sync::atomic::{AtomicU32, Ordering};
use wgpu::util::DeviceExt;

/// Device and queue; counts the GPU objects that are created.
#[derive(Debug)]
pub(crate) struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    buffers: AtomicU32,
    textures: AtomicU32,
    bind_groups: AtomicU32,
    pipelines: AtomicU32,
}

/// Returns the size in bytes of the largest buffer that shaders can write.
pub(crate) fn largest_buffer(limits: &wgpu::Limits) -> u64 {
    limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
}

impl Gpu {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let (device, queue) = (device.clone(), queue.clone());
        let [buffers, textures, bind_groups, pipelines] = std::array::from_fn(|_| AtomicU32::new(0));
        Self { device, queue, buffers, textures, bind_groups, pipelines }
    }

    /// Returns the number of GPU objects created so far.
    pub(crate) fn created(&self) -> CreatedObjects {
        let [buffers, textures, bind_groups, pipelines] =
            [&self.buffers, &self.textures, &self.bind_groups, &self.pipelines].map(|n| n.load(Ordering::Relaxed));
        CreatedObjects { buffers, textures, bind_groups, pipelines }
    }

    pub(crate) fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.buffers.fetch_add(1, Ordering::Relaxed);
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        self.device.create_buffer(&descriptor)
    }

    pub(crate) fn buffer_of(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.buffers.fetch_add(1, Ordering::Relaxed);
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    }

    pub(crate) fn texture(&self, descriptor: &wgpu::TextureDescriptor<'_>) -> wgpu::Texture {
        self.textures.fetch_add(1, Ordering::Relaxed);
        self.device.create_texture(descriptor)
    }

    /// Creates a bind group from resources, each given with its binding number.
    pub(crate) fn bind_group(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        entries: &[(u32, BindingResource)],
    ) -> wgpu::BindGroup {
        self.bind_groups.fetch_add(1, Ordering::Relaxed);
        let entries: Vec<_> = entries
            .iter()
            .map(|(binding, bound)| wgpu::BindGroupEntry { binding: *binding, resource: bound.resource() })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries };
        self.device.create_bind_group(&descriptor)
    }

    pub(super) fn render_pipeline(&self, descriptor: &wgpu::RenderPipelineDescriptor<'_>) -> wgpu::RenderPipeline {
        self.pipelines.fetch_add(1, Ordering::Relaxed);
        self.device.create_render_pipeline(descriptor)
    }

    pub(super) fn compute_pipeline(&self, descriptor: &wgpu::ComputePipelineDescriptor<'_>) -> wgpu::ComputePipeline {
        self.pipelines.fetch_add(1, Ordering::Relaxed);
        self.device.create_compute_pipeline(descriptor)
    }
}
