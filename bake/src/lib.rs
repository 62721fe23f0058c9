//! Offline half of pelage: converts a glTF or OBJ model and a recipe into a `.pelage` package.
//!
//! [`pipeline`] lists the steps in the order of the [`stages`]. Each stage is a function of plain data in its own
//! module. [`strands`] turns the layers of a package into single strands on the baked mesh. No stage accesses a file, a
//! clock or a global variable. The same inputs give the same bytes with any number of threads.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "packages made by tests are never kept"))]

pub mod cache;
pub mod decision;
pub mod environment_file;
pub mod groom_map;
pub mod hexadecimal;
pub mod io;
pub mod io_guard;
pub mod io_trace;
pub mod mask;
pub mod memo;
pub mod noise;
pub mod picture;
pub mod pipeline;
pub mod progress;
pub mod rebake;
pub mod recipe;
pub mod recipe_mismatch;
pub mod reslice;
mod sample;
pub mod stages;
pub mod strands;
pub mod temp_files;
pub mod y4m;

pub use pelage_import::{BakeError, guides, mesh};
