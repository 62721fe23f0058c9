/// WGSL source of this topic.
pub const WGSL: &str = include_str!("layer_shadow.wgsl");

/// Returns the path length of light through a layer, relative to its thickness: 1 / |N·L|, 1..=4. `n_dot_l`: cosine
/// between the light and the surface normal.
///
/// The published form, Yang 2006, §3, uses 1 at every angle, which at 75° leaves nearly twice the light (formulas 4.2,
/// chart `self-shadow`).
pub fn slanted_path(n_dot_l: f32) -> f32 {
    1.0 / n_dot_l.abs().max(0.25)
}

/// Returns (1 − `alpha`)^`path`: the transmittance along a path through hair of that opacity, at least 1e-4^`path`.
pub fn layer_transmittance(alpha: f32, path: f32) -> f32 {
    (path * (1.0 - alpha).clamp(1e-4, 1.0).log2()).exp2()
}
