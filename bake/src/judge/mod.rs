//! What is asked of a bake and of its pictures: truths, comparisons, charts, drivers of what fails, the search within limits, and advice.
//!
//! A judge may look at everything below it. No stage depends on a judge.

pub mod chart;
pub mod compare;
pub mod compare_lines;
pub mod compare_motion;
pub mod decide;
pub mod doctor;
pub mod stability;
pub mod truth;
