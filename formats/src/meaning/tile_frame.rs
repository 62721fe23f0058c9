//! Frame of the hair tile at a surface point: bitangent (along +v) = handedness · normal × tangent.

use glam::{DVec3, Vec3};

/// Frame of the hair tile at a surface point: three perpendicular unit vectors in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileFrame {
    /// Direction of +u of the tile.
    pub tangent_ws: Vec3,
    /// Direction of +v of the tile.
    pub bitangent_ws: Vec3,
    /// Outward surface normal.
    pub normal_ws: Vec3,
}

/// Returns a unit vector perpendicular to the unit vector `n`.
pub fn any_perpendicular(n: Vec3) -> Vec3 {
    let axis = if n.x.abs() > 0.5 { Vec3::Y } else { Vec3::X };
    (axis - n * n.dot(axis)).normalize()
}

/// Returns `tangent` made perpendicular to the unit vector `normal` (Gram–Schmidt), at unit length; any perpendicular
/// if nothing remains.
pub fn orthonormal_tangent(tangent: Vec3, normal: Vec3) -> Vec3 {
    let t = tangent - normal * normal.dot(tangent);
    let length_squared = t.dot(t);
    if length_squared <= 1e-10 * tangent.dot(tangent) || length_squared < 1e-30 {
        return any_perpendicular(normal);
    }
    t * length_squared.sqrt().recip()
}

/// Returns the frame for a unit normal, a tangent and a handedness of ±1.
pub fn tile_frame(normal_ws: Vec3, tangent_ws: Vec3, handedness: f32) -> TileFrame {
    let t = orthonormal_tangent(tangent_ws, normal_ws);
    TileFrame { tangent_ws: t, bitangent_ws: handedness * normal_ws.cross(t), normal_ws }
}

/// Returns tangent and bitangent of [`tile_frame`] in f64, for tracing single hairs.
pub fn tile_axes_f64(normal_ws: DVec3, tangent_ws: DVec3, handedness: f64) -> [DVec3; 2] {
    let along = tangent_ws.reject_from_normalized(normal_ws).try_normalize();
    let tangent = along.unwrap_or_else(|| normal_ws.any_orthonormal_vector());
    [tangent, normal_ws.cross(tangent) * handedness]
}

/// Returns the components of `v_ws` along the frame's axes.
pub fn to_tile(frame: TileFrame, v_ws: Vec3) -> Vec3 {
    Vec3::new(frame.tangent_ws.dot(v_ws), frame.bitangent_ws.dot(v_ws), frame.normal_ws.dot(v_ws))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_orthonormal_and_both_precisions_agree() {
        for (normal, tangent) in [
            (Vec3::Y, Vec3::new(3.0, 0.4, -1.0)),
            (Vec3::new(0.48, 0.6, 0.64), Vec3::new(0.1, -0.2, 0.7)),
            (Vec3::NEG_Z, Vec3::X * 1e-8),
        ] {
            for handedness in [1.0, -1.0] {
                let frame = tile_frame(normal, tangent, handedness);
                let [t, b] = [frame.tangent_ws, frame.bitangent_ws];
                assert!(t.dot(normal).abs() < 1e-6 && b.dot(normal).abs() < 1e-6 && t.dot(b).abs() < 1e-6);
                assert!((normal.cross(t).dot(b) - handedness).abs() < 1e-6 && (t.length() - 1.0).abs() < 1e-6);
                let fine = tile_axes_f64(normal.as_dvec3(), tangent.as_dvec3(), f64::from(handedness));
                assert!(fine[0].as_vec3().distance(t) < 1e-5 && fine[1].as_vec3().distance(b) < 1e-5, "{normal}");
                assert_eq!(to_tile(frame, normal).z, normal.dot(normal));
            }
        }
        // A tangent along the normal is replaced by any perpendicular.
        let frame = tile_frame(Vec3::Y, Vec3::Y, 1.0);
        assert!(frame.tangent_ws.dot(Vec3::Y).abs() < 1e-6 && (frame.tangent_ws.length() - 1.0).abs() < 1e-6);
        let [t, b] = tile_axes_f64(DVec3::Y, DVec3::ZERO, 1.0);
        assert!((t.cross(b) - DVec3::Y).length() < 1e-12 && (t.length() - 1.0).abs() < 1e-12);
    }
}
