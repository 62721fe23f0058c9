//! Data that is extracted from the main world to the render world each frame.

use crate::components::{
    ClipLookup, Pelage, PelageClip, PelageEnvironment, PelageHair, PelageJoints, PelageMorphs, PelageShadowCaster,
    PelageShadows,
};
use crate::lights::{Ambient, Lamp, Sun};
use crate::model::PelageModel;
use bevy_asset::{AssetEvent, AssetId, Assets};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{InheritedVisibility, RenderLayers};
use bevy_ecs::prelude::*;
use bevy_light::{
    AmbientLight, DirectionalLight, EnvironmentMapLight, GlobalAmbientLight, NotShadowCaster, PointLight, RectLight,
    SpotLight,
};
use bevy_math::Mat4;
use bevy_mesh::{Mesh, Mesh3d};
use bevy_render::Extract;
use bevy_render::sync_world::MainEntity;
use bevy_time::Time;
use bevy_transform::components::GlobalTransform;
use pelage_runtime::{Environment, FrameParams, HairMotionParams, Motion, ShadowParams, Sphere, Style};
use pelage_stage::NamedPackage;
use std::collections::HashMap;
use std::sync::Arc;

/// An animal in the render world.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "pbr"), allow(dead_code, reason = "only bevy_pbr has the shadow maps that it casts into"))]
pub(crate) struct Animal {
    pub(crate) model: AssetId<PelageModel>,
    pub(crate) transform: Mat4,
    pub(crate) motion: Motion,
    pub(crate) morphs: PelageMorphs,
    pub(crate) style: Style,
    pub(crate) casts_shadow: bool,
    pub(crate) layers: RenderLayers,
}

/// A Bevy mesh that casts shadows on fur.
#[derive(Clone, Debug)]
pub(crate) struct Caster {
    pub(crate) mesh: AssetId<Mesh>,
    pub(crate) transform: Mat4,
    /// Bounding sphere in world space.
    pub(crate) bounds: Sphere,
}

/// Extracted data from which all frames are drawn.
#[derive(Resource, Debug, Default)]
pub(crate) struct Scene {
    pub(crate) animals: HashMap<MainEntity, Animal>,
    pub(crate) packages: HashMap<AssetId<PelageModel>, Arc<NamedPackage<'static>>>,
    pub(crate) suns: Vec<Sun>,
    pub(crate) lamps: Vec<Lamp>,
    /// Number of rectangular lights and environment maps of Bevy, which do not light fur.
    pub(crate) ignored_lights: usize,
    /// Ambient light of cameras without their own.
    pub(crate) ambient: Ambient,
    /// Environment lights, candela per square metre.
    pub(crate) environment: Option<Environment>,
    /// Ambient light of cameras that have their own, by their entity in the main world.
    pub(crate) ambients: HashMap<MainEntity, Ambient>,
    pub(crate) shadows: ShadowParams,
    pub(crate) hair_motion: Option<HairMotionParams>,
    /// Time of Bevy's clock, seconds.
    pub(crate) time_s: f64,
    pub(crate) casters: Vec<Caster>,
    /// Revision; incremented when a mesh is modified in place.
    pub(crate) meshes_changed: u64,
}

impl Scene {
    /// Copies the parameters of hair motion and the current time from the scene to `params`.
    pub(crate) fn set_hair_motion(&self, params: &mut FrameParams) {
        (params.time_s, params.hair_motion) = (self.time_s, self.hair_motion);
    }
}

/// Returns the pose of an animal.
fn motion(clip: Option<(&PelageClip, &ClipLookup)>, joints: Option<&PelageJoints>) -> Motion {
    match (joints, clip) {
        (Some(joints), _) => Motion::Joints(joints.0.clone()),
        (None, Some((clip, ClipLookup { found: Some((index, _)) }))) => {
            Motion::Clip { clip: *index, time_s: clip.time_s }
        }
        _ => Motion::Rest,
    }
}

/// Components from which an animal is extracted.
type AnimalParts = (
    Entity,
    &'static Pelage,
    &'static GlobalTransform,
    &'static InheritedVisibility,
    Option<(&'static PelageClip, &'static ClipLookup)>,
    (Option<&'static PelageJoints>, Option<&'static PelageMorphs>),
    Option<&'static RenderLayers>,
    Has<NotShadowCaster>,
);

