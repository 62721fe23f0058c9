//! The project's own models, made from code alone: animals from implicit surfaces, with skeletons and gaits, and the torus and torus knot of
//! Yang 2006, Table 1, and patterns for their coats. `make_assets` writes them into `assets/models` and `assets/patterns`.
//!
//! The same source gives the same bytes on every machine: only `+ - * /` and square roots from the processor, sines and
//! cosines from `libm`, no parallel sums, no hash-map order.

pub mod body;
pub mod charts;
pub mod crane;
pub mod crane_rig;
pub mod gait;
pub mod glb;
pub mod hare;
pub mod hare_rig;
pub mod head;
pub mod hills;
pub mod hoofs;
pub mod ox;
pub mod ox_rig;
pub mod patterns;
pub mod pony;
pub mod pony_rig;
pub mod pose;
pub mod preview;
pub mod regions;
pub mod remesh;
pub mod rig;
pub mod sdf;
pub mod shapes;
pub mod skin;
pub mod trimesh;
