//! Painted ink strokes: uniform blocks, buffers of posed strokes, and the WGSL that the painting passes share.

mod blocks;
mod buffers;
mod read;

pub(crate) use blocks::{PaintedModel, PaintingFrame, PaintingView};
pub(crate) use buffers::{BrushPoint, PaintedStrokes};
pub use read::{PictureStroke, StrokeLayer, StrokeMark};
pub(crate) use read::{lines, surface_strokes};
