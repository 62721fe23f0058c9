//! Key light: its projection, its shadow maps, and the application's geometry in them. The shaders in this folder light
//! hair; `point.wgsl` has the single function that does so.

mod casters;
mod deep;
mod environment;
mod maps;
mod view;

pub use casters::{CasterPass, Casters};
pub(crate) use deep::DeepMapHair;
pub(crate) use environment::EnvironmentCache;
#[cfg(test)]
pub(crate) use environment::PARTS;
pub use maps::ShadowMaps;
pub(crate) use maps::{HairMapKind, InstanceKey, ShadowKey, get_or_create};
pub use view::LightView;
