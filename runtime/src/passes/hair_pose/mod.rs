//! `hair_pose`: places guided hair at its roots on the posed mesh, once per changed pose.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, ComputeSpec, DrawBindGroup, Shader, in_compute, storage_in, storage_out, uniform};
use crate::model::{HairRoot, StrandConstants, StrandSource};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches, strand_sets};
use pelage_formats::GeometryVertex;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage hair pose",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/triangle_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("hair_pose.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: places guided hair on the posed mesh.
    pub const HAIR_POSE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "hair_pose",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: rotates guides with the skin at their roots, and places the points of the hairs that follow them",
    runs_when: "guided hair is drawn, and the pose changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let nothing = Outcome::Skipped("no guided hair is drawn, or no pose changed");
    // Skip early: a device that cannot draw single hairs cannot create the layout below.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return nothing;
    }
    let instances = frame.instances.clone();
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            storage_in::<GeometryVertex>(0),
            storage_in::<[u32; 4]>(1),
            storage_in::<[f32; 4]>(2),
            storage_out::<[f32; 4]>(3),
            storage_in::<HairRoot>(4),
            storage_out::<[f32; 4]>(5),
            in_compute(uniform::<StrandConstants>(6, false)),
        ]
    });
    let (mut guides, mut hairs) = (Vec::new(), Vec::new());
    let mut count = 0;
    for (seen, set) in strand_sets(&instances) {
        let (StrandSource::Guided(guided), Some(posed_guides)) = (&set.strands.growth, &set.posed.guides) else {
            continue;
        };
        if !set.posed.stale {
            continue;
        }
        for (number, (_, of_part)) in set.parts(seen.model.parts(), 1.0).enumerate() {
            let entries = vec![
                (0, BindingResource::all(&seen.moved.geometry)),
                (1, BindingResource::all(&guided.triangles)),
                (2, BindingResource::all(&guided.guides)),
                (3, BindingResource::all(posed_guides)),
                (4, BindingResource::all(&guided.hairs)),
                (5, BindingResource::all(&set.posed.buffer)),
                (6, frame.strand_constants(&set, &of_part, &set.drawn.full_detail())),
            ];
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let mut dispatch = |entry, threads| {
                let groups = vec![layout.clone()];
                let spec = ComputeSpec { shader: SHADER, entry, groups, constants: Vec::new() };
                Dispatch { pipeline: frame.compute_pipeline(spec), groups: vec![DrawBindGroup::of(&group)], threads }
            };
            // `hair_motion` poses the guides that move.
            if number == 0 && !set.posed.is_moved(&seen.moved, guided) {
                // A single dispatch poses the guides of all parts.
                guides.push(dispatch("pose_guides", set.strands.points * guided.guide_count));
            }
            hairs.push(dispatch("pose_hairs", set.strands.points * of_part.len() as u32));
            count += of_part.len();
        }
    }
    if hairs.is_empty() {
        return nothing;
    }
    // Hairs read the posed guides, so their dispatches come last.
    guides.append(&mut hairs);
    record_dispatches(frame.encoder, SHADER.name, &guides);
    Outcome::recorded(format!("{count} hairs"))
}
