//! Nearest hair segments of each pixel, in buffers that are filled on the GPU once per frame.

use super::visible_instance::VisibleInstance;
use crate::bounds::Hull;
use crate::gpu::{Gpu, Pool, largest_buffer};
use crate::params::{FrameParams, StrandEdges};
use bytemuck::{Pod, Zeroable};
use glam::Mat4;
use std::borrow::Cow;
use std::sync::Arc;
use wgpu::util::DrawIndirectArgs;

/// Maximum number of hair segments stored per pixel.
pub(crate) const NEAREST: u32 = 8;

/// Bytes per pixel: the keys, and the optical depth of the segments behind them.
const KEY_BYTES: u64 = 4 * (NEAREST as u64 + 1);

/// Width and height of a tile, pixels.
pub(crate) const TILE: u32 = 8;

/// Uniform block as declared in `hair/nearest.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct NearestHairBlock {
    /// Area of the picture: left, top, width and height, pixels. Width and height are multiples of [`TILE`].
    pub(crate) area: [u32; 4],
    /// Size of the whole picture, pixels.
    pub(crate) size: [f32; 2],
    /// Number of segments per strand.
    pub(crate) pieces: u32,
    /// Round of the gathering: 0 sorts keys, 1 stores light.
    pub(crate) round: u32,
}

/// Buffers of the nearest hair segments in a frame, and the area of the picture that they cover.
#[derive(Clone, Debug)]
pub(crate) struct NearestSegments {
    pub(crate) lists: Arc<NearestBuffers>,
    pub(crate) block: NearestHairBlock,
}

#[derive(Debug)]
pub(crate) struct NearestBuffers {
    /// Per pixel: sorted keys of its nearest segments, and the optical depth of the others.
    pub(crate) keys: wgpu::Buffer,
    /// Light of the segment of each key.
    pub(crate) lights: wgpu::Buffer,
    /// Indirect draw arguments, then the tile and layer of each instance.
    pub(crate) layers: wgpu::Buffer,
}

impl NearestBuffers {
    pub(crate) fn gpu_bytes(&self) -> u64 {
        self.keys.size() + self.lights.size() + self.layers.size()
    }

    /// Returns buffers for `tiles` tiles that no living frame uses. `most`: maximum size including the reserve, in
    /// tiles.
    fn take(shelf: &mut Pool<Self>, gpu: &Gpu, tiles: u64, most: u64) -> Arc<Self> {
        // The reserve keeps an approaching animal from creating buffers in every frame. Buffers left from a close view
        // are not reused if they are much too large.
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

/// Returns the area of the picture that a hull may cover, in whole tiles: left, top, width and height, pixels.
pub(super) fn area(hull: &Hull, clip_from_world: Mat4, viewport: [u32; 2]) -> [u32; 4] {
    let [left, top, right, bottom] = hull.screen_rect(clip_from_world, viewport, 1.0);
    [left, top, (right - left).next_multiple_of(TILE), (bottom - top).next_multiple_of(TILE)]
}

fn tiles(area: [u32; 4]) -> u32 {
    area[2] / TILE * (area[3] / TILE)
}

/// Returns `params` with strand edges that the device supports. Blended edges fall back to multisampled ones if the
/// device's largest buffer cannot hold the lists of all pixels in `area`.
pub(super) fn with_supported_edges<'p>(
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

impl NearestSegments {
    /// Returns the buffers of a frame with blended strand edges and visible strands. `hull`: bounds of the instances
    /// with strands.
    pub(super) fn take(
        shelf: &mut Pool<NearestBuffers>,
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
        let block = NearestHairBlock { area, size, pieces: 0, round: 0 };
        Some(Self { lists: NearestBuffers::take(shelf, gpu, count.into(), most.min(picture)), block })
    }

    /// Clears the part of the buffers that this frame uses.
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        let pixels = u64::from(self.tiles() * TILE * TILE);
        encoder.clear_buffer(&self.lists.keys, 0, Some(pixels * KEY_BYTES));
        encoder.clear_buffer(&self.lists.lights, 0, Some(pixels * 4 * u64::from(NEAREST)));
        encoder.clear_buffer(&self.lists.layers, 0, Some(size_of::<DrawIndirectArgs>() as u64));
    }

    /// Returns the number of tiles in the area.
    pub(crate) fn tiles(&self) -> u32 {
        tiles(self.block.area)
    }
}

/// Returns whether single strands of the instance may be in the picture.
pub(super) fn has_ribbons(seen: &VisibleInstance) -> bool {
    seen.sets.iter().any(|set| set.ribbons.is_some())
}
