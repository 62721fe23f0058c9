//! Test harness: a Bevy app without a window, whose cameras draw into images that are read back.

use crate::sphere::{self, SphereParams};
use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle, RenderAssetUsages};
use bevy_camera::{Camera3d, CameraPlugin, ClearColor, Hdr, PerspectiveProjection, Projection, RenderTarget};
use bevy_color::Color;
use bevy_core_pipeline::CorePipelinePlugin;
use bevy_core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_image::{Image, ImagePlugin};
use bevy_light::{DirectionalLight, DirectionalLightShadowMap, GlobalAmbientLight, LightPlugin};
use bevy_math::Vec3;
use bevy_mesh::{Mesh, Mesh3d, MeshPlugin};
use bevy_pbr::{MeshMaterial3d, PbrPlugin, StandardMaterial};
use bevy_pelage::{PelageModel, PelagePlugin, PelageRenderers};
use bevy_render::gpu_readback::{Readback, ReadbackComplete};
use bevy_render::render_resource::TextureFormat;
use bevy_render::renderer::RenderAdapterInfo;
use bevy_render::view::Msaa;
use bevy_render::{RenderApp, RenderPlugin};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use bevy_window::WindowPlugin;
use pelage_needs::{Need, gpu_is_wanted, log_available};
use std::time::Duration;

/// A picture's pixels, RGBA bytes, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub size: [u32; 2],
    pub rgba: Vec<u8>,
}

impl Picture {
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 4] {
        let at = 4 * (y * self.size[0] + x) as usize;
        self.rgba[at..at + 4].try_into().unwrap()
    }

    pub fn pixels(&self) -> impl Iterator<Item = [u8; 4]> + '_ {
        self.rgba.chunks_exact(4).map(|p| p.try_into().unwrap())
    }

    /// Returns the mean and maximum difference of the colours, in 255ths.
    pub fn differences(&self, other: &Self) -> (f64, u8) {
        assert_eq!(self.size, other.size);
        let pairs = self.pixels().zip(other.pixels());
        let each = pairs.flat_map(|(a, b)| [0, 1, 2].map(|i| a[i].abs_diff(b[i])));
        let (sum, most) = each.fold((0u64, 0), |(sum, most), d| (sum + u64::from(d), most.max(d)));
        (sum as f64 / f64::from(3 * self.size[0] * self.size[1]), most)
    }

    /// Returns the rectangle of the picture with the given upper left corner and size, pixels.
    pub fn crop(&self, [left, top]: [u32; 2], size: [u32; 2]) -> Self {
        let rows = (0..size[1]).flat_map(|y| (0..size[0]).flat_map(move |x| self.pixel(left + x, top + y)));
        Self { size, rgba: rows.collect() }
    }
}

/// Test app without a window.
pub struct TestApp {
    pub app: App,
}

/// Pictures that were read back, by the entity of the `Readback`.
#[derive(Resource, Default)]
struct ReadbackData(std::collections::HashMap<Entity, Vec<u8>>);

/// A test camera: its entity and its image with size.
#[derive(Clone)]
pub struct TestCamera {
    pub entity: Entity,
    pub image: Handle<Image>,
    pub size: [u32; 2],
}

/// Returns a test app for the GPU test named `test`. `None`, with a message, if GPU tests are disabled.
pub fn gpu(test: &str) -> Option<TestApp> {
    if !gpu_is_wanted(test) {
        return None;
    }
    let test_app = TestApp::new();
    log_available(Need::Gpu, test, &test_app.render_world().resource::<RenderAdapterInfo>().name);
    Some(test_app)
}

