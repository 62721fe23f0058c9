//! The offline half of pelage: a glTF or OBJ model and a recipe go in, a `.pelage` package comes out.
//!
//! [`pipeline`] reads top to bottom in the order of the stages; each stage is a function of plain data in a module of its own.
//! No stage touches a file, a clock or a global; the same inputs give the same bytes on any number of threads.

pub mod chart;
pub mod compare;
pub mod compare_lines;
pub mod compare_motion;
pub mod decide;
pub mod detail;
pub mod doctor;
pub mod error;
pub mod export;
pub mod fins;
pub mod groom;
pub mod hair;
pub mod import;
pub mod ink;
pub mod io;
pub mod mask;
pub mod mesh;
pub mod pack;
pub mod picture;
pub mod pipeline;
pub mod recipe;
pub mod reference;
pub mod reslice;
pub mod stability;
pub mod surface;
pub mod textures;
pub mod y4m;

pub use error::BakeError;
