// The forms of the formulas that pelage draws with. A study of what the papers print puts another file in the place of this one.

// A layer blocks more of a look that goes through it at a slant, and of light.
const LOOK_SLANTED: bool = true;
const LIGHT_SLANTED: bool = true;
// The penumbra lies on both sides of the hard edge.
const CENTRED: bool = true;

// What a vertex hands on for the key light: H.
fn half_or_factors(layer: u32, share: f32, slope: f32, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec3<f32> {
    return half;
}

// Towards the eye: that of which H is the middle with the light. n_dot_e: its cosine with the normal.
fn eye_of(light: vec3<f32>, half: vec3<f32>, n_dot_e: f32) -> vec3<f32> {
    return mirrored(light, half);
}

// What a hair sends of the key light.
fn key_fibre(direction: vec3<f32>, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec2<f32> {
    return fibre(direction, light, half, wetness);
}
