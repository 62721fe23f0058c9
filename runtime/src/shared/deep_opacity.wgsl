// Deep opacity maps (formulas 4.10): amount of hair in front of a point in the key light, counted from each texel's
// first hair (after Yuksel and Keyser 2008). The buffer holds three parts, each per texel: nearness of the first hair;
// hair of each slab; all hair on guides.

// 32 bytes.
struct DeepOpacity {
    // Width and height, texels.
    size: u32,
    // Slabs per texel.
    slabs: u32,
    // Number of slabs in the depth from 0 to 1.
    slabs_per_depth: f32,
    // Width of a texel, metres; at 1 m from a point light.
    texel_m: f32,
    // Factor on the hair's optical depth.
    density: f32,
    // Depth at which slabs begin if they do not begin at the first hair.
    whole_from: f32,
    reserved0: f32,
    reserved1: f32,
}

// Unit of stored optical depths (formulas 4.10). Integers make sums independent of their order.
const OPACITY_STEP: f32 = 1.0 / 65536.0;

// Returns the share of a slab's hair that is in front of a point. behind: distance of the point from the start of the
// slabs, in slabs. Hair is spread evenly over a slab.
fn slab_share(behind: f32, slab: u32) -> f32 {
    return clamp(behind - f32(slab), 0.0, 1.0);
}

// Returns the slab of hair at a distance behind the start of the slabs, in slabs. Hair behind the last slab counts
// towards it.
fn slab_of(behind: f32, slabs: u32) -> u32 {
    return u32(clamp(behind, 0.0, f32(slabs) - 1.0));
}
