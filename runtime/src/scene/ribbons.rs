//! What strands are drawn from: buffers that a frame fills on the GPU, one set for each instance and frame in use at a time.

use crate::gpu::{Gpu, Shelf};
use crate::model::Strands;
use std::sync::Arc;
use wgpu::util::DrawIndexedIndirectArgs;

/// Ribbons of the strands of an instance that a frame sees.
#[derive(Debug)]
pub(crate) struct Ribbons {
    /// Of each strand a bit, 32 in a number: it is seen.
    pub(crate) seen: wgpu::Buffer,
    /// Arguments of the draw; then of each 32 strands how many are seen before them.
    pub(crate) counts: wgpu::Buffer,
    /// Corners: three numbers of their place in world space, then light.
    pub(crate) corners: wgpu::Buffer,
    /// Two triangles of each piece, where they are drawn as such.
    pub(crate) indices: Option<wgpu::Buffer>,
}

/// Strands in a number of `seen`.
const OF_A_NUMBER: u32 = 32;

/// Corners of the two triangles of a piece, of which each end has two.
const PIECE: [u32; 6] = [0, 1, 2, 2, 1, 3];

impl Ribbons {
    /// A set for strands of which every `step`th point is drawn, as triangles where they are `drawn` so, none that a living frame still draws from.
    pub(super) fn take(shelf: &mut Shelf<Self>, gpu: &Gpu, strands: &Strands, step: u32, drawn: bool) -> Arc<Self> {
        let pieces = strands.pieces(step);
        let numbers = u64::from(strands.count / OF_A_NUMBER);
        let sizes =
            [4 * numbers, size_of::<DrawIndexedIndirectArgs>() as u64 + 4 * numbers, strands.ribbon_bytes(step)];
        let index_bytes = u64::from(strands.count) * u64::from(pieces) * size_of_val(&PIECE) as u64;
        let indexed = |set: &Self| set.indices.as_ref().map(wgpu::Buffer::size) == drawn.then_some(index_bytes);
        let fits = |set: &Self| indexed(set) && [&set.seen, &set.counts, &set.corners].map(wgpu::Buffer::size) == sizes;
        let set = shelf.take(fits).unwrap_or_else(|| {
            use wgpu::BufferUsages as Usage;
            let [seen, counts, corners] = sizes;
            let indices = || {
                let firsts = (0..strands.count).flat_map(|k| (0..pieces).map(move |i| 2 * (k * (pieces + 1) + i)));
                let indices: Vec<u32> = firsts.flat_map(|first| PIECE.map(|corner| first + corner)).collect();
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
