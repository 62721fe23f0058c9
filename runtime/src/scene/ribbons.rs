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
    /// Two triangles of each piece.
    pub(crate) indices: wgpu::Buffer,
}

/// Strands in a number of `seen`.
const OF_A_NUMBER: u32 = 32;

/// Corners of the two triangles of a piece, of which each end has two.
const PIECE: [u32; 6] = [0, 1, 2, 2, 1, 3];

impl Ribbons {
    /// A set for strands of which every `step`th point is drawn, none that a living frame still draws from.
    pub(super) fn take(shelf: &mut Shelf<Self>, gpu: &Gpu, strands: &Strands, step: u32) -> Arc<Self> {
        let pieces = strands.pieces(step);
        let numbers = u64::from(strands.count / OF_A_NUMBER);
        let of_all = u64::from(strands.count) * u64::from(pieces) * size_of_val(&PIECE) as u64;
        let sizes = [
            4 * numbers,
            size_of::<DrawIndexedIndirectArgs>() as u64 + 4 * numbers,
            strands.ribbon_bytes(step),
            of_all,
        ];
        let fits = |set: &Self| [&set.seen, &set.counts, &set.corners, &set.indices].map(wgpu::Buffer::size) == sizes;
        let set = shelf.take(fits).unwrap_or_else(|| {
            use wgpu::BufferUsages as Usage;
            let [seen, counts, corners, _] = sizes;
            let first_corners = (0..strands.count).flat_map(|k| (0..pieces).map(move |i| 2 * (k * (pieces + 1) + i)));
            let indices: Vec<u32> = first_corners.flat_map(|first| PIECE.map(|corner| first + corner)).collect();
            Self {
                seen: gpu.buffer("pelage strands seen", seen, Usage::STORAGE | Usage::COPY_DST),
                counts: gpu.buffer("pelage strand counts", counts, Usage::STORAGE | Usage::INDIRECT),
                corners: gpu.buffer("pelage ribbons", corners, Usage::STORAGE | Usage::VERTEX),
                indices: gpu.buffer_of("pelage ribbon indices", bytemuck::cast_slice(&indices), Usage::INDEX),
            }
        });
        shelf.put(set)
    }
}
