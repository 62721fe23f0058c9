// Deep opacity maps (formulas 4.10; after Yuksel and Keyser 2008): optical depth of the hair between the key light and
// a point, counted from each texel's first hair. The buffer has three parts, each with values for every texel: nearness
// of the first hair; hair of each slab; all guided hair.

// Size: 32 bytes.
struct DeepOpacity {
    // Width and height, texels.
    size: u32,
    // Number of depth slabs per texel.
    slabs: u32,
    // Number of slabs that fit into the depth range 0..=1.
    slabs_per_depth: f32,
    // Width of a texel, metres; for a point light, at a distance of 1 m.
    texel_m: f32,
    // Factor on the hair's optical depth.
    density: f32,
    // Map depth, 0..=1, at which the slabs begin if they span the depth of all hair, which only studies use. Unused if
    // they begin at the first hair of each texel.
    whole_from: f32,
    reserved0: f32,
    reserved1: f32,
}

// Unit of stored optical depths (formulas 4.10). Integers make a sum independent of the order of its terms.
const OPACITY_STEP: f32 = 1.0 / 65536.0;

// Returns the share of a slab's hair that is in front of a point. `behind`: distance of the point from the start of the
// slabs, in slabs. The hair is assumed to be spread evenly over a slab.
fn slab_share(behind: f32, slab: u32) -> f32 {
    return clamp(behind - f32(slab), 0.0, 1.0);
}

// Returns the index of the slab that contains hair. `behind`: distance of the hair from the start of the slabs, in
// slabs; `slabs`: number of slabs. Hair behind the last slab counts towards the last.
fn slab_of(behind: f32, slabs: u32) -> u32 {
    return u32(clamp(behind, 0.0, f32(slabs) - 1.0));
}
