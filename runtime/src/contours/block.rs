//! Uniform block of the contour lines of an instance.

use crate::bounds::Hull;
use crate::camera::depth_rows;
use crate::model::ModelContours;
use crate::params::InkParams;
use crate::shared::shader_struct::shader_struct;
use glam::{Mat4, Vec2, Vec3, Vec4};

shader_struct! {
    /// Uniform block for an instance, in shader layout.
    pub(crate) struct ContourBlock {
        pub(crate) clip_from_model: [[f32; 4]; 4],
        pub(crate) eye_ms: [f32; 4],
        pub(crate) depth_rows: [f32; 4],
        pub(crate) size: [f32; 2],
        pub(crate) diagonal: f32,
        pub(crate) unit: f32,
        pub(crate) tolerance: f32,
        pub(crate) rest_scale: f32,
        pub(crate) width: f32,
        pub(crate) dryness: f32,
        pub(crate) edges: u32,
        pub(crate) faces: u32,
        pub(crate) creases: u32,
        pub(crate) most_nodes: u32,
        pub(crate) faces_at: u32,
        pub(crate) creases_at: u32,
        pub(crate) previous_at: u32,
        pub(crate) marks_at: u32,
        pub(crate) pressure: f32,
        pub(crate) omission: f32,
        pub(crate) progress: f32,
        pub(crate) top: f32,
        pub(crate) reserved: [f32; 3],
        pub(crate) paper_period: f32,
    }
}

/// Rows of the picture for which lengths in units are given.
const ROWS: f32 = 424.0;
/// Distance along the view within which a surface does not hide a line, as a share of the model's diameter.
const TOLERANCE: f32 = 0.008;

/// Brush of the contour lines.
pub(crate) struct LineBrush {
    /// Factors on the width and on the dryness of lines.
    pub(crate) width: f32,
    pub(crate) dryness: f32,
    /// Variation of the width, 0..=1.
    pub(crate) pressure: f32,
    /// Share of the contour that is left out, where washes already show it.
    pub(crate) omission: f32,
    /// Share of the painting that is done.
    pub(crate) progress: f32,
    /// Period of the paper, pixels.
    pub(crate) paper_period: f32,
}

impl LineBrush {
    pub(crate) fn new(ink: &InkParams) -> Self {
        let brush = &ink.brush;
        Self {
            width: brush.line_width,
            dryness: 2.0 * brush.dryness,
            pressure: ink.pressure,
            omission: brush.omission,
            progress: brush.progress,
            paper_period: ink.paper_period_px,
        }
    }
}

/// Camera of a frame with contour lines.
pub(crate) struct ContourView {
    pub(crate) viewport: [u32; 2],
    pub(crate) view_from_world: Mat4,
    pub(crate) clip_from_view: Mat4,
    pub(crate) eye_ws: Vec4,
    pub(crate) brush: LineBrush,
}

impl ContourBlock {
    /// Arguments: contour mesh; placement, radius in metres and hull in world space of the instance; camera.
    pub(crate) fn new(
        model: &ModelContours,
        world_from_model: Mat4,
        radius_m: f32,
        hull: &Hull,
        view: &ContourView,
    ) -> Self {
        let clip_from_world = view.clip_from_view * view.view_from_world;
        let size = Vec2::from(view.viewport.map(|n| n as f32));
        let [faces_at, creases_at, previous_at, marks_at] = model.layout();
        let center = hull.sphere().map_or(world_from_model.w_axis.truncate(), |sphere| sphere.center);
        let diagonal = screen_diagonal(center, radius_m, view);
        Self {
            clip_from_model: (clip_from_world * world_from_model).to_cols_array_2d(),
            eye_ms: (world_from_model.inverse() * view.eye_ws).to_array(),
            depth_rows: depth_rows(view.clip_from_view),
            size: size.to_array(),
            diagonal,
            unit: size.y / ROWS,
            tolerance: (TOLERANCE * 2.0 * radius_m).max(1e-6),
            rest_scale: model.stored_diagonal.max(f32::MIN_POSITIVE).recip(),
            width: view.brush.width,
            dryness: view.brush.dryness,
            edges: model.edges,
            faces: model.faces,
            creases: model.creases,
            most_nodes: model.most_nodes,
            faces_at,
            creases_at,
            previous_at,
            marks_at,
            pressure: view.brush.pressure,
            omission: view.brush.omission,
            progress: view.brush.progress,
            top: middle_row(center, view) - 0.5 * diagonal,
            reserved: [0.0; 3],
            paper_period: view.brush.paper_period,
        }
    }
}

/// Returns the row of a point, pixels from the top; that of the middle of the picture if it is not in front of the eye.
fn middle_row(point: Vec3, view: &ContourView) -> f32 {
    let clip = view.clip_from_view * view.view_from_world * point.extend(1.0);
    let row = 0.5 - 0.5 * clip.y / clip.w;
    let height = view.viewport[1] as f32;
    if clip.w > 0.0 && row.is_finite() { row.clamp(-4.0, 4.0) * height } else { 0.5 * height }
}

/// Screen diagonal of an animal seen from the side, as a share of the diameter of its bounding sphere.
const DIAGONAL: f32 = 0.95;

/// Returns the diagonal of a body of radius `radius_m` at a point, pixels; that of the picture if the point is not in
/// front of the eye. The pose does not affect it, so that widths do not change while a body moves.
fn screen_diagonal(center: Vec3, radius_m: f32, view: &ContourView) -> f32 {
    let size = Vec2::from(view.viewport.map(|n| n as f32));
    let clip = view.clip_from_view * view.view_from_world * center.extend(1.0);
    let px_per_m = 0.5 * size.y * view.clip_from_view.y_axis.y.abs() / clip.w;
    let diagonal = 2.0 * DIAGONAL * radius_m * px_per_m;
    if diagonal > 0.0 && diagonal.is_finite() { diagonal.min(4.0 * size.length()) } else { size.length() }
}
