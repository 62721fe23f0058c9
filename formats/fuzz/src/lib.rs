//! Code shared by the fuzz targets: see `bodies.rs`.

mod bodies;

pub use bodies::{limits, open, reseal, round_trip};
