// Deep opacity maps: how much hair lies before a point in the key light, counted from the first hair of each texel (after Yuksel and Keyser
// 2008). The buffer holds for each texel how near its first hair is, and behind those for each texel the hair of each slab.

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
    reserved0: f32,
    reserved1: f32,
    reserved2: f32,
}

// Optical depths are kept as whole numbers of this: sums do not hang on their order.
const OPACITY_STEP: f32 = 1.0 / 65536.0;
