//! The key light: where it sees the scene from, its shadow maps, and what of the application's takes part in them. How hair is lit stands in the
//! shaders of this folder: `point.wgsl` has the one function that does it.

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
