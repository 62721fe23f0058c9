use glam::Vec3;

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("kajiya_kay.wgsl");

/// Returns sin² of the angle between `a` and `b`, 0..=1: 1 − (a·b)², clamped to zero.
///
/// The clamp is needed because the difference rounds below zero for parallel vectors, and a power of that is NaN.
/// Interpolation and filtering leave vectors shorter than 1. For those, the result is closer to 1, and exactly 1 if a
/// vector has length zero. Hair of unknown direction is therefore lit equally from all sides.
///
/// The difference has an error of about 1e-7, which is invisible. Where a small sine itself is needed, |a × b|² keeps
/// its precision.
pub fn sin_squared(a: Vec3, b: Vec3) -> f32 {
    let c = a.dot(b);
    (1.0 - c * c).max(0.0)
}

/// Returns `s` to the power `half_exponent`, which is sinᵖ if `s` is sin² (0..=1) and `half_exponent` is p / 2
/// (0..=5000). 0⁰ is 1.
pub fn sin_power(s: f32, half_exponent: f32) -> f32 {
    (half_exponent * s.max(1e-30).log2()).exp2()
}

/// Returns γ of Yang 2006, eq. (2): share of the ambient light that arrives at a height above the mesh surface.
/// `height`: 0 at the surface, 1 at the outermost layer; `floor`: ε, the share at the surface, 0..=1.
pub fn ambient_attenuation(height: f32, floor: f32) -> f32 {
    (1.0 - floor) * height + floor
}

/// Returns Attenu_Back of Yang 2006, eq. (3): 1 where the surface faces the light, falling to 0 at `n_dot_l` =
/// −`range`.
///
/// A range of 0 cuts off the light at the terminator; [`BACK_ATTENUATION_OFF`] gives 1 everywhere.
pub fn back_attenuation(n_dot_l: f32, range: f32) -> f32 {
    back_slope(n_dot_l, range).clamp(0.0, 1.0)
}

/// Returns [`back_attenuation`] before clamping, which is linear in `n_dot_l` and can therefore be interpolated.
pub fn back_slope(n_dot_l: f32, range: f32) -> f32 {
    n_dot_l / range.max(1e-4) + 1.0
}

/// Range that disables [`back_attenuation`].
pub const BACK_ATTENUATION_OFF: f32 = 1e30;
