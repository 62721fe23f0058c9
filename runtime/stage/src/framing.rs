//! The camera and light a picture gets when the command line names none.

use crate::Viewpoint;
use glam::Vec3;
use pelage_formats::meaning::view_from_world;

/// Vertical field of view of the default camera, degrees: a portrait lens.
pub const FOV_DEG: f32 = 30.0;
/// From the model to the default camera: its front left, a little above. glTF models face +z, so their left is +x.
pub const TOWARDS_CAMERA: Vec3 = Vec3::new(0.62, 0.28, 0.73);
/// From the model to a second camera, which sees what the default one does not: its back right, higher.
pub const BEHIND: Vec3 = Vec3::new(-0.62, 0.5, -0.6);
/// From the model to the default light: high, on the camera's right, so that the fur's relief shows.
pub const TOWARDS_LIGHT: Vec3 = Vec3::new(-0.25, 0.75, 0.6);
/// Share of the picture that the model fills at most.
const FILL: f32 = 0.9;

/// The view that shows all `points`, with `margin_m` of fur about them, in a picture of the given width over height, from the direction
/// `towards` of any length.
///
/// The model stands as large in the picture as it can; where there is no point, the origin is looked at from a metre away.
pub fn frame(points: &[Vec3], margin_m: f32, aspect: f32, towards: Vec3) -> Viewpoint {
    let (eye, target) = eye_and_target(points, margin_m, aspect, towards);
    Viewpoint { eye, target, fov_deg: FOV_DEG }
}

fn eye_and_target(points: &[Vec3], margin_m: f32, aspect: f32, towards: Vec3) -> (Vec3, Vec3) {
    let towards = towards.normalize();
    let view = view_from_world(Vec3::ZERO, -towards);
    let tan_y = (FOV_DEG.to_radians() / 2.0).tan() * FILL;
    let tan_x = tan_y * aspect;
    // A point is inside the right edge of a camera at (x0, y0, z0) where x − x0 <= tan_x (z0 − z). So each edge of the picture
    // asks for tan_x z0 ± x0 to be at least some value, which only the outermost point along that edge's plane decides.
    let mut need = [f32::NEG_INFINITY; 4];
    let in_view: Vec<Vec3> = points.iter().map(|p| view.transform_point3(*p)).collect();
    for p in &in_view {
        // A ball of fur about the point touches a slanted plane 1/cos of its angle early.
        let (mx, my) = (margin_m * (1.0 + tan_x * tan_x).sqrt(), margin_m * (1.0 + tan_y * tan_y).sqrt());
        let edges = [p.z * tan_x + p.x + mx, p.z * tan_x - p.x + mx, p.z * tan_y + p.y + my, p.z * tan_y - p.y + my];
        need = std::array::from_fn(|i| need[i].max(edges[i]));
    }
    let Some(nearest) = in_view.iter().map(|p| p.z).reduce(f32::max) else { return (towards, Vec3::ZERO) };
    let [right, left, top, bottom] = need;
    let mut z0 = ((right + left) / (2.0 * tan_x)).max((top + bottom) / (2.0 * tan_y));
    if z0 - nearest <= 1e-6 * (1.0 + z0.abs()) {
        // All points are one, and no fur about it: any distance is as good.
        z0 = nearest + 1.0;
    }
    let eye = Vec3::new((right - left) / 2.0, (top - bottom) / 2.0, z0);
    let middle = in_view.iter().map(|p| p.z).sum::<f32>() / in_view.len() as f32;
    // The mean of many equal numbers may round above them.
    let target = Vec3::new(eye.x, eye.y, middle.min(nearest));
    let world = view.inverse();
    (world.transform_point3(eye), world.transform_point3(target))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_is_in_the_picture_and_fills_it() {
        let points: Vec<Vec3> = (0..500)
            .map(|i| {
                let t = i as f32;
                Vec3::new(2.0 * (t * 0.7).sin(), 1.0 + (t * 1.3).cos(), 5.0 * (t * 0.31).sin())
            })
            .collect();
        for (aspect, towards) in [(0.5, TOWARDS_CAMERA), (1.0, BEHIND), (2.0, TOWARDS_CAMERA), (1.0, Vec3::X)] {
            for margin in [0.0, 0.2] {
                let Viewpoint { eye, target, fov_deg } = frame(&points, margin, aspect, towards);
                let view = view_from_world(eye, target);
                let tan_y = (fov_deg.to_radians() / 2.0).tan();
                let on_picture = |p: Vec3| {
                    let p = view.transform_point3(p);
                    (p.x / (tan_y * aspect)).abs().max((p.y / tan_y).abs()) / -p.z
                };
                // The surface of the fur's ball about each point, sampled.
                let directions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
                let ball = points.iter().flat_map(|p| directions.map(|d| *p + d * margin));
                let widest = ball.map(on_picture).fold(0.0, f32::max);
                assert!(widest <= FILL + 1e-3, "aspect {aspect}, margin {margin}: a point lies at {widest}");
                assert!(widest > FILL - 0.05, "aspect {aspect}, margin {margin}: the widest lies at {widest} only");
            }
        }
    }

    #[test]
    fn nothing_and_a_point_are_framed_too() {
        for points in [&[][..], &[Vec3::ONE]] {
            let Viewpoint { eye, target, .. } = frame(points, 0.0, 1.0, TOWARDS_CAMERA);
            assert!(eye.is_finite() && target.is_finite() && eye != target);
        }
    }
}
