//! Sets of pixels and distances between them, for measuring lines in rendered images.
//!
//! [`Mask::distances`] returns exact distances, computed with lower envelopes of parabolas. [`Mask::core`] thins lines
//! of any width to one pixel. [`Mask::widest_stroke`] returns the diameter of the largest disc that fits into the ink.

mod distance;
mod set;
mod thinning;

pub use set::{Mask, Stroke};

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
