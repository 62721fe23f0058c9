/// The shader source.
pub const WGSL: &str = include_str!("fins.wgsl");

/// Opacity of a fin (Lengyel 2001): `p` is the cosine between its normal and the direction to the eye. 1 where it is seen face
/// on, 0 from 60° on.
pub fn fin_opacity(p: f32) -> f32 {
    (2.0 * p.abs() - 1.0).max(0.0)
}
