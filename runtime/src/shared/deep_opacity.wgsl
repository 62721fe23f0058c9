// Deep opacity maps: how much hair lies before a point in the key light, counted from the first hair of each texel (after Yuksel and Keyser
// 2008). The buffer holds for each texel how near its first hair is, behind those for each texel the hair of each slab, and behind those for each
// texel all hair on guides.

// 32 bytes.
struct DeepOpacity {
    // Texels of a side.
    size: u32,
    // Slabs of a texel.
    slabs: u32,
    // Slabs in a depth of 1.
    slabs_per_depth: f32,
    // Width of a texel, metres; of a point light at 1 m.
    texel_m: f32,
    // Share of the hair's optical depth that the light meets.
    density: f32,
    // Depth at which slabs begin that do not begin at the first hair.
    whole_from: f32,
    reserved0: f32,
    reserved1: f32,
}

// Optical depths are kept as whole numbers of this: sums do not hang on their order.
const OPACITY_STEP: f32 = 1.0 / 65536.0;

// Share of a slab's hair, by its number, that lies before a place so many slabs behind where they begin: hair is spread evenly over its slab.
fn slab_share(behind: f32, slab: u32) -> f32 {
    return clamp(behind - f32(slab), 0.0, 1.0);
}

// The slab of hair so many slabs behind where they begin: what lies behind the last is counted in it.
fn slab_of(behind: f32, slabs: u32) -> u32 {
    return u32(clamp(behind, 0.0, f32(slabs) - 1.0));
}