impl TestApp {
    /// Creates an app with all plugins that Bevy needs to draw meshes. Only tests advance its time.
    pub fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((
            TaskPoolPlugin::default(),
            FrameCountPlugin,
            TimePlugin,
            TransformPlugin,
            bevy_diagnostic::DiagnosticsPlugin,
            AssetPlugin {
                file_path: "/".into(),
                unapproved_path_mode: bevy_asset::UnapprovedPathMode::Allow,
                ..Default::default()
            },
            WindowPlugin {
                primary_window: None,
                exit_condition: bevy_window::ExitCondition::DontExit,
                ..Default::default()
            },
        ))
        .add_plugins((
            RenderPlugin { synchronous_pipeline_compilation: true, ..Default::default() },
            ImagePlugin::default(),
            MeshPlugin,
            CameraPlugin,
            LightPlugin,
            CorePipelinePlugin,
            PbrPlugin::default(),
            PelagePlugin::default(),
        ))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::ZERO))
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight::NONE)
        .insert_resource(DirectionalLightShadowMap { size: 512 })
        .init_resource::<ReadbackData>();
        app.finish();
        app.cleanup();
        Self { app }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// Returns pelage's state in the render world.
    pub fn renderers(&self) -> &PelageRenderers {
        self.render_world().resource()
    }

    pub fn render_world(&self) -> &World {
        self.app.sub_app(RenderApp).world()
    }

    /// Despawns the entities.
    pub fn remove<const N: usize>(&mut self, entities: [Entity; N]) {
        for entity in entities {
            assert!(self.world().despawn(entity), "{entity} is there");
        }
    }

    /// Advances time by `seconds` in one frame.
    pub fn advance(&mut self, seconds: f32) {
        *self.world().resource_mut() = TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(seconds));
        self.app.update();
        *self.world().resource_mut() = TimeUpdateStrategy::ManualDuration(Duration::ZERO);
    }

    /// Adds a model, made from the bytes of a package, to the assets.
    pub fn add_model(&mut self, name: &str, bytes: &[u8]) -> Handle<PelageModel> {
        let model = PelageModel::from_bytes(name, bytes.to_vec()).unwrap();
        self.world().resource_mut::<Assets<PelageModel>>().add(model)
    }

    /// Spawns a camera that draws to its own image, without tone mapping.
    pub fn spawn_camera(&mut self, size: [u32; 2], msaa: Msaa, place: Transform) -> TestCamera {
        let mut image = Image::new_target_texture(size[0], size[1], TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= bevy_render::render_resource::TextureUsages::COPY_SRC;
        image.asset_usage = RenderAssetUsages::RENDER_WORLD;
        let image = self.world().resource_mut::<Assets<Image>>().add(image);
        let projection =
            PerspectiveProjection { fov: 0.6, aspect_ratio: size[0] as f32 / size[1] as f32, ..Default::default() };
        let entity = self
            .world()
            .spawn((
                Camera3d::default(),
                Hdr,
                RenderTarget::from(image.clone()),
                Projection::Perspective(projection),
                Tonemapping::None,
                DebandDither::Disabled,
                msaa,
                place,
            ))
            .id();
        TestCamera { entity, image, size }
    }

    /// Spawns a sun of full light that shines from the direction `from`.
    pub fn spawn_sun(&mut self, from: Vec3, shadows: bool) -> Entity {
        let full = std::f32::consts::PI / bevy_camera::Exposure::default().exposure();
        let light = DirectionalLight { illuminance: full, shadow_maps_enabled: shadows, ..Default::default() };
        self.world().spawn((light, Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y))).id()
    }

    /// Spawns a Bevy cuboid.
    pub fn spawn_cuboid(&mut self, size: Vec3, at: Vec3, color: Color) -> Entity {
        let mesh = Mesh::from(bevy_shape::Cuboid::from_size(size));
        let mesh = self.world().resource_mut::<Assets<Mesh>>().add(mesh);
        let material =
            StandardMaterial { base_color: color, perceptual_roughness: 1.0, reflectance: 0.0, ..Default::default() };
        let material = self.world().resource_mut::<Assets<StandardMaterial>>().add(material);
        self.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), Transform::from_translation(at))).id()
    }

    /// Returns the picture of a camera after all requested assets and pipelines are ready.
    pub fn picture(&mut self, camera: &TestCamera) -> Picture {
        // Meshes, pipelines and light clusters are ready a few frames after they are requested.
        (0..4).for_each(|_| self.app.update());
        let reader = self.world().spawn(Readback::texture(camera.image.clone())).id();
        let entity = reader;
        self.world().entity_mut(reader).observe(move |event: On<ReadbackComplete>, mut read: ResMut<ReadbackData>| {
            read.0.insert(entity, event.data.clone());
        });
        let rgba = (0..100).find_map(|_| {
            self.app.update();
            self.world().resource_mut::<ReadbackData>().0.remove(&reader)
        });
        self.world().despawn(reader);
        let rgba = rgba.expect("a picture within a hundred frames");
        Picture { size: camera.size, rgba: remove_padding(&rgba, camera.size) }
    }
}

/// Removes the alignment padding of rows.
fn remove_padding(bytes: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let row = 4 * width as usize;
    if bytes.len() == row * height as usize {
        return bytes.to_vec();
    }
    bytes.chunks(row.next_multiple_of(256)).take(height as usize).flat_map(|padded| &padded[..row]).copied().collect()
}

/// Returns the package of a furry ball of 12.5 cm. It has a skeleton, a clip that bends it, and the ink style.
pub fn ball_package() -> Vec<u8> {
    sphere::package(&SphereParams { skeleton: true, ink: true, quads: 12, ..SphereParams::default() })
}

/// Returns the package of the ball of [`ball_package`] with painted strokes.
pub fn painted_ball_package() -> Vec<u8> {
    let params = SphereParams { skeleton: true, ink: true, strokes: true, quads: 12, ..SphereParams::default() };
    sphere::package(&params)
}
