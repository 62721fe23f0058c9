// Visibility of fins by viewing angle.

// Returns the opacity of a fin (Lengyel 2001; formulas 4.6): 1 if it faces the eye, 0 at 60 degrees and beyond. `p`:
// cosine between its normal and the direction to the eye.
fn fin_opacity(p: f32) -> f32 {
    return max(2.0 * abs(p) - 1.0, 0.0);
}
