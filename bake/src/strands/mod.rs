//! Individual strands of a package on its mesh surface. Layers approximate this hair; exports and the ray-traced
//! reference show it.
//!
//! [`grow_on`] grows the strands of the tile again from the package's own recipe and plants them on a [`PosedMesh`].
//! [`Curves`] contain them in world space, and [`export`] writes them for other programs.

pub mod export;

mod curves;
mod groups;
mod plant;
mod skin;

pub use curves::{CurveGroup, CurvePoint, Curves, TILE_GROUP, simplified};
pub use groups::grow_groups;
pub use plant::{GroomReport, grow_on, tile_hair};
pub use skin::{PosedMaterial, PosedMesh, PosedVertex};
