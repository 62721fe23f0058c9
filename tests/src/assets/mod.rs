//! The project's own models, made from code alone: a hare from an implicit surface, and the torus and torus knot of
//! Yang 2006, Table 1. `make_assets` writes them into `assets/models`.
//!
//! The same source gives the same bytes on every machine: only `+ - * /` and square roots from the processor, sines and
//! cosines from `libm`, no parallel sums, no hash-map order.

pub mod charts;
pub mod glb;
pub mod hare;
pub mod hare_rig;
pub mod preview;
pub mod remesh;
pub mod sdf;
pub mod shapes;
pub mod trimesh;
