//! `strand_pose`: places the points of all strands on the posed skin, once per changed pose.

use super::{Outcome, Pass, PassId, PassPlace};
use crate::gpu::{Bound, ComputeSpec, Group, Shader, storage, storage_out, uniform};
use crate::hair::grown;
use crate::model::{Growth, Stand, Strand, StrandConstants};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches};
use pelage_formats::GeometryVertex;

/// The shader.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand pose",
    wgsl: concat!(
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/strand.wgsl"),
        include_str!("strand_pose.wgsl"),
    ),
};

impl PassId {
    /// Compute: places strands on the posed skin.
    pub const STRAND_POSE: Self = Self(&PASS);
}

/// The pass.
pub(crate) const PASS: Pass = Pass {
    name: "strand_pose",
    place: PassPlace::Before,
    styles: &[StyleKind::Fur],
    does: "compute: places the points of a coat's strands on the posed skin once for all later passes",
    runs_when: "strands of a coat are drawn, and the pose changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    // A device that cannot draw them cannot make these layouts.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return Outcome::Skipped("no strands of a coat are drawn, or no pose changed");
    }
    let instances = frame.instances.clone();
    let compute = wgpu::ShaderStages::COMPUTE;
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        let constants = wgpu::BindGroupLayoutEntry { visibility: compute, ..uniform::<StrandConstants>(4, false) };
        vec![
            storage::<GeometryVertex>(0, compute),
            storage::<Stand>(1, compute),
            storage::<Strand>(2, compute),
            storage::<[u32; 4]>(3, compute),
            constants,
            storage_out::<[f32; 4]>(5),
        ]
    });
    let mut dispatches = Vec::new();
    for (seen, set) in instances.iter().flat_map(|seen| seen.strands().map(move |set| (seen, set))) {
        let Growth::Coat { stands } = &set.strands.growth else { continue };
        if !set.posed.stale {
            continue;
        }
        let strands = set.strands;
        for (part, of_part) in set.parts(seen.model.parts()) {
            let place = frame.uniforms.put(frame.gpu, &[strands.constants(of_part, 1.0, 1.0)]);
            let buffer = |binding, buffer: &wgpu::Buffer| (binding, Bound::Buffer(buffer.clone()));
            let entries = vec![
                buffer(0, &seen.moved.geometry),
                buffer(1, stands),
                buffer(2, &strands.strands),
                buffer(3, &strands.tile),
                (4, Bound::block::<StrandConstants>(&place.buffer, place.offset)),
                buffer(5, &set.posed.buffer),
            ];
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let groups = vec![layout.clone(), frame.surfaces.material.clone()];
            let constants = grown(&seen.model, part);
            let spec = ComputeSpec { shader: SHADER, entry: "pose_strands", groups, constants };
            dispatches.push(Dispatch {
                pipeline: frame.compute_pipeline(spec),
                groups: vec![Group::of(&group), Group::of(&part.material)],
                threads: strands.points * of_part.len() as u32,
            });
        }
    }
    if dispatches.is_empty() {
        return Outcome::Skipped("no strands of a coat are drawn, or no pose changed");
    }
    let strands: u32 = dispatches.len() as u32;
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("strands of {strands} parts"))
}
