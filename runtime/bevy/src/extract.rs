//! What the render world sees of the main world in a frame: plain data.

use crate::components::{
    ClipPlace, Pelage, PelageClip, PelageEnvironment, PelageHair, PelageJoints, PelageMorphs, PelageShadows,
    ShadesPelage,
};
use crate::lights::{Ambient, Sun};
use crate::model::PelageModel;
use bevy_asset::{AssetEvent, AssetId, Assets};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{InheritedVisibility, RenderLayers};
use bevy_ecs::prelude::*;
use bevy_light::{AmbientLight, DirectionalLight, GlobalAmbientLight, NotShadowCaster};
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

/// An animal.
#[derive(Clone, Debug)]
#[cfg_attr(not(feature = "pbr"), allow(dead_code, reason = "the shadow maps that it throws shadows in are bevy_pbr's"))]
pub(crate) struct Animal {
    pub(crate) model: AssetId<PelageModel>,
    pub(crate) transform: Mat4,
    pub(crate) motion: Motion,
    pub(crate) morphs: PelageMorphs,
    pub(crate) style: Style,
    /// Whether it throws a shadow on Bevy's meshes.
    pub(crate) throws_shadow: bool,
    pub(crate) layers: RenderLayers,
}

/// A mesh of Bevy's that throws its shadow on fur.
#[derive(Clone, Debug)]
pub(crate) struct Caster {
    pub(crate) mesh: AssetId<Mesh>,
    pub(crate) transform: Mat4,
    /// What holds it.
    pub(crate) bounds: Sphere,
}

/// All that is drawn from.
#[derive(Resource, Debug, Default)]
pub(crate) struct Scene {
    /// By the entity in the main world.
    pub(crate) animals: HashMap<MainEntity, Animal>,
    /// Packages of all models that are loaded.
    pub(crate) packages: HashMap<AssetId<PelageModel>, Arc<NamedPackage<'static>>>,
    pub(crate) suns: Vec<Sun>,
    /// For cameras that have none of their own.
    pub(crate) ambient: Ambient,
    /// Candela per square metre.
    pub(crate) environment: Option<Environment>,
    /// Of cameras that have one, by the entity in the main world.
    pub(crate) ambients: HashMap<MainEntity, Ambient>,
    pub(crate) shadows: ShadowParams,
    pub(crate) hair_motion: Option<HairMotionParams>,
    /// Of Bevy's clock, seconds.
    pub(crate) time_s: f64,
    pub(crate) casters: Vec<Caster>,
    /// Another number whenever a mesh was changed in place.
    pub(crate) meshes_changed: u64,
}

impl Scene {
    /// Has hair live to the moment of the scene.
    pub(crate) fn move_hair(&self, params: &mut FrameParams) {
        (params.time_s, params.hair_motion) = (self.time_s, self.hair_motion);
    }
}

/// How an animal is posed.
fn motion(clip: Option<(&PelageClip, &ClipPlace)>, joints: Option<&PelageJoints>) -> Motion {
    match (joints, clip) {
        (Some(joints), _) => Motion::Joints(joints.0.clone()),
        (None, Some((clip, ClipPlace { found: Some((index, _)) }))) => {
            Motion::Clip { clip: *index, time_s: clip.time_s }
        }
        _ => Motion::Rest,
    }
}

/// What an animal is extracted from.
type AnimalParts = (
    Entity,
    &'static Pelage,
    &'static GlobalTransform,
    &'static InheritedVisibility,
    Option<(&'static PelageClip, &'static ClipPlace)>,
    (Option<&'static PelageJoints>, Option<&'static PelageMorphs>),
    Option<&'static RenderLayers>,
    Has<NotShadowCaster>,
);

/// The animals and their packages.
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
                throws_shadow: visible.get() && !dark,
                layers: layers.cloned().unwrap_or_default(),
            };
            (MainEntity::from(entity), animal)
        },
    ));
    scene.packages.clear();
    scene.packages.extend(models.iter().map(|(id, model)| (id, model.package.clone())));
}

/// The lights.
pub(crate) fn lights(
    mut scene: ResMut<Scene>,
    suns: Extract<Query<(&DirectionalLight, &GlobalTransform, &InheritedVisibility, Option<&RenderLayers>)>>,
    ambients: Extract<Query<(Entity, &AmbientLight)>>,
    ambient: Extract<Option<Res<GlobalAmbientLight>>>,
    shadows: Extract<Res<PelageShadows>>,
) {
    scene.suns.clear();
    let lit = suns.iter().filter(|(_, _, visible, _)| visible.get());
    scene.suns.extend(lit.map(|(light, transform, _, layers)| Sun {
        towards_light: transform.back().into(),
        color: light.color.to_linear(),
        illuminance: light.illuminance,
        shadows: light.shadow_maps_enabled,
        layers: layers.cloned().unwrap_or_default(),
    }));
    scene.ambient = ambient.as_ref().map(|a| Ambient::new(a.color.to_linear(), a.brightness)).unwrap_or_default();
    scene.ambients.clear();
    let own = |(entity, a): (Entity, &AmbientLight)| {
        (MainEntity::from(entity), Ambient::new(a.color.to_linear(), a.brightness))
    };
    scene.ambients.extend(ambients.iter().map(own));
    scene.shadows = shadows.0;
}

/// What moves hair, and the moment.
pub(crate) fn hair(mut scene: ResMut<Scene>, hair: Extract<Res<PelageHair>>, time: Extract<Res<Time>>) {
    (scene.hair_motion, scene.time_s) = (hair.0, time.elapsed_secs_f64());
}

/// Light from all around, in candela per square metre.
pub(crate) fn environment(mut scene: ResMut<Scene>, environment: Extract<Res<PelageEnvironment>>) {
    if environment.is_changed() {
        scene.environment = environment.lights.as_ref().map(|lights| lights.times(environment.intensity));
    }
}

/// The meshes that throw shadows on fur.
pub(crate) fn casters(
    mut scene: ResMut<Scene>,
    casters: Extract<Query<(Entity, &Mesh3d, &GlobalTransform, &InheritedVisibility, &Aabb), With<ShadesPelage>>>,
    mut changes: Extract<MessageReader<AssetEvent<Mesh>>>,
) {
    let mut visible: Vec<_> = casters.iter().filter(|(_, _, _, visible, _)| visible.get()).collect();
    // The order of a query may change without anything having moved.
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
