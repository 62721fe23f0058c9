//! `ink_normals`: draws the model's surface into three textures of the picture's size. They hold normals in the frame
//! perpendicular to the view, with 1 / clip w; wash and line parameters; and depth. The ink style reads all geometry
//! from them, so that the cost of later passes does not depend on the mesh.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{Draw, RenderSpec, Shader, Target, VertexLayout, attribute, depth_state, flag, record};
use crate::hair::material_constants;
use crate::model::Part;
use crate::params::{InkLines, StyleKind};
use crate::scene::{Recording, VisibleInstance, depth_compare, has_strokes, ink_surface_wgsl};
use crate::surface::BARE_NORMALS;
use pelage_formats::{GeometryVertex, InkVertex};
use std::mem::offset_of;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage ink normals",
    parts: ink_surface_wgsl!(crate::study::form_wgsl!("ink/surface_forms.wgsl"), include_str!("ink_normals.wgsl")),
};

/// Normals and 1 / clip w. Eight bits are too few, because dot products of normals are compared with thresholds close
/// to 1.
pub(crate) const NORMALS: Target = Target::new("pelage ink normals", wgpu::TextureFormat::Rgba16Float);
/// Wash, stroke, line width, dryness.
pub(crate) const SURFACES: Target = Target::new("pelage ink surfaces", wgpu::TextureFormat::Rgba8Unorm);
pub(crate) const DEPTH: Target = Target::new("pelage ink depth", wgpu::TextureFormat::Depth32Float);

/// Attributes of the third vertex stream: the stored [`GeometryVertex`].
pub(crate) const REST_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    attribute(9, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, position)),
    attribute(10, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, normal)),
];
/// Attributes of the fourth vertex stream: [`InkVertex`].
pub(crate) const INK_ATTRIBUTES: [wgpu::VertexAttribute; 2] = [
    attribute(11, wgpu::VertexFormat::Snorm16x2, offset_of!(InkVertex, wash)),
    attribute(12, wgpu::VertexFormat::Unorm8x4, offset_of!(InkVertex, amount)),
];

impl PassId {
    /// Ink: normals, wash and sphere-map stroke of surfaces.
    pub const INK_NORMALS: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "ink_normals",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Pixels),
    does: "draws all surfaces into three textures of the picture's size, which the other ink passes read: depth; \
           the face's normal, in the frame perpendicular to the view, and 1 / clip w; \
           grey of the wash, grey of the sphere map's stroke, width and dryness of lines",
    runs_when: "ink lines are found in pixels",
    shaders: &[SHADER],
    targets: &[NORMALS, SURFACES, DEPTH],
    run,
};

/// Clear value: white, without strokes or lines.
const NOTHING: wgpu::Color = wgpu::Color { r: 1.0, g: 1.0, b: 0.0, a: 0.0 };

fn spec(
    frame: &Recording<'_>,
    seen: &VisibleInstance,
    part: &Part,
    model_layout: &wgpu::BindGroupLayout,
    strokes: bool,
) -> RenderSpec {
    let mut constants = material_constants(part);
    constants.push(flag("FUR_STROKES", strokes && part.furred));
    let stored = [VertexLayout::of::<GeometryVertex>(&REST_ATTRIBUTES), VertexLayout::of::<InkVertex>(&INK_ATTRIBUTES)];
    let sides = [seen.look.mirrored, part.double_sided];
    let bare_normals = seen.model.bare_normals().is_some();
    let vertex = if bare_normals { "vs_ink_with_normals" } else { "vs_ink" };
    let mut spec = frame.picture_spec(SHADER, [vertex, "fs_ink"], constants, sides, false);
    spec.groups[2] = model_layout.clone();
    spec.streams.extend(stored);
    spec.streams.extend(bare_normals.then_some(BARE_NORMALS));
    RenderSpec {
        colors: vec![NORMALS.format.into(), SURFACES.format.into()],
        depth: Some(depth_state(DEPTH.format, true, depth_compare(false, frame.options.reversed_depth))),
        samples: 1,
        ..spec
    }
}

fn draws(frame: &mut Recording<'_>, index: usize, seen: &VisibleInstance) -> Vec<Draw> {
    let (Some((layout, group)), Some(ink)) = (frame.ink_model_group(index, None), seen.model.ink()) else {
        return Vec::new();
    };
    let strokes = frame.params.style.ink().is_some_and(|params| has_strokes(seen, params));
    let groups = [frame.eye_group(seen), Some(group)];
    let spec = |frame: &Recording<'_>, part: &Part| spec(frame, seen, part, &layout, strokes);
    let mut draws = frame.part_draws(seen, |_| true, groups, 0..1, spec);
    for draw in &mut draws {
        draw.vertices[2] = Some(seen.model.geometry().clone());
        draw.vertices[3] = Some(ink.vertices.clone());
        draw.vertices[4] = seen.model.bare_normals().cloned();
    }
    draws
}

fn run(frame: &mut Recording<'_>) -> Outcome {
    let instances = frame.instances.clone();
    let mut all = Vec::new();
    for (index, seen) in instances.iter().enumerate().filter(|(_, seen)| seen.in_picture()) {
        all.extend(draws(frame, index, seen));
    }
    let targets = frame.targets.clone();
    let [Some(normals), Some(surfaces), Some(depth)] = [NORMALS, SURFACES, DEPTH].map(|t| targets.view(&t)) else {
        return Outcome::Skipped("no targets");
    };
    let cleared = |view, color| {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store };
        Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
    };
    let far = if frame.options.reversed_depth { 0.0 } else { 1.0 };
    let mut pass = frame.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("pelage ink normals"),
        color_attachments: &[cleared(normals, wgpu::Color::TRANSPARENT), cleared(surfaces, NOTHING)],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(far), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    record(&mut pass, &all);
    let [width, height] = frame.params.viewport;
    let shown = instances.iter().filter(|seen| seen.in_picture()).count();
    Outcome::recorded(format!("{shown} instances, {} parts, {width} x {height}", all.len()))
}
