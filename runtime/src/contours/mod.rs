//! Contour lines of the ink style: uniform block of an instance, its buffers, and the WGSL that the passes share.

mod block;
mod buffers;

pub(crate) use block::{ContourBlock, ContourView, LineBrush};
pub(crate) use buffers::{ContourBuffers, ContourNode, LineNode};
