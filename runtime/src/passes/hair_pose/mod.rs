//! `hair_pose`: places hair on guides where the posed skin has their roots, once per changed pose.

use super::{Outcome, Pass, PassId, PassPlace};
use crate::gpu::{Bound, ComputeSpec, Group, Shader, storage, storage_out, uniform};
use crate::model::{Growth, HairRoot, StrandConstants};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches};
use pelage_formats::GeometryVertex;

/// The shader.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage hair pose",
    wgsl: concat!(
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("hair_pose.wgsl"),
    ),
};

impl PassId {
    /// Compute: places hair on guides on the posed skin.
    pub const HAIR_POSE: Self = Self(&PASS);
}

/// The pass.
pub(crate) const PASS: Pass = Pass {
    name: "hair_pose",
    place: PassPlace::Before,
    styles: &[StyleKind::Fur],
    does: "compute: turns guides with the skin they root in, and places the points of the hairs that follow them",
    runs_when: "hair on guides is drawn, and the pose changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let nothing = Outcome::Skipped("no hair on guides is drawn, or no pose changed");
    // A device that cannot draw it cannot make this layout.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return nothing;
    }
    let instances = frame.instances.clone();
    let compute = wgpu::ShaderStages::COMPUTE;
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        let constants = wgpu::BindGroupLayoutEntry { visibility: compute, ..uniform::<StrandConstants>(6, false) };
        vec![
            storage::<GeometryVertex>(0, compute),
            storage::<[u32; 4]>(1, compute),
            storage::<[f32; 4]>(2, compute),
            storage_out::<[f32; 4]>(3),
            storage::<HairRoot>(4, compute),
            storage_out::<[f32; 4]>(5),
            constants,
        ]
    });
    let (mut guides, mut hairs) = (Vec::new(), Vec::new());
    let mut count = 0;
    for (seen, set) in instances.iter().flat_map(|seen| seen.strands().map(move |set| (seen, set))) {
        let (Growth::Guided(guided), Some(posed_guides)) = (&set.strands.growth, &set.posed.guides) else { continue };
        if !set.posed.stale {
            continue;
        }
        for (number, (_, of_part)) in set.parts(seen.model.parts()).enumerate() {
            let place = frame.uniforms.put(frame.gpu, &[set.strands.constants(of_part, 1.0, 1.0)]);
            let buffer = |binding, buffer: &wgpu::Buffer| (binding, Bound::Buffer(buffer.clone()));
            let entries = vec![
                buffer(0, &seen.moved.geometry),
                buffer(1, &guided.triangles),
                buffer(2, &guided.guides),
                buffer(3, posed_guides),
                buffer(4, &guided.hairs),
                buffer(5, &set.posed.buffer),
                (6, Bound::block::<StrandConstants>(&place.buffer, place.offset)),
            ];
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let mut dispatch = |entry, threads| {
                let groups = vec![layout.clone()];
                let spec = ComputeSpec { shader: SHADER, entry, groups, constants: Vec::new() };
                Dispatch { pipeline: frame.compute_pipeline(spec), groups: vec![Group::of(&group)], threads }
            };
            if number == 0 {
                // All of them at once, whatever part they root in.
                guides.push(dispatch("pose_guides", set.strands.points * guided.guide_count));
            }
            hairs.push(dispatch("pose_hairs", set.strands.points * of_part.len() as u32));
            count += of_part.len();
        }
    }
    if hairs.is_empty() {
        return nothing;
    }
    // Hairs follow guides that are posed.
    guides.append(&mut hairs);
    record_dispatches(frame.encoder, SHADER.name, &guides);
    Outcome::recorded(format!("{count} hairs"))
}
