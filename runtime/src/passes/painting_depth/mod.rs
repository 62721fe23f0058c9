//! `painting_depth`: draws the depth of all surfaces, by which strokes are hidden.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{RenderSpec, Shader, Target, depth_state, record};
use crate::hair::material_constants;
use crate::model::Part;
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, depth_compare};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage painting depth",
    parts: &[
        include_str!("../../shared/frame.wgsl"),
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../shared/tile_frame.wgsl"),
        include_str!("../../surface/place.wgsl"),
        include_str!("painting_depth.wgsl"),
    ],
};

pub(crate) const DEPTH: Target = Target::new("pelage painting depth", wgpu::TextureFormat::Depth32Float);

impl PassId {
    /// Painted strokes: depth of surfaces.
    pub const PAINTING_DEPTH: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "painting_depth",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "draws the depth of all surfaces, by which strokes are hidden",
    runs_when: "ink is painted with strokes",
    shaders: &[SHADER],
    targets: &[DEPTH],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let mut draws = Vec::new();
    for seen in instances.iter().filter(|seen| seen.in_picture()) {
        let spec = |frame: &Recording<'_>, part: &Part| {
            let sides = [seen.look.mirrored, part.double_sided];
            let entries = ["vs_painting_depth", "fs_painting_depth"];
            let mut spec = frame.picture_spec(SHADER, entries, material_constants(part), sides, false);
            spec.groups.truncate(2);
            RenderSpec {
                colors: Vec::new(),
                depth: Some(depth_state(DEPTH.format, true, depth_compare(false, frame.options.reversed_depth))),
                samples: 1,
                ..spec
            }
        };
        draws.extend(frame.part_draws(seen, |_| true, [frame.eye_group(seen), None], 0..1, spec));
    }
    let targets = frame.targets.clone();
    let Some(view) = targets.view(&DEPTH) else { return Outcome::Skipped("no targets") };
    let far = if frame.options.reversed_depth { 0.0 } else { 1.0 };
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(SHADER.name),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    record(&mut pass, &draws);
    Outcome::recorded(format!("{} parts", draws.len()))
}
