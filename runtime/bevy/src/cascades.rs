//! Draws animals into the shadow maps of Bevy's directional lights, so that Bevy's meshes receive their shadows.
//!
//! Bevy draws one map for each cascade of a directional light and camera. The animals are then drawn into the same map,
//! as fur seen from the light. The runtime's passes need a colour target; here it is a texture that is never read.

use crate::bounds;
use crate::extract::{Animal, Scene};
use crate::renderers::{Frames, PassKind, PassRenderer, PelageRenderers, PreparedFrame};
use bevy_app::SubApp;
use bevy_camera::visibility::RenderLayers;
use bevy_core_pipeline::Core3d;
use bevy_core_pipeline::core_3d::{CORE_3D_DEPTH_FORMAT, main_opaque_pass_3d};
use bevy_ecs::prelude::*;
use bevy_math::{Mat4, UVec4, Vec3};
use bevy_pbr::{LATE_SHADOW_PASS, LightEntity, ShadowView, ViewLightEntities, per_view_shadow_pass};
use bevy_render::GpuResourceAppExt as _;
use bevy_render::render_resource::{RenderPassDescriptor, StoreOp, TextureFormat};
use bevy_render::renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery};
use bevy_render::view::ExtractedView;
use pelage_runtime::{
    Camera, Detail, FrameParams, FurParams, HairGeometry, Instance, Light, Projection, SelfShadow, Style, StyleKind,
    wgpu,
};

/// Format of the unused colour target, one byte per texel.
const COLOR_FORMAT: TextureFormat = TextureFormat::R8Unorm;

/// Fraction of the map's depth range to which animals in front of the first plane are compressed.
const COMPRESSED_DEPTH: f32 = 1e-3;

/// Unused colour target of the maps.
#[derive(Resource, Debug, Default)]
struct UnusedColorTarget(Option<wgpu::Texture>);

pub(crate) fn build(render_app: &mut SubApp) {
    render_app.init_gpu_resource::<UnusedColorTarget>().add_systems(
        Core3d,
        draw_shadows
            .after(per_view_shadow_pass::<LATE_SHADOW_PASS>)
            .before(crate::draw::prepare)
            .before(main_opaque_pass_3d),
    );
}

/// Draws the animals into the shadow cascades of a camera.
fn draw_shadows(
    view: ViewQuery<&ViewLightEntities>,
    cascades: Query<(&ShadowView, &ExtractedView, &LightEntity)>,
    light_layers: Query<&RenderLayers>,
    scene: Res<Scene>,
    mut renderers: ResMut<PelageRenderers>,
    mut frames: ResMut<Frames>,
    mut color_target: ResMut<UnusedColorTarget>,
    queue: Res<RenderQueue>,
    mut ctx: RenderContext,
) {
    let lights = view.into_inner();
    if lights.lights.is_empty() || scene.animals.is_empty() {
        return;
    }
    let device = ctx.render_device().clone();
    let kind = PassKind { color: COLOR_FORMAT, depth: CORE_3D_DEPTH_FORMAT, samples: 1 };
    let Some(mut pass_renderer) = renderers.for_pass(kind, &device, &queue) else { return };
    for entity in lights.lights.iter().copied() {
        let Ok((map, cascade, LightEntity::Directional { light_entity, .. })) = cascades.get(entity) else { continue };
        let layers = light_layers.get(*light_entity).cloned().unwrap_or_default();
        let prepared = prepare(&mut pass_renderer, &scene, &layers, cascade, ctx.command_encoder());
        if prepared.is_empty() {
            continue;
        }
        let color = color_target.view(&device, cascade.viewport);
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("pelage cascade"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Discard },
            })],
            depth_stencil_attachment: Some(map.depth_attachment.get_attachment(StoreOp::Store)),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        prepared.iter().for_each(|prepared| prepared.frame.draw(pass.wgpu_pass()));
        drop(pass);
        frames.0.insert(entity, prepared);
    }
}

