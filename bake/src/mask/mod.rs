//! Sets of pixels and distances between them, for measuring drawn lines.
//!
//! Distances are exact ([`Mask::distances`], by lower envelopes of parabolas). Lines of any width are thinned to one
//! pixel ([`Mask::core`]). The width of the widest stroke is the diameter of the largest disc that fits into ink
//! ([`Mask::widest_stroke`]).

mod distance;
mod set;
mod thinning;

pub use set::{Mask, Stroke};

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
