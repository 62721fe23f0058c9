// Where the slabs of strands' shadows lie, and where their light is looked up. A study of what the papers print puts another file in the place of
// this one.

// Depth at which the slabs of a texel begin: at its first hair. `whole`: where all hair begins.
fn slabs_begin(first: f32, whole: f32) -> f32 {
    return first;
}

// Whether hair so many slabs behind that is kept.
fn is_kept(behind: f32, slabs: u32) -> bool {
    return true;
}

// Share of the hair before a place so many slabs behind that, which shadows it.
fn shadowing(behind: f32, slabs: u32) -> f32 {
    return 1.0;
}

// How many radii of the strand towards the eye its light is looked up: half of a strand's light never comes through it.
fn radii_towards_eye() -> f32 {
    return 1.0;
}
