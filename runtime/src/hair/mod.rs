//! Hair: how much of an instance's hair is drawn, the constants of its shaders, and the shaders shared by all hair
//! geometries.

mod detail;
mod look;
mod thin;

pub(crate) use detail::{Drawing, DrawnSet};
pub(crate) use look::{Look, groom, grown, grown_by, hair_wgsl, holes, material};
