//! `ink_seal`: stamps the seal on an ink painting, in the application's pass.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, Draw, RenderSpec, SamplerSettings, Shader, depth_state, sampler, texture, uniform};
use crate::params::{InkParams, Seal, StyleKind};
use crate::scene::Recording;
use crate::shared::shader_struct::shader_struct;

pub(crate) const SHADER: Shader = Shader { name: "pelage ink seal", parts: &[include_str!("ink_seal.wgsl")] };

impl PassId {
    /// Ink: seal.
    pub const INK_SEAL: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_seal",
    place: PassStage::Picture,
    styles: &[StyleKind::Ink],
    lines: None,
    does: "stamps the seal on the painting",
    runs_when: "the painting has a seal",
    shaders: &[SHADER],
    targets: &[],
    run,
};

shader_struct! {
    /// Uniform block of a seal, in shader layout.
    pub(crate) struct StampedSeal {
        pub(crate) center: [f32; 2],
        pub(crate) half_size: [f32; 2],
        pub(crate) texels_per_px: f32,
        pub(crate) paper_period: f32,
        pub(crate) paper_grain: f32,
        pub(crate) reserved: f32,
    }
}

impl StampedSeal {
    fn new(seal: &Seal, ink: &InkParams, viewport: [u32; 2]) -> Self {
        let [width, height] = viewport.map(|n| n as f32);
        let [columns, rows] = seal.image.size().map(|n| n as f32);
        let half_height = 0.5 * seal.height;
        Self {
            center: seal.center.to_array(),
            half_size: [half_height * columns / rows * height / width, half_height],
            texels_per_px: rows / (seal.height * height),
            paper_period: ink.paper_period_px,
            paper_grain: ink.paper_grain,
            reserved: 0.0,
        }
    }
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let params = frame.params;
    let Some((ink, seal)) = params.style.ink().and_then(|ink| Some((ink, ink.seal.as_ref()?))) else {
        return Outcome::Skipped("the painting has no seal");
    };
    let block = frame.uniforms.put(frame.gpu, &[StampedSeal::new(seal, ink, params.viewport)]);
    let image = frame.seal.of(frame.gpu, &seal.image);
    let d2 = wgpu::TextureViewDimension::D2;
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![uniform::<StampedSeal>(0, false), texture(1, d2), texture(2, d2), sampler(3), sampler(4)]
    });
    let [clamp, repeat] = [wgpu::AddressMode::ClampToEdge, wgpu::AddressMode::Repeat]
        .map(|mode| frame.cache.layouts.sampler(frame.gpu, SamplerSettings::new("pelage ink", mode)));
    let entries = vec![
        (0, BindingResource::block::<StampedSeal>(&block.buffer, block.offset)),
        (1, BindingResource::View(image)),
        (2, BindingResource::View(frame.paper())),
        (3, BindingResource::Sampler(clamp)),
        (4, BindingResource::Sampler(repeat)),
    ];
    let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
    let spec = RenderSpec {
        colors: vec![frame.picture_color(true)],
        depth: Some(depth_state(frame.options.depth_format, false, wgpu::CompareFunction::Always)),
        samples: frame.options.sample_count,
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        ..RenderSpec::screen(SHADER, ["vs_seal", "fs_seal"], layout, frame.options.color_format)
    };
    let draw = Draw { range: 0..4, ..Draw::screen(frame.pipeline(spec), &group) };
    let [width, height] = seal.image.size();
    Outcome::Ran(format!("an image of {width} x {height} pixels"), vec![draw])
}