/// Extracts the animals and their packages.
pub(crate) fn animals(
    mut scene: ResMut<Scene>,
    animals: Extract<Query<AnimalParts>>,
    models: Extract<Res<Assets<PelageModel>>>,
) {
    scene.animals.clear();
    scene.animals.extend(animals.iter().map(
        |(entity, pelage, transform, visible, clip, (joints, morphs), layers, dark)| {
            let animal = Animal {
                model: pelage.model.id(),
                transform: transform.to_matrix(),
                motion: motion(clip, joints),
                morphs: morphs.cloned().unwrap_or_default(),
                style: pelage.style.clone(),
                casts_shadow: visible.get() && !dark,
                layers: layers.cloned().unwrap_or_default(),
            };
            (MainEntity::from(entity), animal)
        },
    ));
    scene.packages.clear();
    scene.packages.extend(models.iter().map(|(id, model)| (id, model.package.clone())));
}

type LightPlace = (&'static GlobalTransform, &'static InheritedVisibility, Option<&'static RenderLayers>);

/// Extracts the lights and the shadow settings.
pub(crate) fn lights(
    mut scene: ResMut<Scene>,
    suns: Extract<Query<(&DirectionalLight, LightPlace)>>,
    points: Extract<Query<(&PointLight, LightPlace)>>,
    spots: Extract<Query<(&SpotLight, LightPlace)>>,
    ignored: Extract<Query<(), Or<(With<RectLight>, With<EnvironmentMapLight>)>>>,
    ambients: Extract<Query<(Entity, &AmbientLight)>>,
    ambient: Extract<Option<Res<GlobalAmbientLight>>>,
    shadows: Extract<Res<PelageShadows>>,
) {
    scene.suns.clear();
    let lit = suns.iter().filter(|(_, (_, visible, _))| visible.get());
    scene.suns.extend(lit.map(|(light, (transform, _, layers))| Sun {
        towards_light: transform.back().into(),
        color: light.color.to_linear(),
        illuminance: light.illuminance,
        shadows: light.shadow_maps_enabled,
        layers: layers.cloned().unwrap_or_default(),
    }));
    let points = points.iter().map(|(light, place)| (*light, place, None));
    let spots = spots.iter().map(|(spot, place)| {
        let SpotLight { color, intensity, range, shadow_maps_enabled, .. } = *spot;
        let light = PointLight { color, intensity, range, shadow_maps_enabled, ..PointLight::default() };
        (light, place, Some((place.0.forward().into(), spot.inner_angle, spot.outer_angle)))
    });
    let lamps = points.chain(spots).filter(|(_, (_, visible, _), _)| visible.get());
    scene.lamps.clear();
    scene.lamps.extend(lamps.map(|(light, (transform, _, layers), cone)| Lamp {
        position: transform.translation(),
        color: light.color.to_linear(),
        power: light.intensity,
        range_m: light.range,
        cone,
        shadows: light.shadow_maps_enabled,
        layers: layers.cloned().unwrap_or_default(),
    }));
    scene.ignored_lights = ignored.iter().count();
    scene.ambient = ambient.as_ref().map(|a| Ambient::new(a.color.to_linear(), a.brightness)).unwrap_or_default();
    scene.ambients.clear();
    let own = |(entity, a): (Entity, &AmbientLight)| {
        (MainEntity::from(entity), Ambient::new(a.color.to_linear(), a.brightness))
    };
    scene.ambients.extend(ambients.iter().map(own));
    scene.shadows = shadows.0;
}

pub(crate) fn hair(mut scene: ResMut<Scene>, hair: Extract<Res<PelageHair>>, time: Extract<Res<Time>>) {
    (scene.hair_motion, scene.time_s) = (hair.0, time.elapsed_secs_f64());
}

/// Extracts the environment lights, in candela per square metre.
pub(crate) fn environment(mut scene: ResMut<Scene>, environment: Extract<Res<PelageEnvironment>>) {
    if environment.is_changed() {
        scene.environment = environment.lights.as_ref().map(|lights| lights.scaled(environment.intensity));
    }
}

/// Extracts the meshes that cast shadows on fur.
pub(crate) fn casters(
    mut scene: ResMut<Scene>,
    casters: Extract<Query<(Entity, &Mesh3d, &GlobalTransform, &InheritedVisibility, &Aabb), With<PelageShadowCaster>>>,
    mut changes: Extract<MessageReader<AssetEvent<Mesh>>>,
) {
    let mut visible: Vec<_> = casters.iter().filter(|(_, _, _, visible, _)| visible.get()).collect();
    // The order of a query may change although nothing has moved.
    visible.sort_by_key(|(entity, ..)| *entity);
    scene.casters.clear();
    scene.casters.extend(visible.iter().map(|(_, mesh, transform, _, bounds)| Caster {
        mesh: mesh.id(),
        transform: transform.to_matrix(),
        bounds: Sphere {
            center: transform.transform_point(bounds.center.into()),
            radius: transform.radius_vec3a(bounds.half_extents),
        },
    }));
    let changed = changes.read().filter(|change| matches!(change, AssetEvent::Modified { .. })).count();
    scene.meshes_changed += changed as u64;
}
