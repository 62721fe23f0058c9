use glam::{Mat3, Mat4, Vec3, Vec4};

/// The shader source.
pub const WGSL: &str = include_str!("skinning.wgsl");

/// One joint's share of a vertex's matrix. A joint of weight 0 counts for nothing, even where its matrix is not finite.
pub fn weighted(m: Mat4, weight: f32) -> Mat4 {
    if weight > 0.0 { m * weight } else { Mat4::ZERO }
}

/// The weighted sum of a vertex's four joint matrices; the identity where no weight is positive.
pub fn blend(m0: Mat4, m1: Mat4, m2: Mat4, m3: Mat4, weights: Vec4) -> Mat4 {
    if !weights.cmpgt(Vec4::ZERO).any() {
        return Mat4::IDENTITY;
    }
    weighted(m0, weights.x) + weighted(m1, weights.y) + weighted(m2, weights.z) + weighted(m3, weights.w)
}

/// `v` at unit length, or `fallback` where `v` has no usable length (below 1e-30, above 1e30, or NaN).
pub fn normalize_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let largest = v.x.abs().max(v.y.abs().max(v.z.abs()));
    if largest > 1e-30 && largest < 1e30 && v.is_finite() { (v / largest).normalize() } else { fallback }
}

/// A unit normal under a matrix that may scale unevenly, mirror or collapse: unit length always, and outward stays outward.
///
/// The cofactor matrix is the inverse transpose times the determinant: it needs no division, so it survives a zero scale; its
/// sign is the determinant's, which is taken out again. A normal that collapses altogether keeps its old direction.
pub fn transform_normal(m: Mat3, normal: Vec3) -> Vec3 {
    let cofactor = Mat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    normalize_or(cofactor * normal * handedness_of(m), normal)
}

/// −1 where `m` mirrors, else 1.
pub fn handedness_of(m: Mat3) -> f32 {
    if m.x_axis.dot(m.y_axis.cross(m.z_axis)) < 0.0 { -1.0 } else { 1.0 }
}
