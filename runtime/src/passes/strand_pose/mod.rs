//! `strand_pose`: places the points of all strands on the posed mesh, once per changed pose.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, ComputeSpec, DrawBindGroup, Shader, in_compute, storage_in, storage_out, uniform};
use crate::hair::growth_and_wetness_constants;
use crate::model::{Strand, StrandConstants, StrandSource, SurfacePoint};
use crate::params::StyleKind;
use crate::scene::{Dispatch, Recording, record_dispatches, strand_sets};
use pelage_formats::GeometryVertex;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand pose",
    parts: &[
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../hair/constants.wgsl"),
        include_str!("../../hair/strand.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("strand_pose.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: places strands on the posed mesh.
    pub const STRAND_POSE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "strand_pose",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: places the points of a coat's strands on the posed skin once for all later passes, for as many \
         strands as those passes use",
    runs_when: "strands of a coat are drawn, and the pose changed",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    // Skip early: a device that cannot draw single hairs cannot create the layouts below.
    if !frame.instances.iter().any(|seen| seen.look.strands) {
        return Outcome::Skipped("no strands of a coat are drawn, or no pose changed");
    }
    let instances = frame.instances.clone();
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            storage_in::<GeometryVertex>(0),
            storage_in::<SurfacePoint>(1),
            storage_in::<Strand>(2),
            storage_in::<[u32; 4]>(3),
            in_compute(uniform::<StrandConstants>(4, false)),
            storage_out::<[f32; 4]>(5),
        ]
    });
    let mut dispatches = Vec::new();
    for (seen, set) in strand_sets(&instances) {
        let StrandSource::Fur { stands } = &set.strands.growth else { continue };
        if !set.posed.stale {
            continue;
        }
        let strands = set.strands;
        for (part, of_part) in set.parts(seen.model.parts(), set.posed.share) {
            let entries = vec![
                (0, BindingResource::all(&seen.moved.geometry)),
                (1, BindingResource::all(stands)),
                (2, BindingResource::all(&strands.strands)),
                (3, BindingResource::all(&strands.tile)),
                (4, frame.strand_constants(&set, &of_part, &set.drawn.full_detail())),
                (5, BindingResource::all(&set.posed.buffer)),
            ];
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let groups = vec![layout.clone(), frame.surfaces.material.clone()];
            let constants = growth_and_wetness_constants(&seen.model, part);
            let spec = ComputeSpec { shader: SHADER, entry: "pose_strands", groups, constants };
            dispatches.push(Dispatch {
                pipeline: frame.compute_pipeline(spec),
                groups: vec![DrawBindGroup::of(&group), DrawBindGroup::of(&part.material)],
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
