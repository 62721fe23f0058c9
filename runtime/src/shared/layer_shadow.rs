/// The shader source.
pub const WGSL: &str = include_str!("layer_shadow.wgsl");

/// Way through a layer over its thickness, where the light meets the skin's normal at a cosine of `n_dot_l`: 1 / |N·L|, 1..=4.
///
/// The form printed in Yang 2006, §3, takes 1 at every angle, which at 75° leaves nearly twice the light (formulas 4.2,
/// chart `self-shadow`).
pub fn slanted_path(n_dot_l: f32) -> f32 {
    1.0 / n_dot_l.abs().max(0.25)
}

/// (1 − `alpha`)^`path`: share of the light that is left after a way through hair of that opacity; at least 1e-4^`path`.
pub fn layer_transmittance(alpha: f32, path: f32) -> f32 {
    (path * (1.0 - alpha).clamp(1e-4, 1.0).log2()).exp2()
}
