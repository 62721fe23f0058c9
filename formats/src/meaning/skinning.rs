//! Linear blend skinning: the transform of vertices, normals and tangents by joints.

use crate::sampling::Pose;
use crate::sections::mesh::{GeometryVertex, MeshView, SkinVertex};
use crate::sections::morphs::{MorphDelta, Morphs};
use glam::{Mat3, Mat4, Vec3, Vec4};

/// Maximum size of hidden surface, as a share of its largest size in the clips.
pub const HIDDEN_SIZE: f32 = 0.02;

/// Returns a joint's contribution to a vertex's matrix. A joint of weight 0 contributes nothing, even if its matrix is
/// not finite.
pub fn weighted(m: Mat4, weight: f32) -> Mat4 {
    if weight > 0.0 { m * weight } else { Mat4::ZERO }
}

/// Returns the weighted sum of a vertex's four joint matrices; the identity if no weight is positive.
pub fn blend(m0: Mat4, m1: Mat4, m2: Mat4, m3: Mat4, weights: Vec4) -> Mat4 {
    if !weights.cmpgt(Vec4::ZERO).any() {
        return Mat4::IDENTITY;
    }
    // Start with zero, so that no sum is -0.
    Mat4::ZERO + weighted(m0, weights.x) + weighted(m1, weights.y) + weighted(m2, weights.z) + weighted(m3, weights.w)
}

/// Returns the matrix of a vertex in a pose, from mesh space to world space. A joint missing from the pose has the
/// identity.
pub fn skin_matrix(pose: &Pose, skin: &SkinVertex) -> Mat4 {
    let [m0, m1, m2, m3] = skin.joints.map(|j| pose.joints.get(usize::from(j)).copied().unwrap_or(Mat4::IDENTITY));
    blend(m0, m1, m2, m3, Vec4::from_array(skin.weights))
}

/// Returns `v` at unit length, or `fallback` if `v` has no usable length (below 1e-30, above 1e30, or NaN).
pub fn normalize_or(v: Vec3, fallback: Vec3) -> Vec3 {
    // If the squared length is at full precision, no scaling is needed.
    if (1e-36..=1e36).contains(&v.length_squared()) {
        return v.normalize();
    }
    let largest = v.x.abs().max(v.y.abs().max(v.z.abs()));
    if largest > 1e-30 && largest < 1e30 && v.is_finite() { (v / largest).normalize() } else { fallback }
}

/// Transforms a unit normal by a matrix that may scale unevenly, mirror or collapse. The result always has unit length
/// and points outwards.
///
/// The cofactor matrix is the inverse transpose times the determinant. It needs no division, so it is valid even for a
/// zero scale. It has the sign of the determinant, which is removed again. A normal that collapses to zero keeps its
/// old direction.
pub fn transform_normal(m: Mat3, normal: Vec3) -> Vec3 {
    let cofactor = Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    normalize_or(cofactor * normal * handedness_of(m), normal)
}

/// Returns −1 if `m` mirrors, else 1.
pub fn handedness_of(m: Mat3) -> f32 {
    if m.x_axis.dot(m.y_axis.cross(m.z_axis)) < 0.0 { -1.0 } else { 1.0 }
}

/// Transforms a stored vertex by `matrix` ([`skin_matrix`]). The transformed tangent is neither unit length nor
/// perpendicular to the normal: [`super::tile_frame`] corrects it. Height and lean of the hair are unchanged, except
/// that a vertex collapsed by a scale of zero has no hair, nor has one that morph targets collapse: its tangent is
/// shorter than [`HIDDEN_SIZE`].
pub fn posed(vertex: &GeometryVertex, matrix: Mat4) -> GeometryVertex {
    let linear = Mat3::from_mat4(matrix);
    let [x, y, z, handedness] = vertex.tangent;
    let tangent = Vec3::new(x, y, z);
    let hidden = linear == Mat3::ZERO || tangent.length_squared() < HIDDEN_SIZE * HIDDEN_SIZE;
    GeometryVertex {
        position: matrix.transform_point3(Vec3::from(vertex.position)).into(),
        normal: transform_normal(linear, Vec3::from(vertex.normal)).into(),
        tangent: (linear * tangent).extend(handedness * handedness_of(linear)).into(),
        fur_height: if hidden { 0.0 } else { vertex.fur_height },
        ..*vertex
    }
}

/// Applies morph targets to a stored vertex. `shifts` are the differences of the weights from their values at rest
/// ([`Pose::shifts`]). The resulting tangent is neither unit length nor perpendicular to the normal, as in [`posed`]. A
/// vertex that no weight moves is unchanged, bit for bit.
pub fn morphed(vertex: &GeometryVertex, deltas: &[MorphDelta], shifts: &[f32]) -> GeometryVertex {
    let [x, y, z, handedness] = vertex.tangent;
    let stored = [vertex.position.into(), Vec3::from(vertex.normal), Vec3::new(x, y, z)];
    let ([mut position, mut normal, mut tangent], mut moves) = (stored, false);
    for delta in deltas {
        let shift = shifts.get(delta.target as usize).copied().unwrap_or_default();
        if shift != 0.0 {
            moves = true;
            position += Vec3::from(delta.position) * shift;
            normal += Vec3::from(delta.normal) * shift;
            tangent += Vec3::from(delta.tangent) * shift;
        }
    }
    if !moves {
        return *vertex;
    }
    GeometryVertex {
        position: position.into(),
        normal: normalize_or(normal, vertex.normal.into()).into(),
        tangent: tangent.extend(handedness).into(),
        ..*vertex
    }
}

