//! Scene: animals that walk in circles on a ground, between posts that cast shadows on them.

use bevy_app::{App, Update};
use bevy_asset::{Assets, Handle};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_light::{CascadeShadowConfigBuilder, DirectionalLight, GlobalAmbientLight};
use bevy_math::{Quat, Vec3};
use bevy_mesh::{Mesh, Mesh3d};
use bevy_pbr::{MeshMaterial3d, StandardMaterial};
use bevy_pelage::runtime::{FurParams, InkBackground, InkParams, Style};
use bevy_pelage::{Pelage, PelageClip, PelageModel, PelageShadowCaster};
use bevy_shape::{Cuboid, Plane3d};
use bevy_time::Time;
use bevy_transform::components::Transform;
use std::f32::consts::TAU;

/// Models of the animals in the order of their circles, innermost first.
#[derive(Resource)]
pub struct AnimalModels(pub Vec<Handle<PelageModel>>);

/// Size of the scene; this resource exists once all animals are loaded.
#[derive(Resource, Clone, Copy, Debug)]
pub struct SceneSize {
    /// Radius of the outermost circle, metres.
    pub radius_m: f32,
    /// Height of the tallest animal, metres.
    pub height_m: f32,
}

/// Component of a walking animal.
#[derive(Component, Clone, Copy, Debug)]
struct Walker {
    /// Radius of its circle, metres.
    radius_m: f32,
    /// Starting angle on the circle, radians.
    start_rad: f32,
    speed_m_s: f32,
    /// Offset that puts its feet on the ground, metres.
    lift_m: f32,
}

impl Walker {
    /// Returns the transform at a time. The animal faces its walking direction; models face +z.
    fn transform_at(&self, time_s: f32) -> Transform {
        let angle = self.start_rad + time_s * self.speed_m_s / self.radius_m;
        let place = Vec3::new(self.radius_m * angle.sin(), self.lift_m, self.radius_m * angle.cos());
        Transform::from_translation(place).with_rotation(Quat::from_rotation_y(angle + 0.25 * TAU))
    }
}

/// Adds the scene to an app. The scene is set up once all of [`AnimalModels`] are loaded.
pub fn add(app: &mut App) {
    app.insert_resource(GlobalAmbientLight { brightness: 1_500.0, ..Default::default() })
        .add_systems(Update, (set_up.run_if(scene_is_missing), walk));
}

fn scene_is_missing(scene_size: Option<Res<SceneSize>>) -> bool {
    scene_size.is_none()
}

fn set_up(
    mut commands: Commands,
    animals: Res<AnimalModels>,
    models: Res<Assets<PelageModel>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Some(loaded) = animals.0.iter().map(|handle| models.get(handle)).collect::<Option<Vec<_>>>() else { return };
    let height_m = loaded.iter().map(|model| 2.0 * model.bounds().half_extents.y).fold(0.0, f32::max);
    // The innermost circle leaves room for the box in the middle.
    let mut scene_size = SceneSize { radius_m: 0.4 * height_m, height_m };
    for (number, (handle, model)) in (0u8..).zip(animals.0.iter().zip(loaded)) {
        let (bounds, fur) = (model.bounds(), model.fur_height_m());
        let length = bounds.half_extents.z;
        scene_size.radius_m += 1.5 * length + bounds.half_extents.x;
        // The speed approximately matches the clips of the built-in animals.
        let speed_m_s = 0.5 * length.max(bounds.half_extents.y);
        let lift_m = bounds.half_extents.y - bounds.center.y - fur;
        let walker =
            Walker { radius_m: scene_size.radius_m, start_rad: -0.5 + 0.8 * f32::from(number), speed_m_s, lift_m };
        let mut animal = commands.spawn((Pelage::fur(handle.clone()), walker, walker.transform_at(0.0)));
        // An animal without a clip of that name glides without moving its legs.
        if model.clip("Walk").is_ok() {
            animal.insert(PelageClip::new("Walk"));
        }
        scene_size.radius_m += bounds.half_extents.x;
    }

    let mut material = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 1.0,
            reflectance: 0.1,
            ..Default::default()
        })
    };
    let (grass, stone, brick) = (
        material(Color::srgb(0.36, 0.4, 0.22)),
        material(Color::srgb(0.62, 0.6, 0.55)),
        material(Color::srgb(0.55, 0.3, 0.22)),
    );
    let (r, h) = (scene_size.radius_m, scene_size.height_m);
    let ground = meshes.add(Plane3d::new(Vec3::Y, 12.0 * r * bevy_math::Vec2::ONE));
    commands.spawn((Mesh3d(ground), MeshMaterial3d(grass)));
    // Posts around the circles, a box in their middle, and a low wall behind.
    let mut block = |size: Vec3, at: Vec3, turn: f32, material: &Handle<StandardMaterial>| {
        let place = Transform::from_translation(at + 0.5 * size.y * Vec3::Y).with_rotation(Quat::from_rotation_y(turn));
        let mesh = meshes.add(Cuboid::from_size(size));
        commands.spawn((Mesh3d(mesh), MeshMaterial3d(material.clone()), place, PelageShadowCaster));
    };
    for (angle, height) in [(-1.35f32, 1.5), (-0.75, 1.5), (0.75, 1.5), (1.35, 1.5), (2.2, 1.1), (-2.2, 1.1)] {
        let at = Vec3::new(angle.sin(), 0.0, angle.cos()) * 1.12 * r;
        block(Vec3::new(0.08 * h, height * h, 0.08 * h), at, angle, &stone);
    }
    block(Vec3::new(0.45 * h, 0.28 * h, 0.45 * h), Vec3::ZERO, 0.5, &brick);
    block(Vec3::new(2.6 * r, 0.35 * h, 0.12 * h), Vec3::Z * -1.35 * r, 0.0, &brick);

    let sun = DirectionalLight { illuminance: 9_000.0, shadow_maps_enabled: true, ..Default::default() };
    let cascades = CascadeShadowConfigBuilder { num_cascades: 2, maximum_distance: 12.0 * r, ..Default::default() };
    let from = Vec3::new(-1.0, 0.9, 0.6);
    commands.spawn((sun, cascades.build(), Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.insert_resource(scene_size);
}

fn walk(mut walkers: Query<(&Walker, &mut Transform)>, time: Res<Time>) {
    for (walker, mut transform) in &mut walkers {
        *transform = walker.transform_at(time.elapsed_secs());
    }
}

/// Returns a camera position from which all circles and animals are visible.
///
/// * `turn_rad`: rotation about the centre; at 0 the camera is on the +z side
pub fn overview_camera(scene_size: &SceneSize, turn_rad: f32) -> Transform {
    let distance = 2.1 * scene_size.radius_m;
    let eye = Quat::from_rotation_y(turn_rad) * Vec3::new(0.0, 0.5 * scene_size.height_m + 0.18 * distance, distance);
    Transform::from_translation(eye).looking_at(Vec3::Y * 0.35 * scene_size.height_m, Vec3::Y)
}

/// Returns the default fur style.
pub fn fur_style() -> Style {
    Style::Fur(FurParams::default())
}

/// Returns the ink style that paints over Bevy's picture.
pub fn ink_style() -> Style {
    Style::Ink(InkParams::default().with(|ink| ink.background = InkBackground::Picture))
}

/// Sets the drawing style of all animals.
pub fn restyle(animals: &mut Query<&mut Pelage>, style: &Style) {
    for mut animal in animals {
        animal.style = style.clone();
    }
}
