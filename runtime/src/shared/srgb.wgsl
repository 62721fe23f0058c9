// Converts an sRGB-encoded colour to linear light (IEC 61966-2-1; formulas 1.2).
fn linear_of(srgb: vec3<f32>) -> vec3<f32> {
    let low = srgb / 12.92;
    let high = pow((max(srgb, vec3(0.0)) + 0.055) / 1.055, vec3(2.4));
    return select(high, low, srgb <= vec3(0.04045));
}
