//! The ink-wash style (Fang 2006): the constants that its shaders read. What they share stands in this folder.

mod blocks;

pub(crate) use blocks::{InkFrame, InkModel, painted_rect};
