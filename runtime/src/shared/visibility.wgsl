// Baked visibility: share of a distant light that reaches a point of the tile's hair past other strands, t = s(w.z)
// clamp(c0 + c . w, 0, 1).

// z of the mean direction towards lights, for which alpha of a texel is t.
const VISIBILITY_MEAN_Z: f32 = 0.585;

// Returns s for a light at height z above the tile's surface: the lower the light, the longer its path through the
// hair.
fn above_horizon(z: f32, horizon: f32) -> f32 {
    return 1.0 - exp2(-1.442695 * horizon * max(z, 0.0));
}

// Returns the visibility of a light. texel: slopes in red, green and blue, (byte - 128) / 64, and in alpha t for the
// mean direction; towards: unit vector, from light_in_tile.
fn visibility_towards(texel: vec4<f32>, towards: vec3<f32>, horizon: f32) -> f32 {
    let slopes = texel.xyz * (255.0 / 64.0) - 2.0;
    let t = clamp(texel.w + dot(slopes, towards - vec3(0.0, 0.0, VISIBILITY_MEAN_Z)), 0.0, 1.0);
    return t * above_horizon(towards.z, horizon);
}

// Transforms a light direction to the unmodified tile, for hair that is `share` as long as the tile's and leans by that
// slope. Inverts the deformation that makes such hair of the tile's. towards: direction in the tile frame.
fn light_in_tile(towards: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let upright = vec3(share * towards.x, share * (towards.y - slope * towards.z), towards.z);
    return upright * inverseSqrt(max(dot(upright, upright), 1e-30));
}
