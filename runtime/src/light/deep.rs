//! The deep opacity map of strands: how much hair lies before each point in the key light, counted from the first hair of each texel.

use super::view::LightView;
use crate::gpu::{Gpu, largest_buffer};
use bytemuck::{Pod, Zeroable};

/// Which map strands need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeepKey {
    /// Texels of a side.
    pub(crate) size: u32,
    /// Slabs of a texel.
    pub(crate) slabs: u32,
    /// How deep behind the first hair of a texel its slabs reach, metres.
    pub(crate) reach_m: f32,
}

/// How far behind the first hair the slabs reach, heights of the highest fur.
const REACH: f32 = 2.0;

/// Slabs of a texel.
const SLABS: u32 = 4;

/// Least width of a texel over that of a strand: in finer ones a strand hides all of some and nothing of others, and too much light comes past.
const TEXEL_WIDTHS: f32 = 1.25;

/// Smallest map, texels of a side.
const LEAST_SIZE: u32 = 16;

/// The hair that a map is for: the highest, and the widest strands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DeepHair {
    pub(crate) fur_m: f32,
    pub(crate) width_m: f32,
}

impl DeepHair {
    /// What suits both.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { fur_m: self.fur_m.max(other.fur_m), width_m: self.width_m.max(other.width_m) }
    }
}

impl DeepKey {
    /// Of a map of `map_size` texels a side, or half as many as often as strands or the buffers of the device ask for.
    pub(crate) fn new(map_size: u32, hair: DeepHair, view: &LightView, limits: &wgpu::Limits) -> Self {
        let too_fine = |size: u32| view.texel_m(size) < TEXEL_WIDTHS * hair.width_m;
        let too_large = |size: u32| bytes(size, SLABS) > largest_buffer(limits);
        let mut size = map_size;
        while size > LEAST_SIZE && (too_fine(size) || too_large(size)) {
            size /= 2;
        }
        Self { size, slabs: SLABS, reach_m: REACH * hair.fur_m }
    }
}

/// The uniform block.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct DeepOpacity {
    pub(crate) size: u32,
    pub(crate) slabs: u32,
    /// Slabs in a depth of 1.
    pub(crate) slabs_per_depth: f32,
    /// Width of a texel, metres; of a point light at 1 m.
    pub(crate) texel_m: f32,
    /// Share of the hair's optical depth that the light meets.
    pub(crate) density: f32,
    pub(crate) reserved: [f32; 3],
}

/// Bytes of a map of so many texels a side.
fn bytes(size: u32, slabs: u32) -> u64 {
    4 * u64::from(size) * u64::from(size) * u64::from(1 + slabs)
}

/// A map that holds nothing yet.
pub(super) fn make(gpu: &Gpu, key: &DeepKey) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
    gpu.buffer("pelage deep opacity", bytes(key.size, key.slabs), usage)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::bounds::Hull;
    use crate::camera::Light;
    use glam::Vec3;

    #[test]
    fn texels_are_wider_than_strands_and_fit_into_a_buffer() {
        let hull = Hull(vec![(Vec3::ZERO, 0.5)]);
        let view = LightView::new(&Light::default(), &hull, hull.sphere().unwrap());
        let limits = wgpu::Limits::default();
        let size = |map_size, width_m| DeepKey::new(map_size, DeepHair { fur_m: 0.01, width_m }, &view, &limits).size;
        // The maps are a little wider than the hull: about 2 mm a texel.
        assert!((0.0019..0.0023).contains(&view.texel_m(512)), "{}", view.texel_m(512));
        assert_eq!([0.0005, 0.0015, 0.0018, 0.004, 1.0].map(|width_m| size(512, width_m)), [512, 512, 256, 128, 16]);
        assert_eq!((size(2048, 0.0), size(8192, 0.0), size(100, 0.0)), (2048, 2048, 100));
        let both = DeepHair { fur_m: 1.0, width_m: 0.1 }.and(DeepHair { fur_m: 2.0, width_m: 0.05 });
        assert_eq!(both, DeepHair { fur_m: 2.0, width_m: 0.1 });
    }
}
