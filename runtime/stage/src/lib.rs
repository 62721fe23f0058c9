//! The stage: what an application, a tool or a test needs to put animals into a picture, beside the animals.
//!
//! Without features it is plain data: packages with their names ([`NamedPackage`]), models that stand, walk and play clips ([`Cast`], [`Place`],
//! [`Playing`]), values over time ([`Track`]), cameras ([`Viewpoint`], [`Shot`], [`framing`]; [`Navigator`] for those that people move), scene files that say all of it ([`SceneFile`]), and skies as light
//! ([`sky`]).
//! Nothing of it knows a GPU, a window or the file system.
//!
//! With the feature `draw` there is a device without a window ([`Gpu`]), targets to draw on and read back ([`Canvas`]), a cast on a canvas
//! ([`Stage`]), what measures it ([`Meter`]), and who goes from one clip to another ([`Animator`]).

#[cfg(feature = "draw")]
mod animator;
#[cfg(feature = "draw")]
mod canvas;
mod cast;
mod error;
mod extent;
pub mod framing;
#[cfg(feature = "draw")]
mod gpu;
mod look;
#[cfg(feature = "draw")]
mod meter;
mod navigator;
mod package;
mod scene_file;
pub mod sky;
#[cfg(feature = "draw")]
mod stage;
mod toml_text;
mod track;
mod viewpoint;

#[cfg(feature = "draw")]
pub use animator::Animator;
#[cfg(feature = "draw")]
pub use canvas::{COLOR_FORMAT, Canvas, CanvasOptions, DEPTH_FORMAT};
pub use cast::{Actor, Cast, Place, Playing, carried_by, clip_named, find_clip, find_morph, framed, within};
pub use error::StageError;
pub use extent::{nothing_named, outline};
pub use framing::{Framing, Orbit};
#[cfg(feature = "draw")]
pub use gpu::Gpu;
pub use look::{
    Background, FillLight, Interval, KeyLight, LightsRead, Look, LookDetail, LookEnvironment, LookFur, LookFurShow,
    LookHair, LookInk, LookLight, LookMotion, LookPicture, LookScattering, LookSelfShadow, LookShadow, LookShow,
    LookStrandEdges, LookStyle, LookWidth, ReadLights, Rgb, SAMPLES, SHORT_FORMS, Samples, ShortForm, Size, SkyOf,
    SkySource,
};
#[cfg(feature = "study")]
pub use look::{LookAnchoring, LookLighting, LookPenumbra, LookRule, LookSlant, LookSphereMap, LookStudy};
#[cfg(feature = "draw")]
pub use meter::{Clock, FrameTimes, Meter, Spread, belongs, count_fragments, fastest, is_shadowed};
pub use navigator::Navigator;
pub use package::NamedPackage;
/// What is wrong with a look.
pub use pelage_params::ParamError;
pub use scene_file::{
    CameraKey, FieldOfView, LoadedScene, Number, PackageSource, PlaceKey, Point, Scale, Scene, SceneCamera, SceneFile,
    SceneLight, SceneLook, SceneModel, SceneSequence, Whole,
};
#[cfg(feature = "draw")]
pub use stage::{Picture, Stage, camera};
pub use toml_text::TomlText;
pub use track::{LEAST_STEP_S, Track, Value};
pub use viewpoint::{Shot, Viewpoint};
