//! Buffers of the contour lines of an instance, filled on the GPU. Each instance has one set per frame in flight.

use crate::gpu::{Gpu, Pool};
use crate::model::ModelContours;
use crate::shared::shader_struct::shader_struct;
use std::sync::Arc;

shader_struct! {
    /// Point of a line, as extracted from the mesh, in shader layout.
    pub(crate) struct ContourNode {
        pub(crate) px: [f32; 2],
        pub(crate) depth: f32,
        pub(crate) weight: f32,
        pub(crate) outward: [f32; 2],
        pub(crate) marks: u32,
        pub(crate) next: u32,
        pub(crate) rest: [f32; 3],
        pub(crate) previous: u32,
        pub(crate) reserved: [f32; 4],
    }
}

shader_struct! {
    /// Point of a line, as it is drawn, in shader layout.
    pub(crate) struct LineNode {
        pub(crate) px: [f32; 2],
        pub(crate) tangent: [f32; 2],
        pub(crate) brush: [f32; 4],
        pub(crate) rest: [f32; 3],
        pub(crate) next: u32,
        pub(crate) ends: [f32; 4],
    }
}

/// Number of words before the counts of edges: draw arguments, node count, number of crossed edges.
const COUNTS_HEAD: u64 = 8;

/// Contour lines of an instance in a frame.
#[derive(Debug)]
pub(crate) struct ContourBuffers {
    /// Bit mask of crossed edges.
    pub(crate) crossed: wgpu::Buffer,
    /// Indirect draw arguments, numbers of nodes and of crossed edges; then, per 32 edges, the number of crossed edges
    /// before them.
    pub(crate) counts: wgpu::Buffer,
    /// Next and previous crossed edge of each edge, plus 1.
    pub(crate) links: wgpu::Buffer,
    /// Array of [`ContourNode`].
    pub(crate) nodes: wgpu::Buffer,
    /// State of the passes along lines, read and written in turns; 32 bytes per node.
    pub(crate) states: [wgpu::Buffer; 2],
    /// Array of [`LineNode`].
    pub(crate) lines: wgpu::Buffer,
}

impl ContourBuffers {
    fn sizes(model: &ModelContours) -> [u64; 6] {
        let [edges, nodes] = [model.edges, model.capacity()].map(u64::from);
        let words = edges.div_ceil(32);
        let of_nodes = nodes * size_of::<ContourNode>() as u64;
        [4 * words, 4 * (COUNTS_HEAD + words), 8 * edges, of_nodes, 32 * nodes, nodes * size_of::<LineNode>() as u64]
    }

    /// Returns buffers that no living frame uses.
    pub(crate) fn take(shelf: &mut Pool<Self>, gpu: &Gpu, model: &ModelContours) -> Arc<Self> {
        let sizes = Self::sizes(model);
        let fits = |set: &Self| {
            let Self { crossed, counts, links, nodes, states: [state, _], lines } = set;
            [crossed, counts, links, nodes, state, lines].map(wgpu::Buffer::size) == sizes
        };
        let set = shelf.take(fits).unwrap_or_else(|| {
            use wgpu::BufferUsages as Usage;
            // Strokes are read back for files of curves.
            let read = Usage::COPY_SRC;
            let make = |label, size, usage| gpu.buffer(label, size, Usage::STORAGE | read | usage);
            let [crossed, counts, links, nodes, state, lines] = sizes;
            Self {
                crossed: make("pelage crossed edges", crossed, Usage::COPY_DST),
                counts: make("pelage contour counts", counts, Usage::INDIRECT),
                links: make("pelage contour links", links, Usage::COPY_DST),
                nodes: make("pelage contour nodes", nodes, Usage::empty()),
                states: [0, 1].map(|_| make("pelage contour state", state, Usage::empty())),
                lines: make("pelage line nodes", lines, Usage::empty()),
            }
        });
        shelf.put(set)
    }
}
