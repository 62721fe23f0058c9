//! Bind group layouts and samplers, cached by name.

use super::device::Gpu;
use std::collections::HashMap;
use std::num::NonZeroU64;

/// Sampler settings; filters are always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SamplerSettings {
    pub(crate) label: &'static str,
    pub(crate) u: wgpu::AddressMode,
    pub(crate) v: wgpu::AddressMode,
    /// Whether to interpolate between adjacent mip levels.
    pub(crate) mipmaps: bool,
    pub(crate) anisotropy: u16,
}

impl SamplerSettings {
    pub(crate) fn new(label: &'static str, mode: wgpu::AddressMode) -> Self {
        Self { label, u: mode, v: mode, mipmaps: true, anisotropy: 1 }
    }

    pub(crate) fn make(self, device: &wgpu::Device) -> wgpu::Sampler {
        device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(self.label),
            address_mode_u: self.u,
            address_mode_v: self.v,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: if self.mipmaps { wgpu::MipmapFilterMode::Linear } else { wgpu::MipmapFilterMode::Nearest },
            anisotropy_clamp: self.anisotropy,
            ..Default::default()
        })
    }
}

#[derive(Debug, Default)]
pub(crate) struct Layouts {
    groups: HashMap<&'static str, wgpu::BindGroupLayout>,
    samplers: HashMap<SamplerSettings, wgpu::Sampler>,
}

impl Layouts {
    /// Returns the layout with this name; creates it from `entries` on first use.
    pub(crate) fn get(
        &mut self,
        gpu: &Gpu,
        label: &'static str,
        entries: impl FnOnce() -> Vec<wgpu::BindGroupLayoutEntry>,
    ) -> wgpu::BindGroupLayout {
        let make = || {
            let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries() };
            gpu.device.create_bind_group_layout(&descriptor)
        };
        self.groups.entry(label).or_insert_with(make).clone()
    }

    pub(crate) fn sampler(&mut self, gpu: &Gpu, sampling: SamplerSettings) -> wgpu::Sampler {
        self.samplers.entry(sampling).or_insert_with(|| sampling.make(&gpu.device)).clone()
    }
}

fn entry(binding: u32, visibility: wgpu::ShaderStages, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

/// Returns the layout entry of a uniform block `T` for vertex and fragment shaders.
pub(crate) fn uniform<T>(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset,
        min_binding_size: NonZeroU64::new(size_of::<T>() as u64),
    };
    entry(binding, wgpu::ShaderStages::VERTEX_FRAGMENT, ty)
}

/// Returns the layout entry of a read-only array of `T` for the shader stages `visibility`.
pub(crate) fn storage<T>(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: NonZeroU64::new(size_of::<T>() as u64),
    };
    entry(binding, visibility, ty)
}

/// Returns the layout entry of an array of `T` that compute shaders read and write.
pub(crate) fn storage_out<T>(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: false },
        has_dynamic_offset: false,
        min_binding_size: NonZeroU64::new(size_of::<T>() as u64),
    };
    entry(binding, wgpu::ShaderStages::COMPUTE, ty)
}

/// Returns the layout entry of a read-only array of `T` for compute shaders.
pub(crate) fn storage_in<T>(binding: u32) -> wgpu::BindGroupLayoutEntry {
    storage::<T>(binding, wgpu::ShaderStages::COMPUTE)
}

/// Returns the entry with its visibility changed to compute shaders.
pub(crate) fn in_compute(entry: wgpu::BindGroupLayoutEntry) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { visibility: wgpu::ShaderStages::COMPUTE, ..entry }
}

/// Threads per workgroup of compute shaders, except for the one that counts strands.
pub(crate) const WORKGROUP: u32 = 64;

/// Returns the columns and rows of a dispatch of at least `count` workgroups; each dimension is limited to 65 535.
pub(crate) fn workgroups(count: u32) -> [u32; 2] {
    let columns = count.clamp(1, 65_535);
    [columns, count.div_ceil(columns)]
}

/// Returns the layout entry of a filterable float texture for fragment shaders.
pub(crate) fn texture(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension,
        multisampled: false,
    };
    entry(binding, wgpu::ShaderStages::FRAGMENT, ty)
}

/// Returns the layout entry of a depth texture for fragment shaders.
pub(crate) fn depth_texture(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    let sample_type = wgpu::TextureSampleType::Depth;
    let ty = wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false };
    entry(binding, wgpu::ShaderStages::FRAGMENT, ty)
}

/// Returns the layout entry of a filtering sampler for fragment shaders.
pub(crate) fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let ty = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    entry(binding, wgpu::ShaderStages::FRAGMENT, ty)
}
