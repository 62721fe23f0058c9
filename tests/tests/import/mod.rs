//! Tests of the importer with valid, broken and hostile files; comparisons with other crates.

mod comb_lines;
mod compressed;
mod crosscheck;
mod data;
mod faults;
mod geometry;
mod hair;
mod instances;
mod io;
mod motion;
mod mutation;
mod obj;
pub mod support;
