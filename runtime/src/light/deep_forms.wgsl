// Placement of the slabs for strand shadows, and offset of the light lookup (formulas 4.10). A study of the printed
// forms replaces this file by another.

// Returns the depth at which the slabs of a texel begin: its first hair. `whole`: depth at which all hair begins.
fn slabs_begin(first: f32, whole: f32) -> f32 {
    return first;
}

// Whether hair `behind` slabs after the first hair is stored.
fn is_kept(behind: f32, slabs: u32) -> bool {
    return true;
}

// Returns the share of the hair before a point `behind` slabs after the first hair that shadows the point.
fn shadowing(behind: f32, slabs: u32) -> f32 {
    return 1.0;
}

// Returns the offset of the light lookup towards the eye, in strand radii. Half of a strand's light never passes
// through the strand itself.
fn radii_towards_eye() -> f32 {
    return 1.0;
}
