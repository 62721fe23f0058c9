//! `painting_strokes`: places the strokes of a model on the picture, and determines pressure, density and dryness of
//! the brush along them.

use super::{Outcome, Pass, PassId, PassStage, painting_depth};
use crate::gpu::{
    BindingResource, ComputeSpec, DrawBindGroup, Shader, depth_texture, in_compute, storage_in, storage_out, uniform,
};
use crate::model::{PoolPoint, PoolStroke};
use crate::painting::{BrushPoint, PaintedModel, PaintingFrame};
use crate::params::{InkLines, StyleKind};
use crate::scene::{Dispatch, Recording, VisibleInstance, record_dispatches};
use pelage_formats::GeometryVertex;

pub(crate) const SHADER: Shader = Shader {
    name: "pelage painting strokes",
    parts: &[
        include_str!("../../shared/frame.wgsl"),
        include_str!("../../shared/skinning.wgsl"),
        include_str!("../../hair/triangle_frame.wgsl"),
        include_str!("../../surface/geometry.wgsl"),
        include_str!("../../ink/distance.wgsl"),
        include_str!("../../painting/frame.wgsl"),
        include_str!("../../painting/strokes.wgsl"),
        include_str!("painting_strokes.wgsl"),
    ],
};

impl PassId {
    /// Compute pass: strokes of the models on the picture.
    pub const PAINTING_STROKES: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "painting_strokes",
    place: PassStage::Before,
    styles: &[StyleKind::Ink],
    lines: Some(InkLines::Strokes),
    does: "compute: places the strokes of the models on the picture, and determines pressure, density and dryness of \
           the brush along them",
    runs_when: "ink is painted with strokes",
    shaders: &[SHADER],
    targets: &[],
    run,
};

fn run(frame: &mut Recording<'_>) -> Outcome {
    let Some(scene) = frame.painting.clone() else { return Outcome::Skipped("nothing is painted") };
    let targets = frame.targets.clone();
    let Some(depth) = targets.view(&painting_depth::DEPTH) else { return Outcome::Skipped("no targets") };
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || {
        vec![
            storage_in::<GeometryVertex>(0),
            storage_in::<PoolStroke>(1),
            storage_in::<PoolPoint>(2),
            storage_out::<BrushPoint>(3),
            in_compute(uniform::<PaintingFrame>(4, false)),
            in_compute(uniform::<PaintedModel>(5, false)),
            in_compute(depth_texture(6, wgpu::TextureViewDimension::D2)),
        ]
    });
    let instances = frame.instances.clone();
    let (mut dispatches, mut count) = (Vec::new(), 0);
    for (seen, model, painted) in instances.iter().filter_map(VisibleInstance::painting) {
        let entries = vec![
            (0, BindingResource::all(&seen.moved.geometry)),
            (1, BindingResource::all(&model.strokes)),
            (2, BindingResource::all(&model.points)),
            (3, BindingResource::all(&painted.strokes.points)),
            (4, BindingResource::block::<PaintingFrame>(&scene.buffer, scene.offset)),
            (5, BindingResource::block::<PaintedModel>(&painted.block.buffer, painted.block.offset)),
            (6, BindingResource::View(depth.clone())),
        ];
        let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
        let groups = vec![frame.surfaces.frame.clone(), layout.clone()];
        let spec = ComputeSpec { shader: SHADER, entry: "pose_painting", groups, constants: Vec::new() };
        dispatches.push(Dispatch {
            pipeline: frame.compute_pipeline(spec),
            groups: vec![frame.eye_group(seen), DrawBindGroup::of(&group)],
            threads: model.count,
        });
        count += model.count;
    }
    record_dispatches(frame.encoder, SHADER.name, &dispatches);
    Outcome::recorded(format!("{count} strokes of {} instances", dispatches.len()))
}
