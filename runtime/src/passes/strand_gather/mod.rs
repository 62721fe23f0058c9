//! `strand_gather`: finds the nearest hair segments in each pixel with a compute rasteriser, once per frame.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{
    BindingResource, ComputeSpec, DrawBindGroup, Shader, WORKGROUP, flag, in_compute, storage_in, storage_out, uniform,
};
use crate::params::StyleKind;
use crate::scene::{Dispatch, NearestHairBlock, Recording, record_dispatches, strand_sets};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand gather",
    parts: &[
        include_str!("../../hair/packed_light.wgsl"),
        include_str!("../../hair/nearest.wgsl"),
        include_str!("strand_gather.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: nearest hair segments in each pixel.
    pub const STRAND_GATHER: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "strand_gather",
    place: PassStage::Before,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "compute: finds the eight nearest pieces of hair in each pixel, and the coverage of each",
    runs_when: "strands are drawn with blended edges",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let Some(nearest) = frame.nearest.clone() else {
        return Outcome::Skipped("no strands are drawn with blended edges, or they do not fit in the device's buffers");
    };
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            storage_in::<u32>(0),
            storage_in::<[u32; 4]>(1),
            storage_out::<u32>(2),
            storage_out::<u32>(3),
            storage_out::<u32>(4),
            in_compute(uniform::<NearestHairBlock>(5, false)),
        ]
    });
    let instances = frame.instances.clone();
    let [mut gather, mut leave, mut list] = [Vec::new(), Vec::new(), Vec::new()];
    let mut count = 0;
    for (seen, set) in strand_sets(&instances) {
        let Some(ribbons) = set.ribbons else { continue };
        let pieces = set.strands.segments(set.drawn.step);
        let lists = &nearest.lists;
        // Both rounds must use one pipeline, because the second must reproduce the keys of the first bit by bit.
        let mut dispatch = |entry, round, threads| {
            let block = frame.uniforms.put(frame.gpu, &[NearestHairBlock { pieces, round, ..nearest.block }]);
            let buffers = [&ribbons.counts, &ribbons.corners, &lists.keys, &lists.lights, &lists.layers];
            let mut entries: Vec<_> = (0..).zip(buffers.map(BindingResource::all)).collect();
            entries.push((5, BindingResource::block::<NearestHairBlock>(&block.buffer, block.offset)));
            let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
            let groups = vec![frame.surfaces.frame.clone(), layout.clone()];
            let constants = vec![flag("REVERSED_DEPTH", frame.options.reversed_depth)];
            Dispatch {
                pipeline: frame.compute_pipeline(ComputeSpec { shader: SHADER, entry, groups, constants }),
                groups: vec![frame.eye_group(seen), DrawBindGroup::of(&group)],
                threads,
            }
        };
        let of_all = set.strands.count * pieces;
        gather.push(dispatch("gather", 0, of_all));
        leave.push(dispatch("gather", 1, of_all));
        if list.is_empty() {
            list.push(dispatch("list_layers", 0, nearest.tiles() * WORKGROUP));
        }
        count += of_all;
    }
    nearest.clear(frame.encoder);
    // Order matters: each dispatch sees the writes of those before it.
    gather.append(&mut leave);
    gather.append(&mut list);
    record_dispatches(frame.encoder, SHADER.name, &gather);
    Outcome::recorded(format!("at most {count} pieces, {} tiles of the picture", nearest.tiles()))
}
