// Layer-wise shadow maps (Yang 2006, sec. 3): transmittance of a hair layer for light that crosses it.

// Returns the path length of light through a layer, relative to its thickness. n_dot_l: cosine between the light and
// the surface normal. 1 if perpendicular, at most 4, as at 75 degrees. The printed form uses 1 at every angle.
fn slanted_path(n_dot_l: f32) -> f32 {
    return 1.0 / max(abs(n_dot_l), 0.25);
}

// Returns (1 - alpha)^path: transmittance along a path through hair of that opacity. Clamps 1 - alpha to 1e-4, because
// the logarithm of 0 is infinite.
fn layer_transmittance(alpha: f32, path: f32) -> f32 {
    return exp2(path * log2(clamp(1.0 - alpha, 1e-4, 1.0)));
}
