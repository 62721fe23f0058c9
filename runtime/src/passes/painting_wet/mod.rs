//! `painting_wet`: spreads the pigment of wet washes, at a quarter of the picture's size.

use super::{Outcome, Pass, PassId, PassStage, painting_ribbons};
use crate::gpu::{
    BindingResource, CLEARED, Draw, RenderSpec, SamplerSettings, Shader, Target, begin_target, record, sampler,
    texture, uniform,
};
use crate::painting::PaintingFrame;
use crate::params::{InkLines, StyleKind};
use crate::scene::Recording;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage painting wet",
    parts: &[
        include_str!("../../ink/distance.wgsl"),
        include_str!("../../painting/frame.wgsl"),
        include_str!("painting_wet.wgsl"),
    ],
};

/// Washes at a quarter of the picture's size: density and coverage, blurred widely and narrowly.
pub(crate) const WET: Target = Target::reduced("pelage painting wet", wgpu::TextureFormat::Rgba16Float, 4);
/// Intermediate results of the same size.
const ROWS: Target = Target::reduced("pelage painting wet rows", wgpu::TextureFormat::Rgba16Float, 4);

impl PassId {
    /// Painted strokes: wet washes.
    pub const PAINTING_WET: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "painting_wet",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "spreads the pigment of wet washes, at a quarter of the picture's size",
    runs_when: "ink is painted with strokes",
    shaders: &[SHADER],
    targets: &[WET, ROWS],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let Some(scene) = frame.painting.clone() else { return Outcome::Skipped("nothing is painted") };
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![uniform::<PaintingFrame>(0, false), texture(1, wgpu::TextureViewDimension::D2), sampler(2)]
    });
    let clamp = SamplerSettings::new("pelage ink", wgpu::AddressMode::ClampToEdge);
    let clamp = frame.cache.layouts.sampler(frame.gpu, clamp);
    let targets = frame.targets.clone();
    let steps =
        [("fs_reduce", painting_ribbons::WASH, WET), ("fs_blur_rows", WET, ROWS), ("fs_blur_columns", ROWS, WET)];
    for (fragment, source, target) in steps {
        let [Some(source), Some(view)] = [source, target].map(|t| targets.view(&t)) else {
            return Outcome::Skipped("no targets");
        };
        let entries = vec![
            (0, BindingResource::block::<PaintingFrame>(&scene.buffer, scene.offset)),
            (1, BindingResource::View(source.clone())),
            (2, BindingResource::Sampler(clamp.clone())),
        ];
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let spec = RenderSpec::screen(SHADER, ["vs_wet", fragment], layout.clone(), target.format);
        let draw = Draw::screen(frame.pipeline(spec), &group);
        let mut pass = begin_target(frame.encoder, SHADER.name, view, CLEARED);
        record(&mut pass, [&draw]);
    }
    Outcome::recorded("washes".into())
}
