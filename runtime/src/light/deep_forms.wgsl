// Default placement of the slabs for strand shadows, and offset of the light lookup (formulas 4.10). A study of the
// published forms replaces this file.

// Returns the depth at which the slabs of a texel begin: here `first`, the depth of the texel's first hair. `whole`:
// least depth of all hair.
fn slabs_begin(first: f32, whole: f32) -> f32 {
    return first;
}

// Returns whether the map stores hair that is `behind` slabs deeper than the first hair of its texel.
fn is_kept(behind: f32, slabs: u32) -> bool {
    return true;
}

// Returns the share of the hair in front of a point that casts a shadow on it. `behind`: how much deeper the point is
// than the first hair of the texel, in slabs.
fn shadowing(behind: f32, slabs: u32) -> f32 {
    return 1.0;
}

// Returns the offset of the light lookup towards the eye, in strand radii. On average, half of a strand's light never
// passes through the strand itself.
fn radii_towards_eye() -> f32 {
    return 1.0;
}
