//! `strands`: draws hair as opaque ribbons of true width that face the eye, into the application's pass, with depth
//! test and depth write.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{Draw, RenderSpec, Shader, VertexLayout, attribute};
use crate::model::CORNER_BYTES;
use crate::params::StyleKind;
use crate::scene::{Recording, strand_sets};

pub(crate) const SHADER: Shader = Shader {
    name: "pelage strands",
    parts: &[
        include_str!("../../hair/packed_light.wgsl"),
        include_str!("../../shared/tone.wgsl"),
        include_str!("../../debug/false_color.wgsl"),
        include_str!("strands.wgsl"),
    ],
};

impl PassId {
    /// Single strands.
    pub const STRANDS: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "strands",
    place: PassStage::Picture,
    styles: &[StyleKind::Fur],
    lines: None,
    does: "draws strands one by one as opaque ribbons of true width that face the eye, and writes depth",
    runs_when: "single hairs are visible, the package has strands, and edges are not blended",
    shaders: &[SHADER],
    targets: &[],
    run,
};

/// Vertex layout of ribbon corners: world-space position and light.
const CORNER: VertexLayout = VertexLayout {
    stride: CORNER_BYTES,
    attributes: &[attribute(0, wgpu::VertexFormat::Float32x3, 0), attribute(1, wgpu::VertexFormat::Uint32, 12)],
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    if frame.nearest.is_some() {
        return Outcome::Skipped("strands are drawn with blended edges");
    }
    let instances = frame.instances.clone();
    let mut draws = Vec::new();
    for (seen, set) in strand_sets(&instances) {
        let Some((ribbons, indices)) = set.ribbons.and_then(|ribbons| Some((ribbons, ribbons.indices.as_ref()?)))
        else {
            continue;
        };
        let spec = RenderSpec {
            shader: SHADER,
            vertex: "vs_strands",
            fragment: Some("fs_strands"),
            groups: vec![frame.surfaces.frame.clone()],
            streams: vec![CORNER],
            constants: Vec::new(),
            primitive: wgpu::PrimitiveState::default(),
            colors: vec![frame.picture_color(false)],
            depth: Some(frame.picture_depth(true, true)),
            samples: frame.options.sample_count,
        };
        draws.push(Draw {
            pipeline: frame.pipeline(spec),
            groups: [frame.eye_group(seen), None, None, None],
            vertices: [Some(ribbons.corners.clone()), None, None, None, None],
            indices: Some(indices.clone()),
            range: 0..0,
            instances: 0..1,
            indirect: Some(ribbons.counts.clone()),
        });
    }
    if draws.is_empty() {
        return Outcome::Skipped(match instances.iter().any(|seen| !seen.model.strands().is_empty()) {
            _ if !frame.surfaces.strands => "the device has fewer storage buffers in compute shaders than strands need",
            true => "layers are requested, or single hairs are too thin to be seen on screen",
            false => "no package has strands, or they exceed the renderer's options or the device's buffers",
        });
    }
    Outcome::Ran(format!("{} sets of strands", draws.len()), draws)
}
