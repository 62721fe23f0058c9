//! Explanation of a picture that shows nothing.

use glam::{DMat4, DVec3};
use pelage_bake::strands::PosedMesh;
use pelage_stage::Viewpoint;

/// Returns the most likely reason why a picture shows nothing.
///
/// * `models`: posed meshes, each with its transform to world space
/// * `size`: width and height of the picture, pixels
pub fn why_empty(models: &[(&PosedMesh, DMat4)], camera: &Viewpoint, (width, height): (u32, u32)) -> &'static str {
    let (eye, target) = (camera.eye.as_dvec3(), camera.target.as_dvec3());
    let forward = (target - eye).normalize_or_zero();
    let right = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
    let up = right.cross(forward);
    let px_per_slope = f64::from(height) / 2.0 / (f64::from(camera.fov_deg).to_radians() / 2.0).tan();
    // Offset from the centre of the picture in pixels; `None` for a point that the picture does not show.
    let pixel = |p: &DVec3| {
        let way = *p - eye;
        let at = [right, up].map(|axis| way.dot(axis) / way.dot(forward) * px_per_slope);
        let inside = at[0].abs() <= f64::from(width) / 2.0 && at[1].abs() <= f64::from(height) / 2.0;
        (inside && way.dot(forward) > 0.0).then_some(at)
    };
    let (mut triangles, mut in_view, mut facing) = (0_u64, 0_u64, 0_u64);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (mesh, world) in models {
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle).map(|corner| world.transform_point3(corner.position_ws));
            triangles += 1;
            let seen: Vec<[f64; 2]> = [a, b, c, (a + b + c) / 3.0].iter().filter_map(pixel).collect();
            if seen.is_empty() {
                continue;
            }
            in_view += 1;
            let from_front = (b - a).cross(c - a).dot(eye - a) > 0.0;
            facing += u64::from(from_front || mesh.material(triangle).double_sided);
            for (i, x) in seen.iter().flat_map(|at| at.iter().enumerate()) {
                (low[i], high[i]) = (low[i].min(*x), high[i].max(*x));
            }
        }
    }
    match (triangles, in_view, facing) {
        (0, ..) => "the model has no surface",
        (_, 0, _) => "no surface is in front of the camera; without --camera the whole model is framed",
        (.., 0) => {
            "the camera sees only back faces of one-sided materials; move it with --orbit, or make the materials \
             double-sided in the model"
        }
        _ if high[0] - low[0] < 1.0 && high[1] - low[1] < 1.0 => "the model is smaller than a pixel",
        _ => "the surfaces in front of the camera are transparent or too thin",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pelage_bake::strands::{PosedMaterial, PosedVertex};

    #[test]
    fn reason_follows_from_camera_and_winding() {
        let corner = |x: f64, z: f64| PosedVertex { position_ws: DVec3::new(x, 0.0, z), ..PosedVertex::default() };
        let mesh = PosedMesh {
            vertices: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(0.0, 1.0)],
            triangles: vec![[0, 1, 2]],
            material_of: vec![0],
            materials: vec![PosedMaterial::default()],
            ..PosedMesh::default()
        };
        let models = [(&mesh, DMat4::IDENTITY)];
        let view = |eye, target| Viewpoint { eye, target, fov_deg: 40.0 };
        let from = |eye: Vec3, target: Vec3| why_empty(&models, &view(eye, target), (64, 64));
        let above = Vec3::new(0.0, 5.0, 1.0);
        assert!(from(above, Vec3::ZERO).contains("back faces"), "{}", from(above, Vec3::ZERO));
        assert!(from(above, 2.0 * above).contains("in front of the camera"));
        let far = Vec3::new(0.0, -1e4, 1.0);
        assert!(from(far, Vec3::ZERO).contains("smaller than a pixel"), "{}", from(far, Vec3::ZERO));
        assert!(why_empty(&[], &view(above, Vec3::ZERO), (64, 64)).contains("no surface"));
    }
}
