//! Parameters that are set once or per frame, as plain data.

mod brush;
mod debug;
mod detail;
mod frame;
mod fur;
mod hair_motion;
mod ink;
mod renderer;
mod seal;
mod shadows;
#[cfg(feature = "study")]
mod study;
mod style;
mod tone_mapping;

pub use brush::{BrushParams, BrushSheet};
pub use debug::{DebugView, FurDebugView, InkDebugView};
pub use detail::Detail;
pub(crate) use frame::check_shading;
pub use frame::{FrameParams, MAX_FILL_LIGHTS};
pub use fur::{FurParams, HairGeometry, Scattering, SelfShadow, StrandEdges};
pub use hair_motion::{HairMotionParams, Wind};
pub use ink::{InkBackground, InkLines, InkParams, LineWidth};
pub use renderer::RendererOptions;
pub use seal::Seal;
pub use shadows::ShadowParams;
#[cfg(feature = "study")]
pub use study::{Anchoring, FeatureRule, LightingStage, OpacityForm, PenumbraForm, SlantForm, SphereMapForm, Study};
pub use style::{Style, StyleKind};
pub use tone_mapping::ToneMapping;
