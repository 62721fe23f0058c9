// Layer-wise shadow maps (Yang 2006, sec. 3): what a layer of hair leaves of the light that crosses it.

// Way through a layer over its thickness, where the light meets the skin's normal at that cosine: 1 straight, at most 4, as at 75
// degrees. The printed form takes 1 at every angle.
fn slanted_path(n_dot_l: f32) -> f32 {
    return 1.0 / max(abs(n_dot_l), 0.25);
}

// (1 - alpha)^path: what is left after a way through hair of that opacity. Not below 1e-4 of a straight way, whose logarithm would
// have no end.
fn layer_transmittance(alpha: f32, path: f32) -> f32 {
    return exp2(path * log2(clamp(1.0 - alpha, 1e-4, 1.0)));
}