/// Returns the vertices of a mesh in a pose ([`morphed`], then [`posed`]). For a mesh without joints, returns the
/// stored vertices.
pub fn posed_vertices(
    mesh: &MeshView<'_>,
    morphs: Option<&Morphs>,
    pose: &Pose,
) -> impl Iterator<Item = GeometryVertex> {
    let mut skin = mesh.skin();
    mesh.geometry().enumerate().map(move |(i, vertex)| match skin.next() {
        Some(joints) => {
            let vertex = morphed(&vertex, morphs.map_or(&[][..], |m| m.of_vertex(i)), &pose.shifts);
            posed(&vertex, skin_matrix(pose, &joints))
        }
        None => vertex,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn joint_weights_blend_and_zero_weights_are_ignored() {
        let (moved, broken) = (Mat4::from_translation(Vec3::X), Mat4::from_cols_array(&[f32::NAN; 16]));
        assert_eq!(blend(moved, broken, broken, broken, Vec4::X), moved);
        assert_eq!(blend(moved, moved, moved, moved, Vec4::ZERO), Mat4::IDENTITY);
        let half = blend(moved, Mat4::IDENTITY, broken, broken, Vec4::new(0.5, 0.5, 0.0, 0.0));
        assert_eq!(half.transform_point3(Vec3::ZERO), 0.5 * Vec3::X);
        let pose = Pose { joints: vec![moved], ..Pose::default() };
        let of = |joint, weights| skin_matrix(&pose, &SkinVertex { joints: [joint, 9, 9, 9], weights });
        assert_eq!(of(0, [1.0, 0.0, 0.0, 0.0]), moved);
        assert_eq!(of(7, [1.0, 0.0, 0.0, 0.0]), Mat4::IDENTITY, "a joint that is not there");
    }

    #[test]
    fn normals_stay_outward_and_unit_at_every_scale() {
        let normal = Vec3::new(0.36, 0.48, 0.8);
        for scale in [1e-14f32, 1e-9, 1e-3, 1.0, 1e3, 1e14] {
            for mirror in [1.0, -1.0] {
                let m = Mat3::from_diagonal(Vec3::new(scale * mirror, scale, scale));
                let (found, expected) = (transform_normal(m, normal), normal * Vec3::new(mirror, 1.0, 1.0));
                assert!(found.distance(expected) < 1e-6, "{scale} {mirror}: {found} is not {expected}");
            }
        }
        assert_eq!(transform_normal(Mat3::ZERO, normal), normal);
        assert_eq!(normalize_or(Vec3::NAN, Vec3::Y), Vec3::Y);
        // If a slope is stretched along x, its normal turns away from x.
        let stretched = transform_normal(Mat3::from_diagonal(Vec3::new(2.0, 1.0, 1.0)), Vec3::new(0.6, 0.8, 0.0));
        assert!(stretched.distance(Vec3::new(0.3, 0.8, 0.0).normalize()) < 1e-6, "{stretched}");
    }

    #[test]
    fn posed_vertex_transforms_all_its_attributes() {
        let vertex = GeometryVertex {
            position: [1.0, 2.0, 3.0],
            normal: [0.0, 1.0, 0.0],
            tangent: [1.0, 0.0, 0.0, 1.0],
            fur_height: 0.25,
            lean: 0.5,
        };
        let turn = Mat4::from_rotation_translation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2), Vec3::Z);
        let moved = posed(&vertex, turn);
        let near = |a: [f32; 3], b: [f32; 3]| assert!(Vec3::from(a).distance(b.into()) < 1e-6, "{a:?} is not {b:?}");
        near(moved.position, [-2.0, 1.0, 4.0]);
        near(moved.normal, [-1.0, 0.0, 0.0]);
        let [x, y, z, handedness] = moved.tangent;
        near([x, y, z], [0.0, 1.0, 0.0]);
        assert_eq!((handedness, moved.fur_height, moved.lean), (1.0, 0.25, 0.5));
        assert_eq!(posed(&vertex, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0))).tangent[3], -1.0, "a mirrored tile");
        assert_eq!(posed(&vertex, Mat4::IDENTITY), vertex);
        assert_eq!(posed(&vertex, Mat4::from_scale(Vec3::ZERO)).fur_height, 0.0, "hidden by its scale");
        let hidden = GeometryVertex { tangent: [0.01, 0.0, 0.0, 1.0], ..vertex };
        assert_eq!(posed(&hidden, Mat4::IDENTITY).fur_height, 0.0, "hidden by morph targets");
    }
}
