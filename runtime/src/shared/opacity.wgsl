// Resampling of opacities, and path lengths through layers.

const LN_2: f32 = 0.6931472;
const LOG2_E: f32 = 1.442695;
// Maximum opacity that is resampled: 1 has no finite logarithm, and 2^-11 is far below the resolution of an 8-bit texel
// (formulas 3.1).
const MOST_ALPHA: f32 = 1.0 - 1.0 / 2048.0;
// Opacity alpha below which the logarithm of 1 - alpha is computed by a series.
const SERIES_ALPHA: f32 = 0.05;
// Logarithm of 1 - alpha above which its exponential is computed by a series.
const SERIES_LOGARITHM: f32 = -0.1;

// Returns 1 - (1 - alpha)^exponent, which preserves the product of (1 - alpha) over all layers when their number
// changes (formulas 3.1, 3.2). `exponent`: baked layers divided by drawn layers.
fn resampled_opacity(alpha: f32, exponent: f32) -> f32 {
    let a = clamp(alpha, 0.0, MOST_ALPHA);
    // Computes -expm1(exponent * log1p(-a)), by series where 1 - exp2() would cancel. z <= 0 is the logarithm of the
    // transmittance.
    let log1p = -a * (1.0 + a * (0.5 + a * (1.0 / 3.0 + 0.25 * a)));
    let z = exponent * select(LN_2 * log2(1.0 - a), log1p, a < SERIES_ALPHA);
    let series = -z * (1.0 + z * (0.5 + z * (1.0 / 6.0 + z / 24.0)));
    return select(1.0 - exp2(LOG2_E * z), series, z > SERIES_LOGARITHM);
}

// Minimum cosine between the surface normal and the direction to the eye. For smaller cosines, the path through a layer
// stays the same (formulas 4.5).
const LEAST_N_DOT_E: f32 = 0.1;

// Returns the path length of a view ray through a layer, relative to its thickness, at most 10 (formulas 4.5).
// `n_dot_e`: cosine between the surface normal and the direction to the eye.
fn view_path(n_dot_e: f32) -> f32 {
    return 1.0 / clamp(abs(n_dot_e), LEAST_N_DOT_E, 1.0);
}

// Minimum cross-section of a strand that is seen along its axis (formulas 4.5).
const LEAST_ACROSS: f32 = 0.1;
// Mean squared component of uniformly distributed directions perpendicular to a view ray (formulas 4.5).
const EVEN_ACROSS: f32 = 2.0 / 3.0;

// Returns the optical depth along a view ray, relative to the one that a layer stores: q of formulas 4.5. A thin strand
// blocks light by its extent perpendicular to the ray. Where strands are finer than texels, layers store the length of
// the strand. Elsewhere they store its extent as seen from above. The extent perpendicular to the ray is divided by the
// mean of these two.
//
// `tangent`: grown_tangent of the layer's hair; `agreed`: length of the tile's direction, 0..=1, whose remainder is
// hair in all directions; `eye`: unit vector to the eye in the tile's frame.
fn view_depth_factor(tangent: vec3<f32>, agreed: f32, eye: vec3<f32>, n_dot_e: f32) -> f32 {
    let rest = EVEN_ACROSS * max(1.0 - agreed * agreed, 0.0);
    let along = dot(eye, tangent);
    let flat = dot(tangent.xy, tangent.xy) + rest;
    let across = sqrt(max(flat + tangent.z * tangent.z - along * along, LEAST_ACROSS * LEAST_ACROSS));
    let from_above = sqrt(flat);
    return across * view_path(n_dot_e) / (0.5 + 0.5 * from_above);
}

// Returns the relative path length through layers, 1 or more, for hair whose length is `share` of the tile's: p' of
// formulas 4.2. The layers are closer together, so the sideways component of the path counts less.
fn shortened_path(path: f32, share: f32) -> f32 {
    return sqrt(1.0 + share * share * (path * path - 1.0));
}

// Returns the baked layer, 1..baked, that is used for the drawn layer `layer`, 1..drawn (formulas 3.2). Layer 0, the
// mesh surface, stays 0.
fn baked_layer(layer: u32, baked: u32, drawn: u32) -> u32 {
    if layer == 0u || baked < 2u || drawn < 2u {
        return 0u;
    }
    let slab = (2u * layer - 1u) * (baked - 1u) / (2u * (drawn - 1u));
    return 1u + min(slab, baked - 2u);
}
