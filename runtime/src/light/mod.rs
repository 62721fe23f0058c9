//! Key light: its projection, its shadow maps and the application's geometry in them. The shaders of this folder light
//! hair; the single function that does so is in `point.wgsl`.

mod casters;
mod deep;
mod maps;
mod sky;
mod view;

pub use casters::{CasterPass, Casters};
pub(crate) use deep::DeepHair;
pub use maps::ShadowMaps;
pub(crate) use maps::{HairMaps, InstanceKey, ShadowKey, settle};
pub(crate) use sky::Skies;
pub use view::LightView;
