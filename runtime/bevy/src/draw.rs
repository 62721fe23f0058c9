//! Draws animals in Bevy's main pass: after opaque objects, before transparent ones.

use crate::casters::CasterDraws;
use crate::extract::{Animal, Scene};
use crate::lights::LampLight;
use crate::renderers::{Frames, PassKind, PassRenderer, PelageRenderers, PreparedFrame};
use crate::view::View;
use crate::{Pelage, bounds, lights};
use bevy_camera::visibility::RenderLayers;
use bevy_camera::{CompositingSpace, MainPassResolutionOverride};
use bevy_core_pipeline::core_3d::CORE_3D_DEPTH_FORMAT;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_render::camera::{ExtractedCamera, TemporalJitter};
use bevy_render::render_resource::{RenderPassDescriptor, StoreOp};
use bevy_render::renderer::{RenderContext, RenderQueue, ViewQuery};
use bevy_render::sync_world::MainEntity;
use bevy_render::view::{
    ExtractedView, Msaa, RenderVisibleEntities, ResolvedCompositingSpace, ViewDepthStencilTexture, ViewTarget,
};
use pelage_runtime::{FrameParams, Instance, Sphere, Style, StyleKind};

/// Components of a camera that are read to draw its animals.
type CameraParts = (
    &'static ExtractedCamera,
    &'static ExtractedView,
    &'static ViewTarget,
    &'static Msaa,
    &'static RenderVisibleEntities,
    Option<&'static ResolvedCompositingSpace>,
    Option<&'static RenderLayers>,
    Option<&'static TemporalJitter>,
    Option<&'static MainPassResolutionOverride>,
);

/// Animals of one style under the same light, farthest first.
struct Group<'a> {
    style: &'a Style,
    lamps: Vec<LampLight>,
    instances: Vec<Instance>,
}

/// Prepares a camera's frames. Records the commands that must run before the camera's main pass.
pub(crate) fn prepare(
    view: ViewQuery<CameraParts>,
    scene: Res<Scene>,
    mut renderers: ResMut<PelageRenderers>,
    mut frames: ResMut<Frames>,
    mut casters: CasterDraws,
    queue: Res<RenderQueue>,
    mut ctx: RenderContext,
) {
    let entity = view.entity();
    let (camera, extracted, target, msaa, visible, space, layers, jitter, main_size) = view.into_inner();
    let visible = visible.get::<Pelage>().map(|class| &class.entities_cpu_culling[..]).unwrap_or_default();
    let animals: Vec<(MainEntity, &Animal)> =
        visible.iter().filter_map(|(_, main)| Some((*main, scene.animals.get(main)?))).collect();
    if animals.is_empty() {
        return;
    }
    let main_entity = extracted.retained_view_entity.main_entity;
    if space.is_some_and(|space| space.0 == Some(CompositingSpace::Srgb)) {
        let message = format!(
            "camera {main_entity:?} composites in sRGB, which pelage does not support because fur is in linear light. \
             Its animals are not drawn; remove CompositingSpace::Srgb"
        );
        return renderers.warn(message);
    }
    if !camera.hdr {
        let message = format!(
            "camera {main_entity:?} has no Hdr: Bevy then applies exposure and tone mapping in its mesh shaders. The \
             fur shaders do neither, so fur comes out too bright beside meshes. Add bevy_camera::Hdr to the camera"
        );
        renderers.warn(message);
    }
    let kind = PassKind { color: target.main_texture_format(), depth: CORE_3D_DEPTH_FORMAT, samples: msaa.samples() };
    let device = ctx.render_device().clone();
    let Some(mut pass_renderer) = renderers.for_pass(kind, &device, &queue) else { return };
    let view = View::new(extracted, jitter, main_size.map(|size| **size));
    let layers = layers.cloned().unwrap_or_default();
    let ambient = scene.ambients.get(&main_entity).copied().unwrap_or(scene.ambient);
    let mut prepared = Vec::new();
    for group in groups(&mut pass_renderer, &scene, &view, &layers, animals) {
        let (camera_of_style, viewport) = view.camera_and_viewport(group.style.kind());
        let spheres: Vec<Sphere> = group.instances.iter().map(bounds::animal_bounds).collect();
        let params = FrameParams::new(camera_of_style, [viewport.z, viewport.w]).with(|params| {
            lights::set_lights(params, &scene.suns, &group.lamps, ambient, camera.exposure, &layers);
            params.environment = scene.environment.as_ref().map(|lights| lights.scaled(camera.exposure));
            params.shadows = bounds::enlarge_maps(scene.shadows, &spheres, device.limits().max_texture_dimension_2d);
            params.style = group.style.clone();
            scene.set_hair_motion(params);
        });
        let is_unlit = params.light.color() == Vec3::ZERO && params.environment.is_none();
        if scene.ignored_lights > 0 && is_unlit && group.style.kind() != StyleKind::Ink {
            let found = scene.ignored_lights;
            pass_renderer.log.warn(format!(
                "camera {main_entity:?} sees animals without a light: found {found} rectangular lights or environment \
                 maps of Bevy, which do not light fur. Add a DirectionalLight, PointLight or SpotLight, or insert \
                 PelageEnvironment"
            ));
        }
        let frame = casters.prepare(
            &mut pass_renderer,
            &scene,
            &device,
            ctx.command_encoder(),
            &params,
            &group.instances,
            &spheres,
        );
        prepared.extend(pass_renderer.or_log(frame).map(|frame| PreparedFrame { frame, viewport, part: view.rect }));
    }
    frames.0.insert(entity, prepared);
}

/// Groups the animals by style and by the light of lamps on them, because a frame of the runtime has one style and one
/// set of lights. Animals are sorted from far to near within a group, and groups by their farthest animal.
fn groups<'a>(
    pass_renderer: &mut PassRenderer,
    scene: &Scene,
    view: &View,
    layers: &RenderLayers,
    mut animals: Vec<(MainEntity, &'a Animal)>,
) -> Vec<Group<'a>> {
    let eye = view.eye();
    let distance = |animal: &Animal| animal.transform.w_axis.truncate().distance_squared(eye);
    animals.sort_by(|(a_is, a), (b_is, b)| distance(b).total_cmp(&distance(a)).then(a_is.cmp(b_is)));
    let mut groups: Vec<Group<'a>> = Vec::new();
    for (entity, animal) in animals {
        let Some(instance) = pass_renderer.instance(scene, entity, animal) else { continue };
        let lamps = lights::lamps_at(&scene.lamps, &scene.suns, layers, bounds::animal_bounds(&instance));
        match groups.iter_mut().find(|group| *group.style == animal.style && group.lamps == lamps) {
            Some(group) => group.instances.push(instance),
            None => groups.push(Group { style: &animal.style, lamps, instances: vec![instance] }),
        }
    }
    groups
}

/// Draws a camera's frames into its main pass.
pub(crate) fn draw(
    view: ViewQuery<(&ViewTarget, &ViewDepthStencilTexture)>,
    frames: Res<Frames>,
    mut ctx: RenderContext,
) {
    let Some(frames) = frames.0.get(&view.entity()).filter(|frames| !frames.is_empty()) else { return };
    let (target, depth) = view.into_inner();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("pelage"),
        color_attachments: &[Some(target.get_color_attachment())],
        depth_stencil_attachment: Some(depth.get_attachment(StoreOp::Store)),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    let pass = pass.wgpu_pass();
    for PreparedFrame { frame, viewport, part } in frames {
        let [x, y, width, height] = viewport.as_vec4().to_array();
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.set_scissor_rect(part.x, part.y, part.z, part.w);
        frame.draw(pass);
    }
}
