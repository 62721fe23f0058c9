// Opacity when the number of layers changes: 1 - (1 - alpha)^exponent keeps the product of (1 - alpha) over all layers, with
// exponent = baked layers / drawn layers.
fn resampled_opacity(alpha: f32, exponent: f32) -> f32 {
    // An opacity of 1 has no logarithm; 2^-11 is far below what an 8-bit texel can say.
    let a = clamp(alpha, 0.0, 1.0 - 1.0 / 2048.0);
    // -expm1(exponent * log1p(-a)) by series where 1 - exp2() would cancel: z <= 0 is the logarithm of the transmittance.
    let z = exponent * select(0.6931472 * log2(1.0 - a), -a * (1.0 + a * (0.5 + a * (1.0 / 3.0 + 0.25 * a))), a < 0.05);
    let series = -z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0)));
    return select(1.0 - exp2(1.442695 * z), series, z > -0.1);
}

// How many times its thickness a look goes through a layer: n_dot_e is the cosine between the skin's normal and the direction to the eye. At most 10.
fn view_path(n_dot_e: f32) -> f32 {
    return 1.0 / clamp(abs(n_dot_e), 0.1, 1.0);
}

// What of a strand's end a look along it meets.
const LEAST_ACROSS: f32 = 0.1;

// How many times the optical depth that a layer stores a look meets in it: `tangent` is grown_tangent of its hair, eye the unit vector to the eye in
// the tile's frame. A thin strand blocks by what of it is across the look. What is stored is its length where strands are finer than texels, and
// what is seen of it from above where they are not: the middle of both. `agreed`: length of the tile's direction, 0..=1; the rest lies in all directions.
fn look_path(tangent: vec3<f32>, agreed: f32, eye: vec3<f32>, n_dot_e: f32) -> f32 {
    let rest = (2.0 / 3.0) * max(1.0 - agreed * agreed, 0.0);
    let along = dot(eye, tangent);
    let flat = dot(tangent.xy, tangent.xy) + rest;
    let across = sqrt(max(flat + tangent.z * tangent.z - along * along, LEAST_ACROSS * LEAST_ACROSS));
    let from_above = sqrt(flat);
    return across * view_path(n_dot_e) / (0.5 + 0.5 * from_above);
}

// A way through layers over their thickness, 1 or more, where hair is `share` as long as the tile's: layers lie closer, so that what the way goes
// sideways counts for less.
fn shortened_path(path: f32, share: f32) -> f32 {
    return sqrt(1.0 + share * share * (path * path - 1.0));
}

// Which baked layer, 1..baked, serves as drawn layer `layer`, 1..drawn; 0, the skin, stays 0.
fn baked_layer(layer: u32, baked: u32, drawn: u32) -> u32 {
    if layer == 0u || baked < 2u || drawn < 2u {
        return 0u;
    }
    let slab = (2u * layer - 1u) * (baked - 1u) / (2u * (drawn - 1u));
    return 1u + min(slab, baked - 2u);
}
