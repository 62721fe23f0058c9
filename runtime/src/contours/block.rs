//! Uniform block of the contour lines of an instance.

use crate::bounds::Hull;
use crate::model::ModelContours;
use crate::shared::shader_struct::shader_struct;
use glam::{Mat4, Vec2, Vec4};

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
    }
}

/// Rows of the picture for which lengths in units are given.
const ROWS: f32 = 424.0;
/// Distance along the view within which a surface does not hide a line, as a share of the model's size.
const TOLERANCE: f32 = 0.008;

/// Camera of a frame with contour lines.
pub(crate) struct ContourView {
    pub(crate) viewport: [u32; 2],
    pub(crate) view_from_world: Mat4,
    pub(crate) clip_from_view: Mat4,
    pub(crate) eye_ws: Vec4,
    /// Factors on width and dryness of lines.
    pub(crate) brush: [f32; 2],
}

impl ContourBlock {
    /// Arguments: contour mesh, placement of the instance, its hull in world space, and the camera.
    pub(crate) fn new(model: &ModelContours, world_from_model: Mat4, hull: &Hull, view: &ContourView) -> Self {
        let clip_from_world = view.clip_from_view * view.view_from_world;
        let size = Vec2::from(view.viewport.map(|n| n as f32));
        let [faces_at, creases_at, previous_at, marks_at] = model.layout();
        let extent = hull.sphere().map_or(1.0, |sphere| 2.0 * sphere.radius);
        let projection = view.clip_from_view;
        Self {
            clip_from_model: (clip_from_world * world_from_model).to_cols_array_2d(),
            eye_ms: (world_from_model.inverse() * view.eye_ws).to_array(),
            depth_rows: [projection.z_axis.z, projection.w_axis.z, projection.z_axis.w, projection.w_axis.w],
            size: size.to_array(),
            diagonal: screen_diagonal(hull, clip_from_world, size),
            unit: size.y / ROWS,
            tolerance: (TOLERANCE * extent).max(1e-6),
            rest_scale: model.stored_diagonal.max(f32::MIN_POSITIVE).recip(),
            width: view.brush[0],
            dryness: view.brush[1],
            edges: model.edges,
            faces: model.faces,
            creases: model.creases,
            most_nodes: model.most_nodes,
            faces_at,
            creases_at,
            previous_at,
            marks_at,
        }
    }
}

/// Returns the diagonal of the hull's extent on the screen, pixels, without clipping; that of the picture if the hull
/// reaches the eye.
fn screen_diagonal(hull: &Hull, clip_from_world: Mat4, size: Vec2) -> f32 {
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for (point, _) in &hull.0 {
        let clip = clip_from_world * point.extend(1.0);
        if clip.w.is_nan() || clip.w <= 1e-6 {
            return size.length();
        }
        let place = Vec2::new(clip.x, clip.y) / clip.w * 0.5 * size;
        (least, most) = (least.min(place), most.max(place));
    }
    let diagonal = least.distance(most);
    if diagonal.is_finite() && diagonal > 0.0 { diagonal } else { size.length() }
}
