//! The offline half of pelage: a glTF or OBJ model and a recipe go in, a `.pelage` package comes out.
//!
//! [`pipeline`] reads top to bottom in the order of the [`stages`]; each stage is a function of plain data in a module of its own. [`strands`]
//! plants hair by hair on a baked skin what a package shows as layers.
//! No stage touches a file, a clock or a global; the same inputs give the same bytes on any number of threads.

#![cfg_attr(test, allow(clippy::disallowed_methods, reason = "tests make no package that anyone keeps"))]

pub mod cache;
pub mod decision;
pub mod groom_map;
pub mod hexadecimal;
pub mod io;
pub mod mask;
pub mod noise;
pub mod picture;
pub mod pipeline;
pub mod rebake;
pub mod recipe;
pub mod recorded;
pub mod remade;
pub mod reslice;
mod sample;
pub mod sky_file;
pub mod stages;
pub mod steps;
pub mod strands;
pub mod traffic;
pub mod unfinished;
pub mod y4m;

pub use pelage_import::{BakeError, guides, mesh};
