use glam::Vec3;

/// The shader source.
pub const WGSL: &str = include_str!("kajiya_kay.wgsl");

/// sin² of the angle between `a` and `b`, 0..=1: 1 − (a·b)², cut at zero.
///
/// For parallel vectors the difference rounds below zero, and a power of that is NaN: the cut comes first. Between vectors shorter
/// than 1, as interpolation and filtering leave them, it is nearer to 1, and exactly 1 where one has no length: hair of which
/// nothing is known is lit alike from all sides.
///
/// The difference has an error of about 1e-7, nothing to see. Where a small sine itself is wanted, |a × b|² keeps its digits.
pub fn sin_squared(a: Vec3, b: Vec3) -> f32 {
    let c = a.dot(b);
    (1.0 - c * c).max(0.0)
}

/// `s` to the power `half_exponent`: sinᵖ from sin² (0..=1) and p / 2 (0..=5 000). 0⁰ is 1.
pub fn sin_power(s: f32, half_exponent: f32) -> f32 {
    (half_exponent * s.max(1e-30).log2()).exp2()
}

/// γ of Yang 2006, eq. (2): share of the ambient light that arrives at `height` above the skin (0 skin, 1 outermost layer);
/// `floor` (ε, 0..=1) is the share at the skin.
pub fn ambient_attenuation(height: f32, floor: f32) -> f32 {
    (1.0 - floor) * height + floor
}

/// Attenu_Back of Yang 2006, eq. (3): 1 where the skin faces the light, falling to 0 at `n_dot_l` = −`range`.
///
/// A range of 0 cuts at the terminator; [`BACK_ATTENUATION_OFF`] gives 1 everywhere.
pub fn back_attenuation(n_dot_l: f32, range: f32) -> f32 {
    back_slope(n_dot_l, range).clamp(0.0, 1.0)
}

/// [`back_attenuation`] before its clamp: linear in `n_dot_l`, so that it may be interpolated.
pub fn back_slope(n_dot_l: f32, range: f32) -> f32 {
    n_dot_l / range.max(1e-4) + 1.0
}

/// The range that switches [`back_attenuation`] off.
pub const BACK_ATTENUATION_OFF: f32 = 1e30;
