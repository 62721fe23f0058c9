use bytemuck::{Pod, Zeroable};

/// WGSL source; depends on no other topic.
pub const WGSL: &str = include_str!("deep_opacity.wgsl");

/// Parameters of a deep opacity map. 32 bytes, laid out as the WGSL structure of the same name.
///
/// The map is a buffer of 32-bit numbers in three parts, each in row-major order of texels:
///
/// * nearness of the first hair, as the bits of an `f32` that holds 1 − its depth; 0 if there is none
/// * optical depth of each of the texel's slabs, in multiples of [`OPACITY_STEP`]
/// * optical depth of all hair on guides, in the same unit
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DeepOpacity {
    /// Width and height of the map, texels.
    pub size: u32,
    /// Slabs per texel.
    pub slabs: u32,
    /// Number of slabs in the depth from 0 to 1.
    pub slabs_per_depth: f32,
    /// Width of a texel, metres; at 1 m from a point light.
    pub texel_m: f32,
    /// Factor on the hair's optical depth.
    pub density: f32,
    /// Depth at which slabs begin if they do not begin at the first hair; used by a study.
    pub whole_from: f32,
    /// Padding, 0.
    pub reserved: [f32; 2],
}

/// Unit of stored optical depths. Integers make sums independent of their order.
pub const OPACITY_STEP: f32 = 1.0 / 65536.0;

/// Returns the share of a slab's hair that is in front of a point, 0..=1. `slab`: number of the slab; `behind`:
/// distance of the point from the start of the slabs, in slabs. Hair is spread evenly over a slab.
pub fn slab_share(behind: f32, slab: u32) -> f32 {
    (behind - slab as f32).clamp(0.0, 1.0)
}

/// Returns the slab of hair at a distance `behind` the start of the slabs, in slabs. Hair behind the last of `slabs`,
/// at least 1, counts towards it.
pub fn slab_of(behind: f32, slabs: u32) -> u32 {
    behind.clamp(0.0, slabs as f32 - 1.0) as u32
}
