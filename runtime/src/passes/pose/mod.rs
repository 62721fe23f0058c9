//! `pose`: skins the base mesh, once per changed pose; later passes read the posed vertices.
//!
//! Reads the rest vertices, the joint weights and the joint matrices; writes a vertex buffer of the same layout and size as the
//! rest vertices. Packages without a skeleton skip it and draw their rest vertices.

use super::{Outcome, Pass, PassId, PassPlace};
use crate::gpu::{Bound, ComputeSpec, Group, Place, Shader, storage_in};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, Seen, record_dispatches};
use glam::Mat4;
use pelage_formats::{GeometryVertex, SkinVertex};

/// The shader.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage pose",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("pose.wgsl"),
    ],
};

impl PassId {
    /// Compute: poses the vertices.
    pub const POSE: Self = Self(&PASS);
}

/// The pass.
pub(crate) const PASS: Pass = Pass {
    name: "pose",
    place: PassPlace::Before,
    styles: &[StyleKind::Fur, StyleKind::Bare, StyleKind::Ink],
    does: "compute: skins the base mesh once for all later passes",
    runs_when: "the package has a skeleton and the pose changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn storage_entry(binding: u32, ty: wgpu::BufferBindingType, dynamic: bool) -> wgpu::BindGroupLayoutEntry {
    let has_dynamic_offset = dynamic;
    let ty = wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None };
    wgpu::BindGroupLayoutEntry { ty, ..storage_in::<GeometryVertex>(binding) }
}

fn dispatch(
    frame: &mut Recording<'_>,
    pipeline: &wgpu::ComputePipeline,
    layouts: [&wgpu::BindGroupLayout; 2],
    seen: &Seen,
) -> Option<Dispatch> {
    let (model, joints) = (&seen.model, seen.moved.joints.as_ref()?);
    let Place { buffer, offset, .. } = frame.uniforms.put_array(frame.gpu, joints);
    let size = (joints.len() * size_of::<Mat4>()) as u64;
    let groups = &mut frame.cache.bind_groups;
    let joints =
        groups.get(frame.gpu, "pelage joints", layouts[0], vec![(0, Bound::Bytes { buffer, offset: 0, size })]);
    let buffers = [model.geometry(), model.skin()?, &seen.moved.geometry];
    let vertices = groups.get(frame.gpu, "pelage pose", layouts[1], (0..).zip(buffers.map(Bound::all)).collect());
    let threads = (model.geometry().size() / size_of::<GeometryVertex>() as u64) as u32;
    Some(Dispatch {
        pipeline: pipeline.clone(),
        groups: vec![Group::at(&joints, offset), Group::of(&vertices)],
        threads,
    })
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let skinned = instances.iter().filter(|seen| seen.model.skeleton().is_some()).count();
    if skinned == 0 {
        return Outcome::Skipped("no instance has a skeleton");
    }
    let [read, write] = [true, false].map(|read_only| wgpu::BufferBindingType::Storage { read_only });
    let layouts = &mut frame.cache.layouts;
    let joints = layouts.get(frame.gpu, "pelage joints", || vec![storage_entry(0, read, true)]);
    let vertices = layouts.get(frame.gpu, "pelage pose", || {
        vec![storage_entry(0, read, false), storage_in::<SkinVertex>(1), storage_entry(2, write, false)]
    });
    let groups = vec![joints.clone(), vertices.clone()];
    let spec = ComputeSpec { shader: SHADER, entry: "pose", groups, constants: Vec::new() };
    let pipeline = frame.compute_pipeline(spec);
    let dispatches: Vec<_> =
        instances.iter().filter_map(|seen| dispatch(frame, &pipeline, [&joints, &vertices], seen)).collect();
    if dispatches.is_empty() {
        return Outcome::Skipped("no pose changed");
    }
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{} of {skinned} skinned instances changed pose", dispatches.len()))
}
