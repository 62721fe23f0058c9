//! Stage: everything that an application, tool or test needs for a picture besides the models.
//!
//! Without features it is plain data, independent of GPU, windows and file system:
//!
//! * packages with their names ([`NamedPackage`])
//! * models with positions, paths and clips ([`Cast`], [`Placement`], [`Playback`])
//! * values over time ([`Track`])
//! * cameras ([`Viewpoint`], [`CameraTrack`], [`framing`]), and interactive ones ([`Navigator`])
//! * scene files that describe all of this ([`SceneFile`])
//! * environment maps as light ([`sky`])
//!
//! The feature `draw` adds a device without a window ([`Gpu`]), offscreen targets ([`Canvas`]), drawing of a cast on a
//! canvas ([`Stage`]), measurements ([`Meter`]), and cross-fades between clips ([`Animator`]).

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
#[cfg(feature = "draw")]
mod ground;
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
pub use cast::{
    Actor, Cast, MAX_COPIES, Placement, Playback, clip_named, find_clip, find_morph, frame_actors, root_displacement,
    wrap_time,
};
pub use error::StageError;
pub use extent::{no_match_error, outline};
pub use framing::{Framing, Orbit};
#[cfg(feature = "draw")]
pub use gpu::Gpu;
#[cfg(feature = "draw")]
pub use ground::GroundKind;
pub use look::{
    BUILT_IN_LOOKS, Background, BuiltInLook, CONDITIONS, DEFAULT_INK, FillLight, Interval, KeyLight, LightsRead, Look,
    LookDetail, LookEnvironment, LookFur, LookFurShow, LookHair, LookInk, LookLight, LookLines, LookMotion,
    LookPicture, LookScattering, LookSelfShadow, LookShadow, LookSheet, LookShow, LookStrandEdges, LookStudio,
    LookStyle, LookToneMapping, LookWidth, ReadLights, ReadSeal, Rgb, SAMPLES, SHORT_FORMS, Samples, SealSource,
    ShortForm, Size, SkyKind, SkySource,
};
#[cfg(feature = "study")]
pub use look::{LookAnchoring, LookLighting, LookPenumbra, LookRule, LookSlant, LookSphereMap, LookStudy};
#[cfg(feature = "draw")]
pub use meter::{Clock, FrameTimes, Meter, Spread, belongs, count_fragments, fastest, is_shadowed};
pub use navigator::Navigator;
pub use package::NamedPackage;
/// Error in a look.
pub use pelage_params::ParamError;
pub use scene_file::{
    CameraKey, FieldOfView, LoadedScene, Number, PackageSource, PlaceKey, Point, Scale, Scene, SceneCamera, SceneFile,
    SceneLight, SceneLook, SceneModel, SceneSequence, Whole,
};
#[cfg(feature = "draw")]
pub use stage::{Stage, TargetSettings, camera};
pub use toml_text::TomlText;
pub use track::{LEAST_STEP_S, Track, Value};
pub use viewpoint::{CameraTrack, Viewpoint};
