//! The nearest pieces of hair in each pixel: buffers that a frame fills on the GPU.

use super::seen::Seen;
use crate::bounds::Hull;
use crate::gpu::{Gpu, Shelf, largest_buffer};
use crate::params::{FrameParams, StrandEdges};
use bytemuck::{Pod, Zeroable};
use glam::Mat4;
use std::borrow::Cow;
use std::sync::Arc;
use wgpu::util::DrawIndirectArgs;

/// Pieces of hair that a pixel keeps.
pub(crate) const NEAREST: u32 = 8;

/// Bytes of a pixel's keys, and of how opaque what is behind those is.
const KEY_BYTES: u64 = 4 * (NEAREST as u64 + 1);

/// Pixels along a side of a tile.
pub(crate) const TILE: u32 = 8;

/// What the shaders are told of them, as `hair/nearest.wgsl` declares it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct NearestHair {
    /// Part of the picture: left, top, width and height in pixels, the last two multiples of [`TILE`].
    pub(crate) area: [u32; 4],
    /// Of the whole picture, pixels.
    pub(crate) size: [f32; 2],
    /// Of a strand.
    pub(crate) pieces: u32,
    /// Of the gathering: 0 sorts keys, 1 leaves light.
    pub(crate) round: u32,
}

/// Where the nearest pieces of a frame's hair are gathered, and which part of the picture that is.
#[derive(Clone, Debug)]
pub(crate) struct Nearest {
    pub(crate) lists: Arc<NearestLists>,
    pub(crate) block: NearestHair,
}

/// Buffers of the nearest pieces of hair.
#[derive(Debug)]
pub(crate) struct NearestLists {
    /// Of each pixel what is in it, sorted, and how opaque the rest is.
    pub(crate) keys: wgpu::Buffer,
    /// Of each of those its light.
    pub(crate) lights: wgpu::Buffer,
    /// Arguments of the draw of all, then tile and layer of each of its instances.
    pub(crate) layers: wgpu::Buffer,
}

impl NearestLists {
    /// Bytes on the GPU.
    pub(crate) fn gpu_bytes(&self) -> u64 {
        self.keys.size() + self.lights.size() + self.layers.size()
    }

    /// Lists of so many tiles, none that a living frame still draws from; of at most as many as `most` where there is a choice.
    fn take(shelf: &mut Shelf<Self>, gpu: &Gpu, tiles: u64, most: u64) -> Arc<Self> {
        // With room to grow, or an animal that comes nearer would make buffers in each frame; but not those of one that was nearer long ago.
        let room = tiles.next_power_of_two().min(most).max(tiles);
        let bytes = |tiles: u64| tiles * u64::from(TILE * TILE) * KEY_BYTES;
        let fits = |lists: &Self| (bytes(tiles)..=bytes(2 * room)).contains(&lists.keys.size());
        let lists = shelf.take(fits).unwrap_or_else(|| {
            use wgpu::BufferUsages as Usage;
            let pixels = room * u64::from(TILE * TILE);
            let of_pixels = |label, bytes| gpu.buffer(label, pixels * bytes, Usage::STORAGE | Usage::COPY_DST);
            let layers = size_of::<DrawIndirectArgs>() as u64 + 4 * room * u64::from(NEAREST);
            Self {
                keys: of_pixels("pelage nearest hair", KEY_BYTES),
                lights: of_pixels("pelage light of nearest hair", 4 * u64::from(NEAREST)),
                layers: gpu.buffer(
                    "pelage layers of nearest hair",
                    layers,
                    Usage::STORAGE | Usage::INDIRECT | Usage::COPY_DST,
                ),
            }
        });
        shelf.put(lists)
    }
}

/// The part of the picture that a hull may reach, in whole tiles: left, top, width and height, pixels.
pub(super) fn area(hull: &Hull, clip_from_world: Mat4, viewport: [u32; 2]) -> [u32; 4] {
    let [left, top, right, bottom] = hull.on_screen(clip_from_world, viewport, 1.0);
    [left, top, (right - left).next_multiple_of(TILE), (bottom - top).next_multiple_of(TILE)]
}

fn tiles(area: [u32; 4]) -> u32 {
    area[2] / TILE * (area[3] / TILE)
}

/// `params` as they can be drawn: strands in samples where the device's buffers do not hold the lists of all pixels of the `area` that they may reach.
pub(super) fn drawable<'p>(
    params: &'p FrameParams,
    limits: &wgpu::Limits,
    area: impl FnOnce() -> [u32; 4],
) -> Cow<'p, FrameParams> {
    let bytes = || u64::from(tiles(area())) * u64::from(TILE * TILE) * KEY_BYTES;
    let blended = params.style.fur().is_some_and(|fur| fur.strand_edges == StrandEdges::Blended);
    if blended && bytes() > largest_buffer(limits) {
        return Cow::Owned(params.clone().with_fur(|fur| fur.strand_edges = StrandEdges::Samples));
    }
    Cow::Borrowed(params)
}

impl Nearest {
    /// Of a frame that asks for them and draws strands, whose instances reach as far as `hull`.
    pub(super) fn of(
        shelf: &mut Shelf<NearestLists>,
        gpu: &Gpu,
        params: &FrameParams,
        hull: &Hull,
        clip_from_world: Mat4,
    ) -> Option<Self> {
        params.style.fur().filter(|fur| fur.strand_edges == StrandEdges::Blended)?;
        let area = area(hull, clip_from_world, params.viewport);
        let count = Some(tiles(area)).filter(|count| *count > 0)?;
        let most = largest_buffer(&gpu.device.limits()) / (u64::from(TILE * TILE) * KEY_BYTES);
        let picture = params.viewport.map(|side| u64::from(side.div_ceil(TILE))).iter().product::<u64>();
        let size = params.viewport.map(|side| side as f32);
        let block = NearestHair { area, size, pieces: 0, round: 0 };
        Some(Self { lists: NearestLists::take(shelf, gpu, count.into(), most.min(picture)), block })
    }

    /// Empties what this frame uses of the lists.
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        let pixels = u64::from(self.tiles() * TILE * TILE);
        encoder.clear_buffer(&self.lists.keys, 0, Some(pixels * KEY_BYTES));
        encoder.clear_buffer(&self.lists.lights, 0, Some(pixels * 4 * u64::from(NEAREST)));
        encoder.clear_buffer(&self.lists.layers, 0, Some(size_of::<DrawIndirectArgs>() as u64));
    }

    /// Tiles of its part of the picture.
    pub(crate) fn tiles(&self) -> u32 {
        tiles(self.block.area)
    }
}

/// Whether single strands of it are to be in the picture.
pub(super) fn has_ribbons(seen: &Seen) -> bool {
    seen.sets.iter().any(|set| set.ribbons.is_some())
}
