//! Device and queue of the application, and everything created with them. A frame can report what it created; objects
//! are cached by their descriptors.

mod bind_groups;
mod bound;
mod cache;
mod device;
mod draw;
mod layouts;
mod pipelines;
mod shelf;
mod targets;
mod uniforms;

pub(crate) use bound::Bound;
pub(crate) use cache::Cache;
pub(crate) use device::{Gpu, largest_buffer};
pub(crate) use draw::{Draw, Group, record};
pub(crate) use layouts::{
    Sampling, WORKGROUP, depth_texture, in_compute, sampler, storage, storage_in, storage_out, texture, uniform,
    workgroups,
};
pub(crate) use pipelines::{ComputeSpec, Constants, RenderSpec, Shader, Stream, attribute, depth_state, faces, on};
pub(crate) use shelf::Shelf;
pub(crate) use targets::{Target, TargetSet, take_targets};
pub(crate) use uniforms::{Place, Ring, Uniforms};