/// Prepares frames of the animals that cast shadows, as seen by a cascade.
fn prepare(
    pass_renderer: &mut PassRenderer,
    scene: &Scene,
    layers: &RenderLayers,
    cascade: &ExtractedView,
    encoder: &mut wgpu::CommandEncoder,
) -> Vec<PreparedFrame> {
    let mut prepared = Vec::new();
    for bare in [false, true] {
        let casts = |animal: &Animal| {
            animal.casts_shadow && animal.layers.intersects(layers) && (animal.style.kind() == StyleKind::Bare) == bare
        };
        let animals = scene.animals.iter().filter(|(_, animal)| casts(animal));
        let instances: Vec<Instance> =
            animals.filter_map(|(entity, animal)| pass_renderer.instance(scene, *entity, animal)).collect();
        if instances.is_empty() {
            continue;
        }
        let style = if bare { Style::Bare } else { Style::Fur(shadow_fur_params()) };
        for camera in cameras(cascade, &instances) {
            let params = FrameParams::new(camera, [cascade.viewport.z, cascade.viewport.w]).with(|params| {
                // If the light is black, the runtime draws no shadow map of its own.
                params.light = Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO };
                params.soft_shadow = false;
                params.style = style.clone();
                scene.set_hair_motion(params);
            });
            let frame = pass_renderer.renderer.prepare(encoder, &params, &instances);
            let frame =
                pass_renderer.or_log(frame).filter(|frame| frame.report().instances.iter().any(|i| i.in_picture));
            prepared.extend(frame.map(|frame| PreparedFrame {
                frame,
                viewport: cascade.viewport,
                part: cascade.viewport,
            }));
        }
    }
    prepared
}

/// Returns fur parameters for drawing into shadow maps. Fur is drawn as shells only, with as many layers as the map's
/// texels can resolve.
fn shadow_fur_params() -> FurParams {
    FurParams::default().with(|fur| {
        fur.detail = Detail::Auto { bias: 0.5 };
        fur.hair = HairGeometry::Shells;
        fur.fins = false;
        fur.self_shadow = SelfShadow::Off;
    })
}

/// Returns the cameras for a cascade's view of the animals.
///
/// A cascade's depth range begins where the camera's view does. Objects before it, nearer to the sun, also cast
/// shadows: Bevy clamps their depth to the first plane. For these objects a second camera is added, which sees nothing
/// else and compresses their depth.
fn cameras(cascade: &ExtractedView, instances: &[Instance]) -> Vec<Camera> {
    let world_from_view = cascade.world_from_view.to_matrix();
    let view_from_world = world_from_view.inverse();
    let nearest = instances.iter().map(|instance| extent_before_first_plane(view_from_world, instance));
    let nearest_m = nearest.reduce(f32::max).unwrap_or(0.0);
    let camera = |clip_from_view| Camera { view_from_world, projection: Projection::Custom(clip_from_view) };
    let mut cameras = vec![camera(cascade.clip_from_view)];
    if nearest_m > 0.0 {
        cameras.push(camera(compress_depth(cascade.clip_from_view, nearest_m)));
    }
    cameras
}

/// Returns how far an animal may extend in front of a cascade's first plane, metres. The plane is at z = 0 in view
/// space.
fn extent_before_first_plane(view_from_world: Mat4, instance: &Instance) -> f32 {
    let sphere = bounds::animal_bounds(instance);
    view_from_world.transform_point3(sphere.center).z + sphere.radius
}

/// Returns a cascade's projection for objects in front of its first plane. The depth is 1 at the plane and falls to 1 -
/// [`COMPRESSED_DEPTH`] at the distance `nearest_m` in front of it. Points behind the plane have a depth above 1 and
/// are clipped.
fn compress_depth(clip_from_view: Mat4, nearest_m: f32) -> Mat4 {
    let mut compressed = clip_from_view;
    compressed.z_axis.z = -COMPRESSED_DEPTH / nearest_m;
    compressed.w_axis.z = 1.0;
    compressed
}

impl UnusedColorTarget {
    /// Returns a view of a colour target of the map's size.
    fn view(&mut self, device: &RenderDevice, viewport: UVec4) -> wgpu::TextureView {
        let size = wgpu::Extent3d { width: viewport.z, height: viewport.w, depth_or_array_layers: 1 };
        let texture = self.0.take().filter(|texture| texture.size() == size).unwrap_or_else(|| {
            device.wgpu_device().create_texture(&wgpu::TextureDescriptor {
                label: Some("pelage cascade"),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: COLOR_FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        });
        self.0.insert(texture).create_view(&wgpu::TextureViewDescriptor::default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_math::Vec4;

    #[test]
    fn objects_before_the_near_plane_are_compressed_into_range() {
        // A projection like Bevy's: depth 1 at z = 0, depth 0 at ten metres behind.
        let clip_from_view = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::Z * 0.1, Vec4::new(0.0, 0.0, 1.0, 1.0));
        let compressed = compress_depth(clip_from_view, 4.0);
        let depth = |matrix: Mat4, z: f32| (matrix * Vec4::new(0.3, 0.2, z, 1.0)).z;
        assert_eq!(depth(clip_from_view, -5.0), 0.5);
        assert!(depth(compressed, -0.01) > 1.0, "points behind the plane are clipped");
        for z in [0.0, 1.0, 3.9] {
            let found = depth(compressed, z);
            assert!((1.0 - COMPRESSED_DEPTH..=1.0).contains(&found), "{z} m before the plane: {found}");
        }
    }
}
