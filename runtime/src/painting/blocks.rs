//! Uniform blocks of the painting passes.

use crate::camera::depth_rows;
use crate::model::ModelPainting;
use crate::params::{BrushSheet, InkParams};
use crate::shared::shader_struct::shader_struct;
use crate::shared::srgb::encoded;
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::Bounds;

shader_struct! {
    /// Uniform block for a frame, in shader layout.
    pub(crate) struct PaintingFrame {
        pub(crate) ink: [f32; 3],
        pub(crate) unit_px: f32,
        pub(crate) paper: [f32; 3],
        pub(crate) paper_grain: f32,
        pub(crate) size: [f32; 2],
        pub(crate) paper_period: f32,
        pub(crate) far_depth: f32,
        pub(crate) depth_rows: [f32; 4],
        pub(crate) right_ws: [f32; 3],
        pub(crate) wash: f32,
        pub(crate) up_ws: [f32; 3],
        pub(crate) wetness: f32,
        pub(crate) back_ws: [f32; 3],
        pub(crate) dryness: f32,
        pub(crate) strokes: f32,
        pub(crate) tufts: f32,
        pub(crate) mist_from: f32,
        pub(crate) mist_to: f32,
        pub(crate) ground: f32,
        pub(crate) progress: f32,
        pub(crate) bleed: f32,
        pub(crate) weave: f32,
        pub(crate) reserved: [f32; 3],
        pub(crate) pressure: f32,
    }
}

shader_struct! {
    /// Uniform block for an instance, in shader layout.
    pub(crate) struct PaintedModel {
        pub(crate) ground_ws: [f32; 3],
        pub(crate) size: f32,
        pub(crate) count: u32,
        pub(crate) darks: f32,
        pub(crate) tufts: f32,
        pub(crate) reach: f32,
    }
}

impl PaintedModel {
    /// Arguments: strokes of the model; placement and length scale of the instance; bounds of the model at rest.
    pub(crate) fn new(model: &ModelPainting, world_from_model: Mat4, scale: f32, bounds: Bounds) -> Self {
        let [x, _, z] = bounds.center;
        Self {
            ground_ws: world_from_model.transform_point3(Vec3::new(x, bounds.min[1], z)).to_array(),
            size: model.size_m * scale,
            count: model.count,
            darks: model.darks as f32,
            tufts: model.tufts as f32,
            reach: model.reach_m * scale,
        }
    }
}

/// Viewport, camera matrices and depth convention of a frame.
pub(crate) struct PaintingView {
    pub(crate) viewport: [u32; 2],
    pub(crate) view_from_world: Mat4,
    pub(crate) clip_from_view: Mat4,
    pub(crate) reversed_depth: bool,
}

/// Height in pixels of the pictures for which pixel sizes are given.
const UNIT_HEIGHT: f32 = 424.0;

impl PaintingFrame {
    pub(crate) fn new(params: &InkParams, view: &PaintingView) -> Self {
        let brush = params.brush;
        let rotation = Mat3::from_mat4(view.view_from_world);
        let axis = |k: usize| rotation.row(k).normalize_or(Vec3::Z).to_array();
        let [bleed, weave] = match brush.sheet {
            BrushSheet::Raw => [1.0, 0.0],
            BrushSheet::Sized => [0.3, 0.0],
            BrushSheet::Silk => [0.5, 1.0],
        };
        let [mist_from, mist_to] = params.mist_m.unwrap_or_default();
        Self {
            ink: encoded(params.ink).to_array(),
            unit_px: view.viewport[1] as f32 / UNIT_HEIGHT,
            paper: encoded(params.paper).to_array(),
            paper_grain: params.paper_grain,
            size: view.viewport.map(|n| n as f32),
            paper_period: params.paper_period_px,
            far_depth: if view.reversed_depth { 0.0 } else { 1.0 },
            depth_rows: depth_rows(view.clip_from_view),
            right_ws: axis(0),
            wash: brush.wash,
            up_ws: axis(1),
            wetness: brush.wetness,
            back_ws: axis(2),
            dryness: brush.dryness,
            strokes: brush.strokes,
            tufts: brush.tufts,
            mist_from,
            mist_to,
            ground: brush.ground,
            progress: brush.progress,
            bleed,
            weave,
            reserved: [0.0; 3],
            pressure: params.pressure,
        }
    }
}
