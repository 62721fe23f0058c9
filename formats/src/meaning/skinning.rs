//! What joints and weights do to a vertex.

use crate::{Pose, SkinVertex};
use glam::{Mat3, Mat4, Vec3};

/// The weighted sum of a vertex's joint matrices (linear blend skinning): model space at rest to model space in the pose. A joint that
/// the pose does not have stands still.
pub fn skin_matrix(pose: &Pose, skin: &SkinVertex) -> Mat4 {
    let mut sum = Mat4::ZERO;
    for (joint, weight) in skin.joints.iter().zip(skin.weights) {
        if weight > 0.0 {
            sum += pose.joints.get(usize::from(*joint)).copied().unwrap_or(Mat4::IDENTITY) * weight;
        }
    }
    sum
}

/// A normal under a matrix that may scale unevenly, mirror or collapse: unit length always, and outward stays outward.
///
/// The cofactor matrix is the inverse transpose times the determinant: it needs no division, so it survives a zero scale; its
/// sign is the determinant's, which is taken out again. A normal that collapses altogether keeps its old direction.
pub fn transform_normal(matrix: Mat4, normal: Vec3) -> Vec3 {
    let m = Mat3::from_mat4(matrix);
    let cofactor = Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    let sign = if m.x_axis.dot(cofactor.x_axis) < 0.0 { -1.0 } else { 1.0 };
    (cofactor * normal * sign).try_normalize().unwrap_or(normal)
}
