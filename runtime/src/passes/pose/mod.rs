//! `pose`: skins the base mesh, once per changed pose; later passes read the posed vertices.
//!
//! Reads rest vertices, morph target deltas, joint weights and joint matrices. Writes a vertex buffer of the same
//! layout and size as the rest vertices. Packages without a skeleton skip the pass and draw their rest vertices.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, ComputeSpec, DrawBindGroup, Shader, UniformRange, storage_in};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, VisibleInstance, record_dispatches};
use bytemuck::Pod;
use pelage_formats::{GeometryVertex, MorphDelta, SkinVertex};

/// Shader for models whose morph targets are at rest.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage pose",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("still.wgsl"),
        include_str!("pose.wgsl"),
    ],
};

/// Shader for models whose morph targets are active.
pub(crate) const MORPHED: Shader = Shader {
    name: "pelage pose with morph targets",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("morphed.wgsl"),
        include_str!("pose.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: poses the vertices.
    pub const POSE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "pose",
    place: PassStage::Before,
    styles: &[StyleKind::Fur, StyleKind::Bare, StyleKind::Ink],
    lines: None,
    does: "compute: morphs and skins the base mesh once for all later passes",
    runs_when: "the package has a skeleton and the pose changed",
    shaders: &[SHADER, MORPHED],
    targets: &[],
    run,
};

fn storage_entry(binding: u32, ty: wgpu::BufferBindingType, dynamic: bool) -> wgpu::BindGroupLayoutEntry {
    let has_dynamic_offset = dynamic;
    let ty = wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    wgpu::BindGroupLayoutEntry { ty, ..storage_in::<GeometryVertex>(binding) }
}

/// Bind group layouts of the shaders.
struct Layouts {
    joints: wgpu::BindGroupLayout,
    vertices: wgpu::BindGroupLayout,
    deltas: wgpu::BindGroupLayout,
    shifts: wgpu::BindGroupLayout,
}

impl Layouts {
    fn new(frame: &mut Recording<'_>) -> Self {
        let [read, write] = [true, false].map(|read_only| wgpu::BufferBindingType::Storage { read_only });
        let layouts = &mut frame.cache.layouts;
        Self {
            joints: layouts.get(frame.gpu, "pelage joints", || vec![storage_entry(0, read, true)]),
            vertices: layouts.get(frame.gpu, "pelage pose", || {
                vec![storage_entry(0, read, false), storage_in::<SkinVertex>(1), storage_entry(2, write, false)]
            }),
            deltas: layouts
                .get(frame.gpu, "pelage morph deltas", || vec![storage_in::<u32>(0), storage_in::<MorphDelta>(1)]),
            shifts: layouts.get(frame.gpu, "pelage morph shifts", || vec![storage_entry(0, read, true)]),
        }
    }
}

/// Uploads the per-frame values of an instance; returns their bind group and offset.
fn upload_values<T: Pod>(
    frame: &mut Recording<'_>,
    label: &'static str,
    layout: &wgpu::BindGroupLayout,
    values: &[T],
) -> (wgpu::BindGroup, u64) {
    let UniformRange { buffer, offset, .. } = frame.uniforms.put_array(frame.gpu, values);
    let size = size_of_val(values) as u64;
    let groups = &mut frame.cache.bind_groups;
    (groups.get(frame.gpu, label, layout, vec![(0, BindingResource::Bytes { buffer, offset: 0, size })]), offset)
}

fn dispatch(frame: &mut Recording<'_>, layouts: &Layouts, seen: &VisibleInstance) -> Option<Dispatch> {
    let (model, moves) = (&seen.model, seen.moved.pose.as_ref()?);
    let buffers = [model.geometry(), model.skin()?, &seen.moved.posed];
    let joints = upload_values(frame, "pelage joints", &layouts.joints, &moves.joints);
    let entries = (0..).zip(buffers.map(BindingResource::all)).collect();
    let vertices = frame.cache.bind_groups.get(frame.gpu, "pelage pose", &layouts.vertices, entries);
    let mut groups = vec![DrawBindGroup::at(&joints.0, joints.1), DrawBindGroup::of(&vertices)];
    let mut bound = vec![layouts.joints.clone(), layouts.vertices.clone()];
    let morphs = model.morphs().filter(|_| moves.shifts.iter().any(|shift| *shift != 0.0));
    if let Some(morphs) = morphs {
        let entries = (0..).zip([&morphs.first, &morphs.deltas].map(BindingResource::all)).collect();
        let deltas = frame.cache.bind_groups.get(frame.gpu, "pelage morph deltas", &layouts.deltas, entries);
        let shifts = upload_values(frame, "pelage morph shifts", &layouts.shifts, &moves.shifts);
        groups.extend([DrawBindGroup::of(&deltas), DrawBindGroup::at(&shifts.0, shifts.1)]);
        bound.extend([layouts.deltas.clone(), layouts.shifts.clone()]);
    }
    let shader = if morphs.is_some() { MORPHED } else { SHADER };
    let pipeline = frame.compute_pipeline(ComputeSpec { shader, entry: "pose", groups: bound, constants: Vec::new() });
    let threads = (model.geometry().size() / size_of::<GeometryVertex>() as u64) as u32;
    Some(Dispatch { pipeline, groups, threads })
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let skinned = instances.iter().filter(|seen| seen.model.skeleton().is_some()).count();
    if skinned == 0 {
        return Outcome::Skipped("no instance has a skeleton");
    }
    let layouts = Layouts::new(frame);
    let dispatches: Vec<_> = instances.iter().filter_map(|seen| dispatch(frame, &layouts, seen)).collect();
    if dispatches.is_empty() {
        return Outcome::Skipped("no pose changed");
    }
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{} of {skinned} skinned instances changed pose", dispatches.len()))
}
