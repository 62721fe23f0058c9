//! `ink_contours`: extracts contour lines from the posed meshes, as nodes linked along lines, and loads the brush at
//! each node. Later passes read only the nodes.

use super::{Outcome, Pass, PassId, PassStage, painting_depth, painting_wet};
use crate::contours::{ContourBlock, ContourBuffers, ContourNode, LineNode};
use crate::gpu::{
    BindingResource, ComputeSpec, DrawBindGroup, SamplerSettings, Shader, WORKGROUP, depth_texture, in_compute,
    sampler, storage_in, storage_out, texture, uniform,
};
use crate::model::ModelContours;
use crate::params::{InkLines, StyleKind};
use crate::scene::{Dispatch, Recording, VisibleContours, VisibleInstance, record_dispatches};
use pelage_formats::GeometryVertex;

/// Shader that extracts nodes from the mesh.
pub(crate) const SHADER: Shader = Shader {
    name: "pelage ink contours",
    parts: &[
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../ink/distance.wgsl"),
        include_str!("../../contours/block.wgsl"),
        include_str!("ink_contours.wgsl"),
    ],
};

/// Shader of the passes along lines.
pub(crate) const CHAINS: Shader = Shader {
    name: "pelage ink chains",
    parts: &[include_str!("../../contours/block.wgsl"), include_str!("chains.wgsl")],
};

impl PassId {
    /// Ink: contour lines as nodes.
    pub const INK_CONTOURS: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_contours",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "compute: extracts contour lines from the posed meshes, finds the ends of their visible parts, and computes \
           width, density and dryness of the brush along them",
    runs_when: "ink is painted with strokes, and a package has a contour mesh",
    shaders: &[SHADER, CHAINS],
    targets: &[],
    run,
};

/// Number of pointer-jumping rounds by which every node of a line reaches all others.
fn rounds(model: &ModelContours) -> u32 {
    model.capacity().max(2).next_power_of_two().ilog2()
}

/// Plans the extraction of an instance's nodes, and appends its dispatches.
fn extract(
    frame: &mut Recording<'_>,
    seen: &VisibleInstance,
    model: &ModelContours,
    VisibleContours { buffers, block }: &VisibleContours,
    out: &mut Vec<Dispatch>,
) {
    let Some(depth) = frame.targets.view(&painting_depth::DEPTH).cloned() else { return };
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            in_compute(uniform::<ContourBlock>(0, false)),
            storage_in::<GeometryVertex>(1),
            storage_in::<GeometryVertex>(2),
            storage_in::<u32>(3),
            storage_out::<u32>(4),
            storage_out::<u32>(5),
            storage_out::<u32>(6),
            storage_out::<ContourNode>(7),
            storage_out::<[f32; 4]>(8),
            in_compute(depth_texture(9, wgpu::TextureViewDimension::D2)),
        ]
    });
    let ContourBuffers { crossed, counts, links, nodes, states: [state, _], .. } = &**buffers;
    let geometry = [&seen.moved.posed, seen.model.geometry(), &model.mesh];
    let mut entries = vec![(0, BindingResource::block::<ContourBlock>(&block.buffer, block.offset))];
    entries.extend(
        (1..).zip(geometry.into_iter().chain([crossed, counts, links, nodes, state]).map(BindingResource::all)),
    );
    entries.push((9, BindingResource::View(depth)));
    let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
    let stages = [
        ("cross_faces", model.faces),
        ("count_crossed", WORKGROUP),
        ("place_contours", model.edges),
        ("place_creases", model.creases),
    ];
    for (entry, threads) in stages.into_iter().filter(|(_, threads)| *threads > 0) {
        let spec = ComputeSpec { shader: SHADER, entry, groups: vec![layout.clone()], constants: Vec::new() };
        let pipeline = frame.compute_pipeline(spec);
        out.push(Dispatch { pipeline, groups: vec![DrawBindGroup::of(&group)], threads });
    }
}

/// Plans the passes along an instance's lines, and appends their dispatches.
fn follow(
    frame: &mut Recording<'_>,
    model: &ModelContours,
    VisibleContours { buffers, block }: &VisibleContours,
    out: &mut Vec<Dispatch>,
) {
    let Some(wet) = frame.targets.view(&painting_wet::WET).cloned() else { return };
    let clamp = SamplerSettings::new("pelage ink", wgpu::AddressMode::ClampToEdge);
    let clamp = frame.cache.layouts.sampler(frame.gpu, clamp);
    let layout = frame.cache.layouts.get(frame.gpu, CHAINS.name, || {
        vec![
            in_compute(uniform::<ContourBlock>(0, false)),
            storage_in::<u32>(1),
            storage_in::<ContourNode>(2),
            storage_in::<[f32; 4]>(3),
            storage_out::<[f32; 4]>(4),
            storage_out::<LineNode>(5),
            in_compute(texture(6, wgpu::TextureViewDimension::D2)),
            in_compute(sampler(7)),
        ]
    });
    let ContourBuffers { counts, nodes, states: [even, odd], lines, .. } = &**buffers;
    let groups = [[even, odd], [odd, even]].map(|[before, after]| {
        let mut entries = vec![(0, BindingResource::block::<ContourBlock>(&block.buffer, block.offset))];
        entries.extend((1..).zip([counts, nodes, before, after, lines].map(BindingResource::all)));
        entries.push((6, BindingResource::View(wet.clone())));
        entries.push((7, BindingResource::Sampler(clamp.clone())));
        frame.cache.bind_groups.get(frame.gpu, CHAINS.name, &layout, entries)
    });
    let first = ["smooth_lines", "widen_lines", "narrow_lines", "begin_strokes"];
    let jumps = std::iter::repeat_n("jump_lines", rounds(model) as usize);
    for (number, entry) in first.into_iter().chain(jumps).chain(["load_brush"]).enumerate() {
        let spec = ComputeSpec { shader: CHAINS, entry, groups: vec![layout.clone()], constants: Vec::new() };
        let pipeline = frame.compute_pipeline(spec);
        let groups = vec![DrawBindGroup::of(&groups[number % 2])];
        out.push(Dispatch { pipeline, groups, threads: model.capacity() });
    }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let (mut dispatches, mut count) = (Vec::new(), 0);
    for (seen, model, contours) in instances.iter().filter_map(VisibleInstance::contour_lines) {
        frame.encoder.clear_buffer(&contours.buffers.crossed, 0, None);
        frame.encoder.clear_buffer(&contours.buffers.links, 0, None);
        extract(frame, seen, model, contours, &mut dispatches);
        follow(frame, model, contours, &mut dispatches);
        count += 1;
    }
    if dispatches.is_empty() {
        return Outcome::Skipped("no package has a contour mesh");
    }
    // Order matters: each dispatch sees the writes of those before it.
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{count} instances"))
}

#[cfg(test)]
mod tests;
