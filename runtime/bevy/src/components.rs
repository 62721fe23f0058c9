//! Components and resources that an application sets.

use crate::model::PelageModel;
use bevy_asset::{AsAssetId, AssetId, Handle};
use bevy_camera::visibility::{self, NoFrustumCulling, Visibility, VisibilityClass};
use bevy_ecs::prelude::*;
use bevy_math::Mat4;
use bevy_transform::components::Transform;
use pelage_runtime::{Environment, FurParams, HairMotionParams, InkBackground, InkParams, ShadowParams, Style};

/// An animal: the model of a package, drawn in a style with the entity's transform.
///
/// Cameras that see the entity draw it: `Visibility` and `RenderLayers` work as usual in Bevy. Pelage itself culls
/// animals outside of a camera's view, because it knows their pose; this requires `NoFrustumCulling`. When the model is
/// loaded, the entity gets the model's `Aabb` at rest.
#[derive(Component, Clone, Debug)]
#[require(Transform, Visibility, VisibilityClass, NoFrustumCulling)]
#[component(on_add = visibility::add_visibility_class::<Pelage>)]
pub struct Pelage {
    /// Model to draw.
    pub model: Handle<PelageModel>,
    /// Drawing style with its parameters: fur, bare or ink. `pelage_stage::Look::frame_params().style` converts a look
    /// file.
    pub style: Style,
}

impl Pelage {
    /// Creates an animal in the default fur style.
    pub fn fur(model: Handle<PelageModel>) -> Self {
        Self { model, style: Style::Fur(FurParams::default()) }
    }

    /// Creates an animal in ink, painted over the camera's picture. With [`InkBackground::Paper`] in the parameters,
    /// paper hides the background wherever no other object covers it.
    pub fn ink(model: Handle<PelageModel>) -> Self {
        Self { model, style: ink_style() }
    }
}

/// Returns the ink style that paints over Bevy's picture.
pub(crate) fn ink_style() -> Style {
    Style::Ink(InkParams::default().with(|ink| ink.background = InkBackground::Picture))
}

impl AsAssetId for Pelage {
    type Asset = PelageModel;

    fn as_asset_id(&self) -> AssetId<PelageModel> {
        self.model.id()
    }
}

/// Playback of a clip. An animal without this component stays at rest.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(ClipLookup)]
pub struct PelageClip {
    /// Name of the clip, as for [`PelageModel::clip`]. If the model has no such clip, a warning is logged and the
    /// animal stays at rest.
    pub name: String,
    /// Current time of the clip, seconds. Advances automatically; set it to seek.
    pub time_s: f32,
    /// Playback speed, seconds of the clip per second of Bevy's `Time` (default 1). A negative speed plays backwards.
    pub speed: f32,
    /// Whether the clip repeats (default true); otherwise it stops at its end.
    pub looped: bool,
    /// Whether playback is paused (default false).
    pub paused: bool,
}

impl PelageClip {
    /// Plays the named clip from its beginning, in a loop.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), time_s: 0.0, speed: 1.0, looped: true, paused: false }
    }
}

/// Pose set by the application instead of a clip. Contains one matrix per joint of the package's skeleton, from mesh
/// space to model space.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageJoints(pub Vec<Mat4>);

/// Morph target weights by name, set by the application; they override those of the clip. Use them for speech or
/// blinking, for example.
///
/// If the model has no target with a given name, an error is logged.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PelageMorphs(pub Vec<(String, f32)>);

/// Marker for a mesh that casts shadows on fur. Add it to entities with `Mesh3d` that may be between the key light and
/// an animal.
///
/// Fur has its own shadow maps. Do not mark grounds: they receive the animals' shadows through Bevy's own maps. The
/// depth range of the fur's maps includes all casters towards the light. If fur is closer to an object than a
/// thousandth of that range, the object casts no shadow on it. Positions must be in `Mesh`'s default format,
/// uncompressed. The mesh must be neither skinned nor morphed.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct PelageShadowCaster;

/// Settings of the fur's shadow maps, for all lights and cameras. `map_size` is the size for one animal. If animals of
/// the same style are spread out in a picture, their maps have up to four times as many texels per side.
#[derive(Resource, Clone, Debug, Default)]
pub struct PelageShadows(pub ShadowParams);

/// Environment light on fur, which replaces ambient light: the lights fitted to an environment map (written by `pelage
/// sky`). For Bevy's own meshes use `EnvironmentMapLight`. Represent a sun in the map by a `DirectionalLight`.
#[derive(Resource, Clone, Debug)]
pub struct PelageEnvironment {
    /// Fitted lights; `None` for ambient light alone.
    pub lights: Option<Environment>,
    /// Luminance of a radiance of 1, candela per square metre, like `EnvironmentMapLight::intensity`. The default of
    /// 1000 is about full light at Bevy's default exposure.
    pub intensity: f32,
}

impl Default for PelageEnvironment {
    fn default() -> Self {
        Self { lights: None, intensity: 1000.0 }
    }
}

/// Gravity and wind that move fur and guide hair (manes, tails), for all animals. The default is gravity in still air.
/// `None` keeps hair as groomed. Hair moves with Bevy's `Time`.
#[derive(Resource, Clone, Debug)]
pub struct PelageHair(pub Option<HairMotionParams>);

impl Default for PelageHair {
    fn default() -> Self {
        Self(Some(HairMotionParams::default()))
    }
}

/// Result of looking up a [`PelageClip`] in the model of its entity.
#[derive(Component, Clone, Debug, Default)]
pub struct ClipLookup {
    /// Index and length in seconds; `None` if not found.
    pub(crate) found: Option<(usize, f32)>,
}
