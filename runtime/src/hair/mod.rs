//! Hair: how much of an instance's is drawn, and what its shaders are told. The geometries' shared shaders stand in this folder.

mod detail;
mod look;

pub(crate) use detail::Drawing;
pub(crate) use look::{Look, groom, hair_wgsl, holes, material};

/// Vertices of a fin's quad, as in `fin_corner.wgsl`.
pub(crate) const FIN_CORNERS: u32 = 6;
/// Quads of a fin where hair leans, as there; elsewhere one.
pub(crate) const LEANING_ROWS: u32 = 3;
