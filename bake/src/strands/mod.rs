//! Strands of a package, one by one on its mesh surface: the hair that layers approximate, that is exported, and that
//! the ray-traced reference shows.
//!
//! [`grow_on`] grows the strands of the tile again from the package's own recipe and plants them on a posed
//! [`PosedMesh`]. [`Curves`] hold them in world space, and [`export`] writes those for other programs.

pub mod export;

mod curves;
mod groups;
mod plant;
mod skin;

pub use curves::{CurveGroup, CurvePoint, Curves, TILE_GROUP, simplified};
pub use groups::grow_groups;
pub use plant::{GroomReport, grow_on, tile_hair};
pub use skin::{PosedMaterial, PosedMesh, PosedVertex};
