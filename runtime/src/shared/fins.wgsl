// Visibility of fins by viewing angle.

// Returns the opacity of a fin (Lengyel 2001; formulas 4.6). p: cosine between its normal and the direction to the eye.
// 1 if seen face on, 0 from 60 degrees on.
fn fin_opacity(p: f32) -> f32 {
    return max(2.0 * abs(p) - 1.0, 0.0);
}
