//! What an application puts on its entities.

use crate::model::PelageModel;
use bevy_asset::{AsAssetId, AssetId, Handle};
use bevy_camera::visibility::{self, NoFrustumCulling, Visibility, VisibilityClass};
use bevy_ecs::prelude::*;
use bevy_math::Mat4;
use bevy_transform::components::Transform;
use pelage_runtime::{Environment, FurParams, HairMotionParams, InkBackground, InkParams, ShadowParams, Style};

/// An animal: the model of a package, drawn in a style where the entity stands.
///
/// It is drawn by the cameras that see the entity: `Visibility` and `RenderLayers` are Bevy's. What lies outside of a camera's view is left
/// out by pelage itself, which knows the pose; hence `NoFrustumCulling`. The entity gets the `Aabb` of the model at rest when it is loaded.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility, VisibilityClass, NoFrustumCulling)]
#[component(on_add = visibility::add_visibility_class::<Pelage>)]
pub struct Pelage {
    /// What it is.
    pub model: Handle<PelageModel>,
    /// How it is drawn: fur, bare skin or ink, with the parameters of each. A look file becomes one by
    /// `pelage_stage::Look::frame_params().style`.
    pub style: Style,
}

impl Pelage {
    /// In fur as it is by default.
    pub fn fur(model: Handle<PelageModel>) -> Self {
        Self { model, style: Style::Fur(FurParams::default()) }
    }

    /// In ink, painted over what the camera saw before. With [`InkBackground::Paper`] in its parameters the sheet hides the background, but for
    /// what other things cover.
    pub fn ink(model: Handle<PelageModel>) -> Self {
        Self { model, style: ink() }
    }
}

/// Ink over Bevy's picture.
pub(crate) fn ink() -> Style {
    Style::Ink(InkParams::default().with(|ink| ink.background = InkBackground::Picture))
}

impl AsAssetId for Pelage {
    type Asset = PelageModel;

    fn as_asset_id(&self) -> AssetId<PelageModel> {
        self.model.id()
    }
}

/// A clip that plays: without it an animal rests.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(ClipPlace)]
pub struct PelageClip {
    /// Name of the clip, as [`PelageModel::clip`] finds it. Where the model has none of the name the log says so, and the animal rests.
    pub name: String,
    /// The moment of the clip, seconds. It moves on by itself; set it to seek.
    pub time_s: f32,
    /// Seconds of the clip in a second of Bevy's `Time` (default 1); below 0 it plays backwards.
    pub speed: f32,
    /// Whether it begins anew at its end (default true); else it holds there.
    pub looped: bool,
    /// Whether time stands still for it (default false).
    pub paused: bool,
}

impl PelageClip {
    /// The clip of that name from its beginning, over and over.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), time_s: 0.0, speed: 1.0, looped: true, paused: false }
    }
}

/// A pose of the application's own, in place of a clip: mesh space to model space, one matrix per joint of the package's skeleton.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageJoints(pub Vec<Mat4>);

/// Morph targets at weights of the application's own, by their names, whatever the clip does with them: a face that speaks, a blink.
///
/// Where the model has none of a name the log says so.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageMorphs(pub Vec<(String, f32)>);

/// A mesh that throws its shadow on fur: put it on entities with `Mesh3d` that may stand between a sun and an animal.
///
/// Fur has shadow maps of its own. Leave out grounds, on which Bevy's own maps show the animals' shadows: the maps' depth covers all that
/// reaches towards the sun, and things nearer to fur than a thousandth of that throw no shadow on it. Positions must be as `Mesh` has them by
/// default, uncompressed, and the mesh neither skinned nor morphed.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ShadesPelage;

/// How the shadow maps of fur are made, for all lights and cameras. `map_size` is that of one animal: where those of one style are spread out
/// in a picture, maps have up to four times as many texels a side.
#[derive(Resource, Clone, Debug, Default)]
pub struct PelageShadows(pub ShadowParams);

/// Light from all around for fur: the lights that a sky is taken for (`pelage sky` writes them), in place of ambient light. Bevy's own meshes have it as
/// `EnvironmentMapLight`; a sun in it is left to a `DirectionalLight`.
#[derive(Resource, Clone, Debug, Default)]
pub struct PelageEnvironment {
    /// `None` for ambient light alone.
    pub lights: Option<Environment>,
    /// Candela per square metre that a radiance of 1 stands for, as `EnvironmentMapLight::intensity`.
    pub intensity: f32,
}

/// What moves hair on guides, manes and tails: gravity and wind, for all animals (default gravity, and air that stands still). `None` leaves it as it was
/// groomed. Hair lives as Bevy's `Time` passes.
#[derive(Resource, Clone, Debug)]
pub struct PelageHair(pub Option<HairMotionParams>);

impl Default for PelageHair {
    fn default() -> Self {
        Self(Some(HairMotionParams::default()))
    }
}

/// What a [`PelageClip`] was found to be in the model of its entity.
#[derive(Component, Clone, Debug, Default)]
pub struct ClipPlace {
    /// Index and length in seconds.
    pub(crate) found: Option<(usize, f32)>,
}
