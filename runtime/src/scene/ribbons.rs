//! Ribbon buffers of strands, filled on the GPU. Each instance has one set per frame in flight.

use crate::gpu::{Gpu, Pool};
use crate::model::StrandSet;
use std::sync::Arc;
use wgpu::util::DrawIndexedIndirectArgs;

/// Ribbons of an instance's visible strands in a frame.
#[derive(Debug)]
pub(crate) struct Ribbons {
    /// Visibility mask: one bit per strand, 32 per word.
    pub(crate) seen: wgpu::Buffer,
    /// Indirect draw arguments; then, per 32 strands, the number of visible strands before them.
    pub(crate) counts: wgpu::Buffer,
    /// Corners of the ribbons: three words of world-space position, then one of light.
    pub(crate) corners: wgpu::Buffer,
    /// Indices of two triangles per segment; `None` if the ribbons are not drawn as triangles.
    pub(crate) indices: Option<wgpu::Buffer>,
}

/// Number of strands per word of `seen`.
const STRANDS_PER_WORD: u32 = 32;

/// Corners of a segment's two triangles. Each end of the segment has two corners.
const SEGMENT_INDICES: [u32; 6] = [0, 1, 2, 2, 1, 3];

impl Ribbons {
    /// Returns buffers that no living frame uses, for strands with every `step`th point. `drawn`: the ribbons are drawn
    /// as triangles.
    pub(super) fn take(shelf: &mut Pool<Self>, gpu: &Gpu, strands: &StrandSet, step: u32, drawn: bool) -> Arc<Self> {
        let pieces = strands.segments(step);
        let numbers = u64::from(strands.count / STRANDS_PER_WORD);
        let sizes =
            [4 * numbers, size_of::<DrawIndexedIndirectArgs>() as u64 + 4 * numbers, strands.ribbon_bytes(step)];
        let index_bytes = u64::from(strands.count) * u64::from(pieces) * size_of_val(&SEGMENT_INDICES) as u64;
        let indexed = |set: &Self| set.indices.as_ref().map(wgpu::Buffer::size) == drawn.then_some(index_bytes);
        let fits = |set: &Self| indexed(set) && [&set.seen, &set.counts, &set.corners].map(wgpu::Buffer::size) == sizes;
        let set = shelf.take(fits).unwrap_or_else(|| {
            use wgpu::BufferUsages as Usage;
            let [seen, counts, corners] = sizes;
            let indices = || {
                let firsts = (0..strands.count).flat_map(|k| (0..pieces).map(move |i| 2 * (k * (pieces + 1) + i)));
                let indices: Vec<u32> = firsts.flat_map(|first| SEGMENT_INDICES.map(|corner| first + corner)).collect();
                gpu.buffer_of("pelage ribbon indices", bytemuck::cast_slice(&indices), Usage::INDEX)
            };
            Self {
                seen: gpu.buffer("pelage strands seen", seen, Usage::STORAGE | Usage::COPY_DST),
                counts: gpu.buffer("pelage strand counts", counts, Usage::STORAGE | Usage::INDIRECT),
                corners: gpu.buffer("pelage ribbons", corners, Usage::STORAGE | Usage::VERTEX),
                indices: drawn.then(indices),
            }
        });
        shelf.put(set)
    }
}
