// Layer-wise shadow maps (Yang 2006, sec. 3; formulas 4.2): transmittance of a hair layer for light that passes through
// it.

// Maximum path length of light through a layer, relative to its thickness (formulas 4.2).
const MOST_SLANTED: f32 = 4.0;

// Returns the path length of light through a layer, relative to its thickness: p of formulas 4.2. `n_dot_l`: cosine
// between the light and the surface normal. 1 for perpendicular light, at most MOST_SLANTED, reached at 75 degrees. The
// published form uses 1 at every angle.
fn slanted_path(n_dot_l: f32) -> f32 {
    return 1.0 / max(abs(n_dot_l), 1.0 / MOST_SLANTED);
}

// Minimum transmittance of a layer along its normal, because the logarithm of 0 is infinite (formulas 4.2).
const LEAST_TRANSMITTANCE: f32 = 1e-4;

// Returns (1 - alpha)^path: the transmittance along a path through hair of that opacity (formulas 4.2).
fn layer_transmittance(alpha: f32, path: f32) -> f32 {
    return exp2(path * log2(clamp(1.0 - alpha, LEAST_TRANSMITTANCE, 1.0)));
}
