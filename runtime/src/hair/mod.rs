//! Hair: how much of an instance's is drawn, and what its shaders are told. The geometries' shared shaders stand in this folder.

mod detail;
mod look;
mod thin;

pub(crate) use detail::{Drawing, DrawnSet};
pub(crate) use look::{Look, groom, grown, grown_by, hair_wgsl, holes, material};
