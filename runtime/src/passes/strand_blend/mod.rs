//! `strand_blend`: blends the nearest hair segments of each pixel into the application's pass, each at its own depth.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, Draw, DrawBindGroup, RenderSpec, Shader, flag, storage, uniform};
use crate::params::StyleKind;
use crate::scene::{NearestHairBlock, Recording};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage strand blend",
    parts: &[
        include_str!("../../hair/packed_light.wgsl"),
        include_str!("../../hair/nearest.wgsl"),
        include_str!("../../shared/tone.wgsl"),
        include_str!("../../debug/false_color.wgsl"),
        include_str!("strand_blend.wgsl"),
    ],
};

impl PassId {
    /// Nearest strands of each pixel, blended.
    pub const STRAND_BLEND: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "strand_blend",
    place: PassStage::Picture,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "blends the eight nearest pieces of hair in each pixel, the farthest first, each by its coverage; then \
         writes their depth",
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
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let read = |binding| storage::<u32>(binding, both);
        vec![read(0), read(1), read(2), uniform::<NearestHairBlock>(3, false)]
    });
    let block = frame.uniforms.put(frame.gpu, &[nearest.block]);
    let lists = &nearest.lists;
    let buffers = [&lists.keys, &lists.lights, &lists.layers];
    let mut entries: Vec<_> = (0..).zip(buffers.map(BindingResource::all)).collect();
    entries.push((3, BindingResource::block::<NearestHairBlock>(&block.buffer, block.offset)));
    let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
    let blended = frame.picture_color(true);
    let nothing = wgpu::ColorTargetState { write_mask: wgpu::ColorWrites::empty(), ..frame.picture_color(false) };
    let mut draw = |[vertex, fragment]: [&'static str; 2], color, writes_depth| {
        let spec = RenderSpec {
            shader: SHADER,
            vertex,
            fragment: Some(fragment),
            groups: vec![layout.clone()],
            streams: Vec::new(),
            constants: vec![flag("REVERSED_DEPTH", frame.options.reversed_depth)],
            primitive: wgpu::PrimitiveState::default(),
            colors: vec![color],
            depth: Some(frame.picture_depth(writes_depth, true)),
            samples: frame.options.sample_count,
        };
        Draw {
            pipeline: frame.pipeline(spec),
            groups: [DrawBindGroup::of(&group), None, None, None],
            vertices: Default::default(),
            indices: None,
            range: 0..0,
            instances: 0..1,
            indirect: Some(lists.layers.clone()),
        }
    };
    let draws = vec![draw(["vs_blend", "fs_blend"], blended, false), draw(["vs_depth", "fs_depth"], nothing, true)];
    Outcome::Ran(format!("{} tiles of the picture", nearest.tiles()), draws)
}
