//! Buffers of posed strokes, filled on the GPU once per frame.

use crate::gpu::{Gpu, Pool};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Point of a posed stroke, as declared in `painting/strokes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct BrushPoint {
    /// Pixel position, distance from the eye plane, and half width, pixels.
    pub(crate) place: [f32; 4],
    /// Density of the ink, dryness, distance along the stroke in pixels, and load of the brush's sides.
    pub(crate) brush: [f32; 4],
}

/// Posed strokes of an instance in a frame.
#[derive(Debug)]
pub(crate) struct PaintedStrokes {
    /// [`BrushPoint`]s of all strokes.
    pub(crate) points: wgpu::Buffer,
}

impl PaintedStrokes {
    /// Returns buffers that no living frame uses, for a number of points.
    pub(crate) fn take(shelf: &mut Pool<Self>, gpu: &Gpu, points: u32) -> Arc<Self> {
        let bytes = u64::from(points.max(1)) * size_of::<BrushPoint>() as u64;
        let set = shelf.take(|set| set.points.size() == bytes).unwrap_or_else(|| Self {
            points: gpu.buffer(
                "pelage painted strokes",
                bytes,
                wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            ),
        });
        shelf.put(set)
    }
}
