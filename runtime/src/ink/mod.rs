//! Ink-wash style (Fang 2006): uniform blocks, and the WGSL that the ink passes share.

mod blocks;

pub(crate) use blocks::{InkFrame, InkModel, painted_rect};
