//! `painting_ribbons`: draws the strokes of the models as ribbons into two textures, one of washes and one of full ink.

use super::{Outcome, Pass, PassId, PassStage, painting_depth};
use crate::gpu::{
    BindingResource, CLEARED, Draw, DrawBindGroup, RenderSpec, SamplerSettings, Shader, Target, begin_target,
    depth_texture, flag, record, sampler, storage, texture, uniform,
};
use crate::model::PoolStroke;
use crate::painting::{BrushPoint, PaintedModel, PaintingFrame};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, VisibleInstance};
use pelage_formats::PaintStroke;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage painting ribbons",
    parts: &[
        include_str!("../../ink/distance.wgsl"),
        include_str!("../../painting/frame.wgsl"),
        include_str!("../../painting/strokes.wgsl"),
        include_str!("painting_ribbons.wgsl"),
    ],
};

/// Washes: greatest density, coverage, nothing, and the sum of densities.
pub(crate) const WASH: Target = Target::new("pelage painting wash", wgpu::TextureFormat::Rgba16Float);
/// Full ink: densities of wet lines, of dry strokes and of dark wet strokes; light spared in eyes.
pub(crate) const INK: Target = Target::new("pelage painting ink", wgpu::TextureFormat::Rgba16Float);

/// Mineral pigments: premultiplied colour, sRGB-encoded, and opacity.
pub(crate) const PIGMENTS: Target = Target::new("pelage painting pigments", wgpu::TextureFormat::Rgba8Unorm);

const GREATEST: BlendComponent =
    BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Max };
const SUM: BlendComponent =
    BlendComponent { src_factor: BlendFactor::One, dst_factor: BlendFactor::One, operation: BlendOperation::Add };

/// Blending of [`WASH`] and [`INK`].
pub(crate) const BLENDS: [BlendState; 2] =
    [BlendState { color: GREATEST, alpha: SUM }, BlendState { color: GREATEST, alpha: GREATEST }];

impl PassId {
    /// Painted strokes: ribbons of washes and full ink.
    pub const PAINTING_RIBBONS: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "painting_ribbons",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "draws the strokes of the models as ribbons into two textures, one of washes and one of full ink",
    runs_when: "ink is painted with strokes",
    shaders: &[SHADER],
    targets: &[WASH, INK, PIGMENTS],
    run,
};

/// Vertices of a ribbon, a strip: two for each point, and two beyond each end.
const VERTICES: u32 = 2 * (PaintStroke::POINTS as u32 + 2);

fn run(frame: &mut Recording<'_>) -> Outcome {
    let Some(scene) = frame.painting.clone() else { return Outcome::Skipped("nothing is painted") };
    let targets = frame.targets.clone();
    let views = [WASH, INK, PIGMENTS, painting_depth::DEPTH].map(|target| targets.view(&target));
    let [Some(wash), Some(ink), Some(pigment), Some(depth)] = views else {
        return Outcome::Skipped("no targets");
    };
    let d2 = wgpu::TextureViewDimension::D2;
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            uniform::<PaintingFrame>(0, false),
            storage::<PoolStroke>(1, wgpu::ShaderStages::VERTEX),
            storage::<BrushPoint>(2, wgpu::ShaderStages::VERTEX),
            depth_texture(3, d2),
            texture(4, d2),
            sampler(5),
            uniform::<PaintedModel>(6, false),
        ]
    });
    let repeat = SamplerSettings::new("pelage ink", wgpu::AddressMode::Repeat);
    let repeat = frame.cache.layouts.sampler(frame.gpu, repeat);
    let paper = frame.paper();
    let instances = frame.instances.clone();
    let [mut washes, mut inks, mut pigments] = [Vec::new(), Vec::new(), Vec::new()];
    for (_, model, painted) in instances.iter().filter_map(VisibleInstance::painting) {
        let entries = vec![
            (0, BindingResource::block::<PaintingFrame>(&scene.buffer, scene.offset)),
            (1, BindingResource::all(&model.strokes)),
            (2, BindingResource::all(&painted.strokes.points)),
            (3, BindingResource::View(depth.clone())),
            (4, BindingResource::View(paper.clone())),
            (5, BindingResource::Sampler(repeat.clone())),
            (6, BindingResource::block::<PaintedModel>(&painted.block.buffer, painted.block.offset)),
        ];
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let mut draw = |fragment, target: &Target, blend, of| {
            let color = wgpu::ColorTargetState {
                format: target.format,
                blend: Some(blend),
                write_mask: wgpu::ColorWrites::ALL,
            };
            let spec = RenderSpec::screen(SHADER, ["vs_ribbon", fragment], layout.clone(), target.format);
            let topology = wgpu::PrimitiveTopology::TriangleStrip;
            let primitive = wgpu::PrimitiveState { topology, ..Default::default() };
            let constants = vec![flag("PIGMENT", *target == PIGMENTS)];
            let pipeline = frame.pipeline(RenderSpec { colors: vec![color], primitive, constants, ..spec });
            Draw {
                groups: [DrawBindGroup::of(&group), None, None, None],
                range: 0..VERTICES,
                instances: of,
                ..Draw::screen(pipeline, &group)
            }
        };
        washes.push(draw("fs_wash", &WASH, BLENDS[0], 0..model.washes));
        inks.push(draw("fs_ink_ribbon", &INK, BLENDS[1], model.washes..model.count));
        if model.has_pigments {
            let over = BlendState::PREMULTIPLIED_ALPHA_BLENDING;
            pigments.push(draw("fs_pigment", &PIGMENTS, over, 0..model.count));
        }
    }
    for (view, draws) in [(wash, &washes), (ink, &inks), (pigment, &pigments)] {
        let mut pass = begin_target(frame.encoder, SHADER.name, view, CLEARED);
        record(&mut pass, draws);
    }
    Outcome::recorded(format!("strokes of {} instances", washes.len()))
}
