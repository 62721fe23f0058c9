//! Example: animals that walk on a ground among Bevy's meshes.
//!
//! ```text
//! bevy-pelage-walk PACKAGE.pelage...                                   in a window
//! bevy-pelage-walk PACKAGE.pelage... --picture fur-and-ink.png         without one
//! ```
//!
//! Keys in the window: I switches between fur and ink, Space pauses, arrows orbit and zoom, Escape quits.

mod picture;
mod scene;

use bevy_a11y::AccessibilityPlugin;
use bevy_app::{App, AppExit, ScheduleRunnerPlugin, TaskPoolPlugin, Update};
use bevy_asset::{AssetPlugin, AssetServer, Handle, LoadState, UnapprovedPathMode};
use bevy_camera::{Camera3d, CameraPlugin, ClearColor, Hdr};
use bevy_color::Color;
use bevy_core_pipeline::CorePipelinePlugin;
use bevy_core_pipeline::tonemapping::Tonemapping;
use bevy_diagnostic::{DiagnosticsPlugin, FrameCountPlugin};
use bevy_ecs::prelude::*;
use bevy_image::ImagePlugin;
use bevy_input::{ButtonInput, InputPlugin, keyboard::KeyCode};
use bevy_light::LightPlugin;
use bevy_log::{LogPlugin, error};
use bevy_mesh::MeshPlugin;
use bevy_pbr::PbrPlugin;
use bevy_pelage::runtime::{Style, StyleKind};
use bevy_pelage::{Pelage, PelageModel, PelagePlugin};
use bevy_render::RenderPlugin;
use bevy_time::{Time, TimePlugin, Virtual};
use bevy_transform::TransformPlugin;
use bevy_transform::components::Transform;
use bevy_window::{ExitCondition, Window, WindowPlugin};
use bevy_winit::WinitPlugin;
use scene::{AnimalModels, SceneSize};
use std::path::PathBuf;
use std::process::ExitCode;

/// Orbit of the window's camera.
#[derive(Resource, Default)]
struct Orbit {
    turn_rad: f32,
    /// Natural logarithm of the distance divided by the default distance.
    log_distance: f32,
}

