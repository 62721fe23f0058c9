//! Device and queue of the application, and all objects created with them. Objects are cached by their descriptors, and
//! counted so that a frame can report how many it created.

mod bind_groups;
mod binding_resource;
mod cache;
mod device;
mod draw;
mod layouts;
mod pipelines;
mod pool;
mod targets;
mod uniforms;

pub(crate) use binding_resource::BindingResource;
pub(crate) use cache::Cache;
pub(crate) use device::{Gpu, largest_buffer};
pub(crate) use draw::{CLEARED, Draw, DrawBindGroup, begin_target, record};
pub(crate) use layouts::{
    SamplerSettings, WORKGROUP, depth_texture, in_compute, sampler, storage, storage_in, storage_out, texture, uniform,
    workgroups,
};
#[cfg(feature = "study")]
pub use pipelines::ShaderVariant;
pub(crate) use pipelines::{
    ComputeSpec, Constants, RenderSpec, Shader, VertexLayout, attribute, depth_state, flag, primitive_state,
};
pub(crate) use pool::Pool;
pub(crate) use targets::{Target, TargetSet, take_targets};
pub(crate) use uniforms::{UniformRange, UniformRing, UniformSlot};
