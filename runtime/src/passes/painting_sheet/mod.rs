//! `painting_sheet`: draws paper, wet washes and full ink into the application's pass, with the depth of the painted
//! surface.

use super::{Outcome, Pass, PassId, PassStage, painting_depth, painting_ribbons, painting_wet};
use crate::gpu::{
    BindingResource, Draw, RenderSpec, SamplerSettings, Shader, depth_texture, flag, sampler, texture, uniform,
};
use crate::painting::PaintingFrame;
use crate::params::{InkBackground, InkLines, StyleKind};
use crate::scene::Recording;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage painting sheet",
    parts: &[
        include_str!("../../shared/srgb.wgsl"),
        include_str!("../../ink/distance.wgsl"),
        include_str!("../../painting/frame.wgsl"),
        include_str!("painting_sheet.wgsl"),
    ],
};

impl PassId {
    /// Painted strokes: paper, washes and ink.
    pub const PAINTING_SHEET: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "painting_sheet",
    place: PassStage::Picture,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "draws paper, wet washes and full ink into the application's pass, with the depth of the painted surface",
    runs_when: "ink is painted with strokes",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let Some(scene) = frame.painting.clone() else { return Outcome::Skipped("nothing is painted") };
    let targets = frame.targets.clone();
    let reads = [
        painting_ribbons::WASH,
        painting_wet::WET,
        painting_ribbons::INK,
        painting_depth::DEPTH,
        painting_ribbons::PIGMENTS,
    ];
    let [Some(wash), Some(wet), Some(ink), Some(depth), Some(pigment)] = reads.map(|target| targets.view(&target))
    else {
        return Outcome::Skipped("no targets");
    };
    let d2 = wgpu::TextureViewDimension::D2;
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            uniform::<PaintingFrame>(0, false),
            texture(1, d2),
            texture(2, d2),
            texture(3, d2),
            depth_texture(4, d2),
            texture(5, d2),
            sampler(6),
            sampler(7),
            texture(8, d2),
        ]
    });
    let [repeat, clamp] = [wgpu::AddressMode::Repeat, wgpu::AddressMode::ClampToEdge]
        .map(|mode| frame.cache.layouts.sampler(frame.gpu, SamplerSettings::new("pelage ink", mode)));
    let entries = vec![
        (0, BindingResource::block::<PaintingFrame>(&scene.buffer, scene.offset)),
        (1, BindingResource::View(wash.clone())),
        (2, BindingResource::View(wet.clone())),
        (3, BindingResource::View(ink.clone())),
        (4, BindingResource::View(depth.clone())),
        (5, BindingResource::View(frame.paper())),
        (6, BindingResource::Sampler(repeat)),
        (7, BindingResource::Sampler(clamp)),
        (8, BindingResource::View(pigment.clone())),
    ];
    let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
    let picture = frame.params.style.ink().is_some_and(|ink| ink.background == InkBackground::Picture);
    let spec = RenderSpec {
        constants: vec![flag("PICTURE", picture)],
        colors: vec![frame.picture_color(true)],
        depth: Some(frame.picture_depth(true, false)),
        samples: frame.options.sample_count,
        ..RenderSpec::screen(SHADER, ["vs_sheet", "fs_sheet"], layout, frame.options.color_format)
    };
    let draw = Draw::screen(frame.pipeline(spec), &group);
    let [width, height] = frame.params.viewport;
    Outcome::Ran(format!("{width} x {height}"), vec![draw])
}
