//! Orientation of a camera given by position and target. World space has +Y up; a camera looks along −Z of view space.

use glam::{Mat4, Vec3};

/// Cosine of the angle to the vertical axis, 0.8°, below which a view has no up direction of its own.
const STRAIGHT: f32 = 0.9999;

/// Returns the up direction of the view in world space: +Y, or −Z if the view is straight up or down.
pub fn up_of_view(eye: Vec3, target: Vec3) -> Vec3 {
    if backward(eye, target).y.abs() > STRAIGHT { Vec3::NEG_Z } else { Vec3::Y }
}

/// Returns the right, up and backward directions of a camera at `eye` that looks at `target`: perpendicular unit
/// vectors in world space.
pub fn view_axes(eye: Vec3, target: Vec3) -> [Vec3; 3] {
    let backward = backward(eye, target);
    let right = up_of_view(eye, target).cross(backward).normalize();
    [right, backward.cross(right), backward]
}

/// Returns the transform from world to view space for a camera at `eye` that looks at `target`: rotation and
/// translation, no scale. If `eye` equals `target`, the camera looks along −Z.
pub fn view_from_world(eye: Vec3, target: Vec3) -> Mat4 {
    let [right, up, backward] = view_axes(eye, target);
    Mat4::from_cols(right.extend(0.0), up.extend(0.0), backward.extend(0.0), eye.extend(1.0)).inverse()
}

fn backward(eye: Vec3, target: Vec3) -> Vec3 {
    (eye - target).try_normalize().unwrap_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_upright_and_vertical_views_use_minus_z_as_up() {
        for (eye, up) in [
            (Vec3::new(3.0, 1.0, 2.0), Vec3::Y),
            (Vec3::new(0.04, 1.0, 0.0), Vec3::Y),
            (Vec3::new(0.01, 1.0, 0.0), Vec3::NEG_Z),
            (Vec3::NEG_Y, Vec3::NEG_Z),
        ] {
            let view = view_from_world(eye, Vec3::ZERO);
            let seen = view.transform_vector3(up);
            assert!(seen.x.abs() < 1e-5 && seen.y > 0.0, "{eye}: {up} is seen at {seen}");
            assert!(view.transform_point3(eye).length() < 1e-5);
            let ahead = view.transform_point3(Vec3::ZERO);
            assert!((ahead + Vec3::Z * eye.length()).length() < 1e-5, "{eye}: the target is seen at {ahead}");
        }
        assert_eq!(view_from_world(Vec3::ONE, Vec3::ONE).transform_vector3(Vec3::Z), Vec3::Z);
    }
}
