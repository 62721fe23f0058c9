// Baked visibility (formulas 4.9): share t of a distant light that other strands let through to a point of the tile's
// hair. With w the unit vector towards the light, t = above(w.z) clamp(c0 + c . w, 0, 1).

// z of the mean direction towards lights, for which the alpha channel of a texel stores t (formulas 4.9).
const VISIBILITY_MEAN_Z: f32 = 0.585;
// Factor and offset that decode a slope, (byte - 128) / 64, from a texel value 0..=1 (formulas 4.9).
const SLOPE_SCALE: f32 = 255.0 / 64.0;
const SLOPE_OFFSET: f32 = 2.0;
// Minus the base-2 logarithm of e.
const MINUS_LOG2_E: f32 = -1.442695;

// Returns above(z) of formulas 4.9 for a light at height z above the tile's surface. The lower the light, the longer
// its path through the hair.
fn above_horizon(z: f32, horizon: f32) -> f32 {
    return 1.0 - exp2(MINUS_LOG2_E * horizon * max(z, 0.0));
}

// Returns the visibility t of a light (formulas 4.9). `texel`: slopes in red, green and blue, and t for the mean
// direction in alpha; `towards`: unit vector, from light_in_tile.
fn visibility_towards(texel: vec4<f32>, towards: vec3<f32>, horizon: f32) -> f32 {
    let slopes = texel.xyz * SLOPE_SCALE - SLOPE_OFFSET;
    let t = clamp(texel.w + dot(slopes, towards - vec3(0.0, 0.0, VISIBILITY_MEAN_Z)), 0.0, 1.0);
    return t * above_horizon(towards.z, horizon);
}

// Transforms a light direction to the unmodified tile (formulas 4.9), for hair whose length is `share` of the tile's
// and whose lean adds `slope`. Inverts the deformation from the tile's hair to such hair. `towards`: direction in the
// tile frame.
fn light_in_tile(towards: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let upright = vec3(share * towards.x, share * (towards.y - slope * towards.z), towards.z);
    return upright * inverseSqrt(max(dot(upright, upright), 1e-30));
}
