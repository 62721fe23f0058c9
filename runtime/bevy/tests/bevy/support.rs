//! A Bevy app without a window, whose cameras draw into images that are read back.

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::{AssetPlugin, Assets, Handle, RenderAssetUsages};
use bevy_camera::{Camera3d, CameraPlugin, Hdr, PerspectiveProjection, Projection, RenderTarget};
use bevy_color::Color;
use bevy_core_pipeline::CorePipelinePlugin;
use bevy_core_pipeline::tonemapping::{DebandDither, Tonemapping};
use bevy_diagnostic::FrameCountPlugin;
use bevy_ecs::prelude::*;
use bevy_image::{Image, ImagePlugin};
use bevy_light::{DirectionalLight, LightPlugin};
use bevy_math::Vec3;
use bevy_mesh::{Mesh, MeshPlugin, Mesh3d};
use bevy_pbr::{MeshMaterial3d, PbrPlugin, StandardMaterial};
use bevy_pelage::{PelageModel, PelagePlugin, PelageRenderers};
use bevy_render::gpu_readback::{Readback, ReadbackComplete};
use bevy_render::render_resource::TextureFormat;
use bevy_render::view::Msaa;
use bevy_render::{RenderApp, RenderPlugin};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use bevy_window::WindowPlugin;
use std::path::PathBuf;
use std::time::Duration;

/// Pixels of a picture, RGBA bytes, row by row.
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

    /// Mean difference of the colours, in 255ths.
    pub fn difference(&self, other: &Self) -> f64 {
        assert_eq!(self.size, other.size);
        let sum: u64 = self.rgba.iter().zip(&other.rgba).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        sum as f64 / self.rgba.len() as f64
    }

    /// Writes a PNG for people to look at: into `target/pictures`.
    pub fn save(&self, name: &str) {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/pictures");
        std::fs::create_dir_all(&folder).unwrap();
        let file = std::fs::File::create(folder.join(name)).unwrap();
        let mut encoder = png::Encoder::new(file, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_compression(png::Compression::High);
        encoder.write_header().unwrap().write_image_data(&self.rgba).unwrap();
    }
}

/// An app, and what it is told to draw.
pub struct Stand {
    pub app: App,
}

/// What was read back.
#[derive(Resource, Default)]
struct Read(std::collections::HashMap<Entity, Vec<u8>>);

/// A camera of the stand: its entity, its picture and who reads that back.
#[derive(Clone)]
pub struct TestCamera {
    pub entity: Entity,
    pub image: Handle<Image>,
    pub size: [u32; 2],
}

impl Stand {
    /// An app with everything that Bevy draws meshes with. Time stands still but for `pass`.
    pub fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((
            TaskPoolPlugin::default(),
            FrameCountPlugin,
            TimePlugin,
            TransformPlugin,
            bevy_diagnostic::DiagnosticsPlugin,
            AssetPlugin { file_path: "/".into(), unapproved_path_mode: bevy_asset::UnapprovedPathMode::Allow, ..Default::default() },
            WindowPlugin { primary_window: None, exit_condition: bevy_window::ExitCondition::DontExit, ..Default::default() },
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
        .init_resource::<Read>();
        app.finish();
        app.cleanup();
        Self { app }
    }

    pub fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    /// What pelage keeps in the render world.
    pub fn renderers(&self) -> &PelageRenderers {
        self.app.sub_app(RenderApp).world().resource()
    }

    /// A model of the bytes of a package.
    pub fn model(&mut self, name: &str, bytes: &[u8]) -> Handle<PelageModel> {
        let model = PelageModel::from_bytes(name, bytes.to_vec()).unwrap();
        self.world().resource_mut::<Assets<PelageModel>>().add(model)
    }

    /// A camera that draws into a picture of its own, as bright as numbers in the shaders are.
    pub fn camera(&mut self, size: [u32; 2], msaa: Msaa, place: Transform) -> TestCamera {
        let mut image = Image::new_target_texture(size[0], size[1], TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= bevy_render::render_resource::TextureUsages::COPY_SRC;
        image.asset_usage = RenderAssetUsages::RENDER_WORLD;
        let image = self.world().resource_mut::<Assets<Image>>().add(image);
        let projection = PerspectiveProjection { fov: 0.6, aspect_ratio: size[0] as f32 / size[1] as f32, ..Default::default() };
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

    /// A sun of full light from there.
    pub fn sun(&mut self, from: Vec3, shadows: bool) -> Entity {
        let full = std::f32::consts::PI / bevy_camera::Exposure::default().exposure();
        let light = DirectionalLight { illuminance: full, shadow_maps_enabled: shadows, ..Default::default() };
        self.world().spawn((light, Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y))).id()
    }

    /// A cuboid of Bevy's.
    pub fn cuboid(&mut self, size: Vec3, at: Vec3, color: Color) -> Entity {
        let mesh = Mesh::from(bevy_shape::Cuboid::from_size(size));
        let mesh = self.world().resource_mut::<Assets<Mesh>>().add(mesh);
        let material = StandardMaterial { base_color: color, perceptual_roughness: 1.0, reflectance: 0.0, ..Default::default() };
        let material = self.world().resource_mut::<Assets<StandardMaterial>>().add(material);
        self.world().spawn((Mesh3d(mesh), MeshMaterial3d(material), Transform::from_translation(at))).id()
    }

    /// The picture of a camera, once all that was asked for is loaded, compiled and drawn.
    pub fn picture(&mut self, camera: &TestCamera) -> Picture {
        // Meshes, pipelines and light clusters are there a few frames after they are asked for.
        (0..4).for_each(|_| self.app.update());
        let reader = self.world().spawn(Readback::texture(camera.image.clone())).id();
        let entity = reader;
        self.world().entity_mut(reader).observe(move |event: On<'_, '_, ReadbackComplete>, mut read: ResMut<'_, Read>| {
            read.0.insert(entity, event.data.clone());
        });
        let rgba = (0..100).find_map(|_| {
            self.app.update();
            self.world().resource_mut::<Read>().0.remove(&reader)
        });
        self.world().despawn(reader);
        let rgba = rgba.expect("a picture within a hundred frames");
        Picture { size: camera.size, rgba: unpadded(&rgba, camera.size) }
    }
}

/// Rows as they are, without what aligns them.
fn unpadded(bytes: &[u8], [width, height]: [u32; 2]) -> Vec<u8> {
    let row = 4 * width as usize;
    if bytes.len() == row * height as usize {
        return bytes.to_vec();
    }
    bytes.chunks(row.next_multiple_of(256)).take(height as usize).flat_map(|padded| &padded[..row]).copied().collect()
}

/// The built-in hare that walks, baked by the tool of this repository.
pub fn hare() -> &'static [u8] {
    static HARE: std::sync::OnceLock<Vec<u8>> = std::sync::OnceLock::new();
    HARE.get_or_init(|| {
        let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
        let package = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target/hare.pelage");
        if let Ok(bytes) = std::fs::read(&package) { return bytes; }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let baked = std::process::Command::new(cargo)
            .args(["run", "--quiet", "--locked", "-p", "pelage-bake", "--", "bake", "assets/models/hare.glb", "-o"])
            .arg(&package)
            .current_dir(&root)
            .output()
            .unwrap();
        assert!(baked.status.success(), "{}", String::from_utf8_lossy(&baked.stderr));
        std::fs::read(&package).unwrap()
    })
}
