//! Resources that bindings refer to.

use std::num::NonZeroU64;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BindingResource {
    /// Range of `size` bytes from `offset`.
    Bytes {
        buffer: wgpu::Buffer,
        offset: u64,
        size: u64,
    },
    Buffer(wgpu::Buffer),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl BindingResource {
    /// Returns a binding of the whole buffer.
    pub(crate) fn all(buffer: &wgpu::Buffer) -> Self {
        Self::Buffer(buffer.clone())
    }

    /// Returns a binding of a block of `T` from `offset`.
    pub(crate) fn block<T>(buffer: &wgpu::Buffer, offset: u64) -> Self {
        Self::Bytes { buffer: buffer.clone(), offset, size: size_of::<T>() as u64 }
    }

    pub(super) fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Bytes { buffer, offset, size } => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: *offset,
                size: NonZeroU64::new(*size),
            }),
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::View(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}
