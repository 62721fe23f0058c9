//! Sets of pixels, and how far it is from one to the next: what drawn lines are measured with.
//!
//! Distances are exact ([`Mask::distances`], by lower envelopes of parabolas), lines of any width come down to one pixel ([`Mask::core`]), and the
//! widest stroke is the largest disc that fits into ink ([`Mask::widest_stroke`]).

mod distance;
mod set;
mod thin;

pub use set::{Mask, Stroke};

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
