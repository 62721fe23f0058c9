//! What is asked of a bake and of its pictures: truths, comparisons, charts, drivers of what fails, the search within limits, and advice.
//!
//! A judge may look at everything below it. No stage depends on a judge.

#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod chart;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod compare;
pub mod compare_lines;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod compare_motion;
pub mod decide;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod doctor;
mod least_squares;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod likeness;
pub mod printed_light;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod stability;
#[allow(clippy::disallowed_methods, reason = "figures and pictures, no package")]
pub mod truth;
