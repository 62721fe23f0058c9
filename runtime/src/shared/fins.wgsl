// How much of a fin shows, and of the shells beside it.

// Opacity of a fin (Lengyel 2001): p is the cosine between its normal and the direction to the eye. 1 where it is seen face on, 0 from
// 60 degrees on.
fn fin_opacity(p: f32) -> f32 {
    return max(2.0 * abs(p) - 1.0, 0.0);
}

// Share of the shells' opacity beside fins: n_dot_e is the cosine between the skin's normal and the direction to the eye. 0.2 where
// the skin is seen edge on, 1 from a cosine of 0.8 on.
fn shell_share(n_dot_e: f32) -> f32 {
    return min(0.2 + abs(n_dot_e), 1.0);
}
