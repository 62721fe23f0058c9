//! Tests of the package file: round trip and rules of every section, damage, limits, golden files and a C reader.
#![allow(clippy::disallowed_methods, reason = "packages made by tests are never kept")]
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

#[path = "../../fuzz/src/bodies.rs"]
mod bodies;
mod common;

mod allocation;
mod bare_normals;
mod contours;
mod damage;
mod fibres;
mod gloss;
mod golden;
mod hair;
mod hair_colors;
mod hair_motion;
mod ink;
mod ktx2_files;
mod morphs;
mod openness;
mod roots;
mod round_trip;
mod sampling;
mod simplified;
mod smoke;
mod spec_reader;
mod strands;
mod strokes;
mod visibility;
