//! Ink-wash style (Fang 2006): uniform blocks, and the WGSL that the ink passes share.

mod blocks;
mod seal_texture;

pub(crate) use blocks::{InkFrame, InkModel, painted_rect};
pub(crate) use seal_texture::SealTexture;
