//! Laboratory: charts of accuracy against cost, stability tests of methods, and the published forms of the papers. This
//! crate is not released.

pub mod chart;
pub mod command;
pub mod compare_lines;
pub mod compare_motion;
mod least_squares;
pub mod mask;
pub mod measure_painting;
pub mod printed_light;
pub mod stability;
pub mod truth;
