//! Components and resources that an application sets.

use crate::model::PelageModel;
use bevy_asset::{AsAssetId, AssetId, Handle};
use bevy_camera::visibility::{self, NoFrustumCulling, Visibility, VisibilityClass};
use bevy_ecs::prelude::*;
use bevy_math::Mat4;
use bevy_transform::components::Transform;
use pelage_runtime::{Environment, FurParams, HairMotionParams, InkBackground, InkParams, ShadowParams, Style};

/// An animal: the model of a package, drawn in a style at the entity's transform.
///
/// Cameras that see the entity draw it: `Visibility` and `RenderLayers` work as usual in Bevy. Pelage itself culls
/// animals outside of a camera's view, because it knows the pose; hence `NoFrustumCulling`. When the model is loaded,
/// the entity gets the model's `Aabb` at rest.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility, VisibilityClass, NoFrustumCulling)]
#[component(on_add = visibility::add_visibility_class::<Pelage>)]
pub struct Pelage {
    /// Model to draw.
    pub model: Handle<PelageModel>,
    /// Drawing style: fur, bare or ink, with the parameters of each. A look file is converted by
    /// `pelage_stage::Look::frame_params().style`.
    pub style: Style,
}

impl Pelage {
    /// Creates an animal in the default fur style.
    pub fn fur(model: Handle<PelageModel>) -> Self {
        Self { model, style: Style::Fur(FurParams::default()) }
    }

    /// Creates an animal in ink, painted over the camera's picture. With [`InkBackground::Paper`] in its parameters,
    /// paper hides the background where no other object covers it.
    pub fn ink(model: Handle<PelageModel>) -> Self {
        Self { model, style: ink() }
    }
}

/// Returns the ink style that paints over Bevy's picture.
pub(crate) fn ink() -> Style {
    Style::Ink(InkParams::default().with(|ink| ink.background = InkBackground::Picture))
}

impl AsAssetId for Pelage {
    type Asset = PelageModel;

    fn as_asset_id(&self) -> AssetId<PelageModel> {
        self.model.id()
    }
}

/// Playback of a clip; without it an animal stays at rest.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(ClipPlace)]
pub struct PelageClip {
    /// Name of the clip, as for [`PelageModel::clip`]. If the model has no such clip, a warning is logged and the
    /// animal stays at rest.
    pub name: String,
    /// Current time of the clip, seconds. Advances by itself; set it to seek.
    pub time_s: f32,
    /// Playback speed, clip seconds per second of Bevy's `Time` (default 1); negative plays backwards.
    pub speed: f32,
    /// Whether the clip repeats (default true); else it stops at its end.
    pub looped: bool,
    /// Whether playback is paused (default false).
    pub paused: bool,
}

impl PelageClip {
    /// Plays the clip of that name from its beginning, in a loop.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), time_s: 0.0, speed: 1.0, looped: true, paused: false }
    }
}

/// Pose set by the application, in place of a clip: one matrix per joint of the package's skeleton, from mesh space to
/// model space.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageJoints(pub Vec<Mat4>);

/// Morph target weights by name, set by the application; they override those of the clip. Examples: a speaking face, a
/// blink.
///
/// If the model has no target of a name, an error is logged.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageMorphs(pub Vec<(String, f32)>);

/// Marker for a mesh that casts shadows on fur: add it to entities with `Mesh3d` that may be between a sun and an
/// animal.
///
/// Fur has shadow maps of its own. Do not mark grounds; Bevy's own maps show the animals' shadows on them. The depth of
/// the maps covers all casters towards the sun; objects nearer to fur than a thousandth of that cast no shadow on it.
/// Positions must be in `Mesh`'s default format, uncompressed, and the mesh neither skinned nor morphed.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ShadesPelage;

/// Settings of the fur's shadow maps, for all lights and cameras. `map_size` is that of one animal: if those of one
/// style are spread out in a picture, maps have up to four times as many texels per side.
#[derive(Resource, Clone, Debug, Default)]
pub struct PelageShadows(pub ShadowParams);

/// Environment light on fur, in place of ambient light: the lights fitted to an environment map (written by `pelage
/// sky`). For Bevy's own meshes use `EnvironmentMapLight`; represent a sun in it by a `DirectionalLight`.
#[derive(Resource, Clone, Debug, Default)]
pub struct PelageEnvironment {
    /// Fitted lights; `None` for ambient light alone.
    pub lights: Option<Environment>,
    /// Luminance for a radiance of 1, candela per square metre, as `EnvironmentMapLight::intensity`.
    pub intensity: f32,
}

/// Gravity and wind that move fur and guide hair such as manes and tails, for all animals (default gravity, and still
/// air). `None` keeps hair as groomed. Hair moves with Bevy's `Time`.
#[derive(Resource, Clone, Debug)]
pub struct PelageHair(pub Option<HairMotionParams>);

impl Default for PelageHair {
    fn default() -> Self {
        Self(Some(HairMotionParams::default()))
    }
}

/// Result of looking up a [`PelageClip`] in the model of its entity.
#[derive(Component, Clone, Debug, Default)]
pub struct ClipPlace {
    /// Index and length in seconds; `None` if not found.
    pub(crate) found: Option<(usize, f32)>,
}
