//! uses light/fibre
// Forms of the formulas as pelage draws with them. A study of the printed forms replaces this file by another.

// A layer is more opaque along slanted paths, for view rays and for light.
const LOOK_SLANTED: bool = true;
const LIGHT_SLANTED: bool = true;
// The penumbra lies on both sides of the hard edge.
const CENTRED: bool = true;

// Returns the value that a vertex passes on for the key light: H.
fn half_or_factors(layer: u32, share: f32, slope: f32, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec3<f32> {
    return half;
}

// Returns the direction to the eye, for which H is the half vector with the light. n_dot_e: cosine between it and the
// normal.
fn eye_of(light: vec3<f32>, half: vec3<f32>, n_dot_e: f32) -> vec3<f32> {
    return mirrored(light, half);
}

// Returns the light that a hair sends from the key light.
fn key_fibre(direction: vec3<f32>, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec2<f32> {
    return fibre(direction, light, half, wetness);
}
