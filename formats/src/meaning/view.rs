//! What an eye and a target mean for a picture.

use glam::{Mat4, Vec3};

/// World to view space: rotation and translation, no scale. View space looks along −Z; up in the picture is +Y of the world, or −Z where
/// the view is straight up or down. An eye that is its own target looks along −Z.
pub fn view_from_world(eye: Vec3, target: Vec3) -> Mat4 {
    let backward = backward(eye, target);
    let right = up_of_view(eye, target).cross(backward).normalize();
    let world_from_view =
        Mat4::from_cols(right.extend(0.0), backward.cross(right).extend(0.0), backward.extend(0.0), eye.extend(1.0));
    world_from_view.inverse()
}

/// What is up in the picture, in the world: +Y, or −Z where the view is straight up or down.
pub fn up_of_view(eye: Vec3, target: Vec3) -> Vec3 {
    if backward(eye, target).y.abs() > 0.9999 { Vec3::NEG_Z } else { Vec3::Y }
}

fn backward(eye: Vec3, target: Vec3) -> Vec3 {
    (eye - target).try_normalize().unwrap_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_is_up_and_straight_down_shows_minus_z_at_the_top() {
        let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-5, "{a} is not {b}");
        let level = view_from_world(Vec3::new(0.0, 1.0, 5.0), Vec3::new(0.0, 1.0, 0.0));
        near(level.transform_point3(Vec3::new(1.0, 3.0, 4.0)), Vec3::new(1.0, 2.0, -1.0));
        for (eye, right) in [(Vec3::Y, Vec3::X), (Vec3::NEG_Y, Vec3::NEG_X)] {
            let view = view_from_world(eye, Vec3::ZERO);
            near(view.transform_vector3(Vec3::NEG_Z), Vec3::Y);
            near(view.transform_vector3(right), Vec3::X);
        }
        assert!(view_from_world(Vec3::ONE, Vec3::ONE).is_finite());
    }
}
