//! Stages of a bake, each in a folder or file of its own; [`crate::pipeline`] defines their order.
//!
//! A stage is a function of plain data. It uses no file, no clock and no global state, and its random numbers come from
//! the recipe's seed. It depends on the stages whose results it reads, and on nothing that evaluates its own result.

pub mod assemble;
mod cells;
pub mod contours;
pub mod detail;
pub mod fins;
#[cfg(test)]
pub(crate) mod fixtures;
pub mod groom;
pub mod hair_groups;
pub mod hair_motion;
pub mod import;
pub mod ink;
pub mod metric;
pub mod morphs;
pub mod openness;
pub mod pack;
pub mod painting;
mod reach;
pub mod rounding;
pub mod scatter;
pub mod simplify;
pub mod simulate;
pub mod size;
pub mod slice;
pub mod strand_data;
pub mod surface;
mod triangle_tree;
pub mod visibility;
