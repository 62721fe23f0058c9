//! Generated models of this project: animals from implicit surfaces with skeletons and gaits, the torus and torus knot
//! of Yang 2006, Table 1, and fur patterns. `make_assets` writes them into `assets/models` and `assets/patterns`.
//!
//! The same source gives the same bytes on every machine. The processor computes only `+ - * /` and square roots; sines
//! and cosines come from `libm`. The code has no parallel sums and does not depend on the order of hash maps.

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
pub mod hooves;
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
