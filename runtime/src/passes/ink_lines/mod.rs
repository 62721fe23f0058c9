//! `ink_lines`: draws contour lines as ribbons over the full ink of other strokes.

use super::painting_ribbons::{BLENDS, INK};
use super::{Outcome, Pass, PassId, PassStage};
use crate::contours::{ContourBlock, LineNode};
use crate::gpu::{
    BindingResource, Draw, DrawBindGroup, RenderSpec, SamplerSettings, Shader, begin_target, record, sampler, storage,
    texture, uniform,
};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, VisibleInstance};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage ink lines",
    parts: &[include_str!("../../contours/block.wgsl"), include_str!("ink_lines.wgsl")],
};

impl PassId {
    /// Ink: contour lines as ribbons.
    pub const INK_LINES: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_lines",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "draws contour lines as ribbons of ink density",
    runs_when: "ink is painted with strokes, and a package has a contour mesh",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            uniform::<ContourBlock>(0, false),
            storage::<LineNode>(1, wgpu::ShaderStages::VERTEX),
            texture(2, wgpu::TextureViewDimension::D2),
            sampler(3),
        ]
    });
    let repeat = SamplerSettings::new("pelage ink", wgpu::AddressMode::Repeat);
    let repeat = frame.cache.layouts.sampler(frame.gpu, repeat);
    let paper = frame.paper();
    let color =
        wgpu::ColorTargetState { format: INK.format, blend: Some(BLENDS[1]), write_mask: wgpu::ColorWrites::ALL };
    let mut draws = Vec::new();
    for (_, _, contours) in instances.iter().filter_map(VisibleInstance::contour_lines) {
        let entries = vec![
            (0, BindingResource::block::<ContourBlock>(&contours.block.buffer, contours.block.offset)),
            (1, BindingResource::all(&contours.buffers.lines)),
            (2, BindingResource::View(paper.clone())),
            (3, BindingResource::Sampler(repeat.clone())),
        ];
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let spec = RenderSpec::screen(SHADER, ["vs_line", "fs_line"], layout.clone(), INK.format);
        let topology = wgpu::PrimitiveTopology::TriangleStrip;
        let primitive = wgpu::PrimitiveState { topology, ..Default::default() };
        let pipeline = frame.pipeline(RenderSpec { colors: vec![color.clone()], primitive, ..spec });
        draws.push(Draw {
            groups: [DrawBindGroup::of(&group), None, None, None],
            indirect: Some(contours.buffers.counts.clone()),
            ..Draw::screen(pipeline, &group)
        });
    }
    if draws.is_empty() {
        return Outcome::Skipped("no package has a contour mesh");
    }
    let targets = frame.targets.clone();
    let Some(view) = targets.view(&INK) else { return Outcome::Skipped("no targets") };
    let mut pass = begin_target(frame.encoder, SHADER.name, view, wgpu::LoadOp::Load);
    record(&mut pass, &draws);
    Outcome::recorded(format!("lines of {} instances", draws.len()))
}
