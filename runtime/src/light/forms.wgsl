//! uses light/fibre
// Default forms of the formulas. A study of the published forms replaces this file.

// Slanted paths through a layer are more opaque, for view rays and for light.
const LOOK_SLANTED: bool = true;
const LIGHT_SLANTED: bool = true;
// The penumbra extends to both sides of the hard edge.
const CENTRED: bool = true;

// Returns the value that vertices pass on for the key light: here the half vector H.
fn half_or_factors(layer: u32, share: f32, slope: f32, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec3<f32> {
    return half;
}

// Returns the direction to the eye, from the light's direction and their half vector. `n_dot_e`: cosine between the eye
// direction and the normal.
fn eye_of(light: vec3<f32>, half: vec3<f32>, n_dot_e: f32) -> vec3<f32> {
    return mirrored(light, half);
}

// Returns the light that a hair sends to the eye from the key light.
fn key_fibre(direction: vec3<f32>, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec2<f32> {
    return fibre(direction, light, half, wetness);
}
