/// The shader source.
pub const WGSL: &str = include_str!("fins.wgsl");

/// Opacity of a fin (Lengyel 2001): `p` is the cosine between its normal and the direction to the eye. 1 where it is seen face
/// on, 0 from 60° on.
pub fn fin_opacity(p: f32) -> f32 {
    (2.0 * p.abs() - 1.0).max(0.0)
}

/// Share of the shells' opacity beside fins: `n_dot_e` is the cosine between the skin's normal and the direction to the eye. 0.2
/// where the skin is seen edge on, 1 from a cosine of 0.8 on.
///
/// A look along the skin goes through each layer at another place, so what the layers' blur adds to the covered area adds up: shells
/// alone cover too much there, 1.4 times the optical depth of sharp ones, and with fins on top it would be twice the hair. The two
/// numbers are measured: with them and the density of the fins that `pelage bake` chooses, both together cover what layers of four
/// times the resolution do (`tests/src/silhouette.rs`).
pub fn shell_share(n_dot_e: f32) -> f32 {
    (0.2 + n_dot_e.abs()).min(1.0)
}