fn main() -> ExitCode {
    let mut packages: Vec<String> = std::env::args().skip(1).collect();
    let mut picture = None;
    if let Some(at) = packages.iter().position(|argument| argument == "--picture") {
        let mut tail = packages.split_off(at).into_iter().skip(1);
        picture = tail.next().map(PathBuf::from);
        packages.extend(tail.filter(|_| picture.is_some()));
        if picture.is_none() {
            return usage_error("--picture: expected the name of a PNG file");
        }
    }
    if packages.is_empty() {
        return usage_error("expected at least one package");
    }
    let (mut app, drawn) = (app(picture.is_none()), picture.map(picture::PictureRequest::new));
    let server = app.world().resource::<AssetServer>().clone();
    let absolute = |package: &String| std::path::absolute(package).unwrap_or_else(|_| package.into());
    // Bevy resolves relative paths in its asset folder; packages may be anywhere, so their paths are made absolute.
    let load = |package: &String| server.load(absolute(package).to_string_lossy().into_owned());
    app.insert_resource(AnimalModels(packages.iter().map(load).collect()));
    scene::add(&mut app);
    app.add_systems(Update, exit_on_load_failure);
    match drawn {
        Some(request) => picture::add(&mut app, request),
        None => {
            app.init_resource::<Orbit>().add_systems(Update, (add_camera, handle_keys, orbit_camera).chain());
        }
    }
    match app.run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

fn usage_error(fault: &str) -> ExitCode {
    eprintln!("{fault}\nusage: bevy-pelage-walk PACKAGE.pelage... [--picture FILE.png]");
    ExitCode::from(2)
}

/// Creates an app with the Bevy plugins that this example needs. `DefaultPlugins` of the crate `bevy` includes them.
fn app(window: bool) -> App {
    let mut app = App::new();
    let title = "pelage in Bevy (I: fur or ink, Space: pause, arrows: orbit and zoom)".to_owned();
    let primary_window = window.then(|| Window { title, ..Default::default() });
    let exit_condition = if window { ExitCondition::OnAllClosed } else { ExitCondition::DontExit };
    app.add_plugins((
        LogPlugin::default(),
        TaskPoolPlugin::default(),
        FrameCountPlugin,
        TimePlugin,
        TransformPlugin,
        DiagnosticsPlugin,
        InputPlugin,
        WindowPlugin { primary_window, exit_condition, ..Default::default() },
        AssetPlugin { unapproved_path_mode: UnapprovedPathMode::Allow, ..Default::default() },
    ));
    match window {
        true => app.add_plugins((AccessibilityPlugin, WinitPlugin::default())),
        false => app.add_plugins(ScheduleRunnerPlugin::default()),
    };
    app.add_plugins((
        RenderPlugin { synchronous_pipeline_compilation: !window, ..Default::default() },
        ImagePlugin::default(),
        MeshPlugin,
        CameraPlugin,
        LightPlugin,
        CorePipelinePlugin,
        PbrPlugin::default(),
        PelagePlugin::default(),
    ));
    app.insert_resource(ClearColor(Color::srgb(0.55, 0.66, 0.78)));
    app
}

/// Returns the camera of both modes. It is HDR, so that fur and meshes get the same exposure and tone mapping.
fn camera_bundle(place: Transform) -> impl Bundle {
    (Camera3d::default(), Hdr, Tonemapping::AcesFitted, place)
}

/// Quits if a package cannot be loaded, and reports the reason.
fn exit_on_load_failure(animals: Res<AnimalModels>, server: Res<AssetServer>, mut exit: MessageWriter<AppExit>) {
    let failed = |handle: &Handle<PelageModel>| match server.load_state(handle) {
        LoadState::Failed(fault) => Some(fault),
        _ => None,
    };
    if let Some(fault) = animals.0.iter().find_map(failed) {
        error!("{fault}");
        exit.write(AppExit::error());
    }
}

fn add_camera(mut commands: Commands, scene_size: Option<Res<SceneSize>>, cameras: Query<(), With<Camera3d>>) {
    if let Some(scene_size) = scene_size
        && cameras.is_empty()
    {
        commands.spawn(camera_bundle(scene::overview_camera(&scene_size, 0.0)));
    }
}

fn handle_keys(
    keys: Res<ButtonInput<KeyCode>>,
    real: Res<Time<bevy_time::Real>>,
    mut time: ResMut<Time<Virtual>>,
    mut orbit: ResMut<Orbit>,
    mut animals: Query<&mut Pelage>,
    mut exit: MessageWriter<AppExit>,
) {
    if keys.just_pressed(KeyCode::KeyI) {
        let inked = animals.iter().any(|animal: &Pelage| animal.style.kind() == StyleKind::Ink);
        let style: Style = if inked { scene::fur_style() } else { scene::ink_style() };
        scene::restyle(&mut animals, &style);
    }
    if keys.just_pressed(KeyCode::Space) {
        if time.is_paused() { time.unpause() } else { time.pause() }
    }
    if keys.just_pressed(KeyCode::Escape) {
        exit.write(AppExit::Success);
    }
    let held = |more: KeyCode, less: KeyCode| {
        real.delta_secs() * (f32::from(u8::from(keys.pressed(more))) - f32::from(u8::from(keys.pressed(less))))
    };
    orbit.turn_rad += 1.2 * held(KeyCode::ArrowRight, KeyCode::ArrowLeft);
    orbit.log_distance = (orbit.log_distance + held(KeyCode::ArrowDown, KeyCode::ArrowUp)).clamp(-1.5, 1.0);
}

fn orbit_camera(
    orbit: Res<Orbit>,
    scene_size: Option<Res<SceneSize>>,
    mut cameras: Query<&mut Transform, With<Camera3d>>,
) {
    let Some(scene_size) = scene_size else { return };
    for mut camera in &mut cameras {
        let place = scene::overview_camera(&scene_size, orbit.turn_rad);
        *camera = place.with_translation(place.translation * orbit.log_distance.exp());
    }
}
