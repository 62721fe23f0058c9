//! Conversion of Bevy's cameras.

use bevy_math::{Mat4, UVec2, UVec4, Vec3, Vec4, Vec4Swizzles as _};
use bevy_render::camera::TemporalJitter;
use bevy_render::view::ExtractedView;
use pelage_runtime::{Camera, Projection, StyleKind};

/// Camera of a frame, and the area of the target that it draws to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) camera: Camera,
    /// Area of the target, pixels: left, top, width and height.
    pub(crate) rect: UVec4,
}

impl View {
    /// Creates the camera with Bevy's projection, which has reversed depth, and with Bevy's jitter.
    ///
    /// * `override_size`: size of the main pass, if different from the view's
    pub(crate) fn new(view: &ExtractedView, jitter: Option<&TemporalJitter>, override_size: Option<UVec2>) -> Self {
        let mut rect = view.viewport;
        if let Some(size) = override_size {
            rect = UVec4::new(rect.x, rect.y, size.x, size.y);
        }
        let mut clip_from_view = view.clip_from_view;
        if let Some(jitter) = jitter {
            jitter.jitter_projection(&mut clip_from_view, rect.zw().as_vec2());
        }
        let view_from_world = remove_scale(view.world_from_view.to_matrix()).inverse();
        Self { camera: Camera { view_from_world, projection: Projection::Custom(clip_from_view) }, rect }
    }

    /// Returns the camera and the viewport for a frame in this style; the frame has the viewport's size.
    ///
    /// Ink uses textures that begin at the corner of the target, not of the view. An ink frame therefore extends from
    /// the target's corner to the far corner of the view. The camera is widened to the same area.
    pub(crate) fn camera_and_viewport(&self, style: StyleKind) -> (Camera, UVec4) {
        let corner = self.rect.xy() + self.rect.zw();
        if style != StyleKind::Ink || self.rect.xy() == UVec2::ZERO {
            return (self.camera, self.rect);
        }
        let share = self.rect.zw().as_vec2() / corner.as_vec2();
        // Centre of the view in the widened picture, -1..=1 with +y up.
        let middle = (2.0 * self.rect.xy().as_vec2() + self.rect.zw().as_vec2()) / corner.as_vec2() - 1.0;
        let wider = Mat4::from_cols(
            Vec4::new(share.x, 0.0, 0.0, 0.0),
            Vec4::new(0.0, share.y, 0.0, 0.0),
            Vec4::Z,
            Vec4::new(middle.x, -middle.y, 0.0, 1.0),
        );
        let projection = Projection::Custom(wider * self.camera.projection.clip_from_view(true));
        (Camera { projection, ..self.camera }, UVec4::new(0, 0, corner.x, corner.y))
    }

    /// Returns the position of the camera.
    pub(crate) fn eye(&self) -> Vec3 {
        self.camera.view_from_world.inverse().w_axis.truncate()
    }
}

/// Removes the scale from a transform, because Bevy's cameras may be in scaled hierarchies.
fn remove_scale(world_from_view: Mat4) -> Mat4 {
    let axis = |column: Vec4| column.truncate().normalize_or_zero().extend(0.0);
    Mat4::from_cols(
        axis(world_from_view.x_axis),
        axis(world_from_view.y_axis),
        axis(world_from_view.z_axis),
        world_from_view.w_axis,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ink_in_a_viewport_covers_the_same_pixels() {
        let projection = Projection::Perspective { fov_y_rad: 0.7, aspect: 1.5, near_m: 0.1, far_m: f32::INFINITY };
        let projection = Projection::Custom(projection.clip_from_view(true));
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, projection);
        let view = View { camera, rect: UVec4::new(30, 20, 60, 40) };
        let pixel = |(camera, rect): (Camera, UVec4), point: Vec3| {
            let clip = camera.projection.clip_from_view(true) * camera.view_from_world * point.extend(1.0);
            let ndc = clip.truncate() / clip.w;
            let at = Vec3::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y, ndc.z);
            at * rect.zw().as_vec2().extend(1.0) + rect.xy().as_vec2().extend(0.0)
        };
        for point in [Vec3::ZERO, Vec3::X * 0.4, Vec3::new(-0.3, 0.5, 0.2)] {
            let [fur, ink] =
                [StyleKind::Fur, StyleKind::Ink].map(|style| pixel(view.camera_and_viewport(style), point));
            assert!((fur - ink).length() < 1e-3, "{point}: {fur} in fur, {ink} in ink");
        }
        let corner = View { rect: UVec4::new(0, 0, 60, 40), ..view };
        assert_eq!(corner.camera_and_viewport(StyleKind::Ink), (camera, corner.rect));
    }

    #[test]
    fn scaled_camera_keeps_its_pose_without_its_scale() {
        let scaled =
            Mat4::from_scale_rotation_translation(Vec3::splat(3.0), bevy_math::Quat::from_rotation_y(0.5), Vec3::X);
        let plain = Mat4::from_rotation_translation(bevy_math::Quat::from_rotation_y(0.5), Vec3::X);
        assert!(remove_scale(scaled).abs_diff_eq(plain, 1e-6));
    }
}
