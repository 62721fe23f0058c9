// How much of a fin shows.

// Opacity of a fin (Lengyel 2001): p is the cosine between its normal and the direction to the eye. 1 where it is seen face on, 0 from
// 60 degrees on.
fn fin_opacity(p: f32) -> f32 {
    return max(2.0 * abs(p) - 1.0, 0.0);
}
