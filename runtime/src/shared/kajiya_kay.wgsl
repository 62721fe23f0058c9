// Kajiya-Kay shading of a fibre as in Yang 2006, eq. (1), with the attenuations of eqs. (2) and (3) that need no map
// (formulas 4.1). Directions need not have unit length: interpolated and filtered ones are shorter, and are lit more
// evenly from all sides.

// Returns sin^2 of the angle between a and b, 0..=1: 1 - (a.b)^2 (formulas 3.1). For parallel vectors, this rounds
// below zero; the clamp keeps a power of it from being NaN. For vectors shorter than 1, the result is closer to 1, and
// exactly 1 if a vector has length zero.
fn sin_squared(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let c = dot(a, b);
    return max(1.0 - c * c, 0.0);
}

// Returns s^half_exponent, which is sin^p if s is sin^2 (0..=1) and half_exponent is p / 2 (0..=5000) (formulas 3.1).
// 0^0 is 1.
fn sin_power(s: f32, half_exponent: f32) -> f32 {
    return exp2(half_exponent * log2(max(s, 1e-30)));
}

// Returns gamma of eq. (2) (formulas 4.1): share of the ambient light at a height above the mesh surface (0 at the
// surface, 1 at the outermost layer). `floor`: epsilon, the share at the surface.
fn ambient_attenuation(height: f32, floor: f32) -> f32 {
    return (1.0 - floor) * height + floor;
}

// Returns Attenu_Back of eq. (3) (formulas 4.1): 1 where the surface faces the light, falling to 0 at n_dot_l = -range.
// A range of 0 cuts off the light at the terminator; a range of 1e30 disables the attenuation.
fn back_attenuation(n_dot_l: f32, range: f32) -> f32 {
    return clamp(back_slope(n_dot_l, range), 0.0, 1.0);
}

// Returns back_attenuation before clamping, which is linear in n_dot_l and can therefore be interpolated.
fn back_slope(n_dot_l: f32, range: f32) -> f32 {
    return n_dot_l / max(range, 1e-4) + 1.0;
}
