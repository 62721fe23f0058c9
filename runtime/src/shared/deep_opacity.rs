use bytemuck::{Pod, Zeroable};

/// WGSL source; does not depend on other topics.
pub const WGSL: &str = include_str!("deep_opacity.wgsl");

/// Parameters of a deep opacity map. 32 bytes, in the layout of the WGSL structure of the same name.
///
/// The map is a buffer of 32-bit numbers in three parts, each in row-major order of texels:
///
/// * nearness of the first hair, as the bits of an `f32` that holds 1 − its depth; 0 if there is none
/// * optical depth of each slab of the texel, in multiples of [`OPACITY_STEP`]
/// * optical depth of all guided hair, in the same unit
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DeepOpacity {
    /// Width and height of the map, texels.
    pub size: u32,
    /// Number of depth slabs per texel.
    pub slabs: u32,
    /// Number of slabs that fit into the depth range 0..=1.
    pub slabs_per_depth: f32,
    /// Width of a texel, metres; for a point light, at a distance of 1 m.
    pub texel_m: f32,
    /// Factor on the hair's optical depth.
    pub density: f32,
    /// Map depth, 0..=1, at which the slabs begin if they span the depth of all hair, which only studies use. Unused if
    /// they begin at the first hair of each texel.
    pub whole_from: f32,
    /// Padding, zero.
    pub reserved: [f32; 2],
}

/// Unit of stored optical depths. Integers make a sum independent of the order of its terms.
pub const OPACITY_STEP: f32 = 1.0 / 65536.0;

/// Returns the share of a slab's hair that is in front of a point, 0..=1. `slab`: index of the slab; `behind`: distance
/// of the point from the start of the slabs, in slabs. The hair is assumed to be spread evenly over a slab.
pub fn slab_share(behind: f32, slab: u32) -> f32 {
    (behind - slab as f32).clamp(0.0, 1.0)
}

/// Returns the index of the slab that contains hair. `behind`: distance of the hair from the start of the slabs, in
/// slabs; `slabs`: number of slabs, at least 1. Hair behind the last slab counts towards the last.
pub fn slab_of(behind: f32, slabs: u32) -> u32 {
    behind.clamp(0.0, slabs as f32 - 1.0) as u32
}
