//! What the fuzz targets share: see `bodies.rs`.

mod bodies;

pub use bodies::{limits, open, reseal, round_trip};
