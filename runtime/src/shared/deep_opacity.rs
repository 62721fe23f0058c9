use bytemuck::{Pod, Zeroable};

/// The shader source; needs nothing else.
pub const WGSL: &str = include_str!("deep_opacity.wgsl");

/// What the map's numbers mean. 32 bytes, as the WGSL structure of the same name.
///
/// The map is a buffer of 32-bit numbers: of each texel, row-major, how near its first hair is, as the bits of an `f32` that holds 1 − its depth; 0
/// where there is none. Behind those, of each texel, the optical depth of each of its slabs, in multiples of [`OPACITY_STEP`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DeepOpacity {
    /// Width and height of the map, texels.
    pub size: u32,
    /// Slabs of a texel.
    pub slabs: u32,
    /// Slabs in the depth from 0 to 1.
    pub slabs_per_depth: f32,
    /// Width of a texel, metres; of a point light at 1 m.
    pub texel_m: f32,
    /// Share of the hair's optical depth that the light meets.
    pub density: f32,
    /// Depth at which slabs begin that do not begin at the first hair: those of a study.
    pub whole_from: f32,
    /// 0.
    pub reserved: [f32; 2],
}

/// Optical depths are kept as whole numbers of this: sums do not hang on their order.
pub const OPACITY_STEP: f32 = 1.0 / 65536.0;

/// Share of a slab's hair, by its number, that lies before a place so many slabs `behind` where they begin, 0..=1: hair is spread evenly over its
/// slab.
pub fn slab_share(behind: f32, slab: u32) -> f32 {
    (behind - slab as f32).clamp(0.0, 1.0)
}

/// The slab of hair so many slabs `behind` where they begin: what lies behind the last of `slabs`, at least 1, is counted in it.
pub fn slab_of(behind: f32, slabs: u32) -> u32 {
    behind.clamp(0.0, slabs as f32 - 1.0) as u32
}
