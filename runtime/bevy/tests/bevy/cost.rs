//! Measures the cost of a frame in Bevy, compared with the runtime alone.

use crate::support::{TestApp, ball_package};
use bevy_camera::visibility::Visibility;
use bevy_ecs::entity::Entity;
use bevy_math::Vec3;
use bevy_pelage::runtime::{self, FrameParams, Instance, Motion, Renderer, RendererOptions, wgpu};
use bevy_pelage::{Pelage, PelageClip};
use bevy_render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue};
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;
use pelage_stage::{Canvas, Gpu};
use std::time::Instant;

const SIZE: [u32; 2] = [640, 480];
const EYE: Vec3 = Vec3::new(0.0, 0.05, 0.5);
const FRAMES: u32 = 30;
/// Number of warm-up frames, during which pipelines are compiled.
const WARM: u32 = 4;
/// Clip time per frame, seconds.
const STEP_S: f32 = 0.01;

/// Returns the time from the start of a frame until the GPU is finished, milliseconds.
fn elapsed_ms(device: &wgpu::Device, frame: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    frame();
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    begun.elapsed().as_secs_f64() * 1e3
}

/// Returns the package to measure: the file `PELAGE_PACKAGE`, or the test ball.
fn package() -> Vec<u8> {
    std::env::var_os("PELAGE_PACKAGE").map_or_else(ball_package, |path| std::fs::read(path).unwrap())
}

fn spawn_animal(test_app: &mut TestApp) -> Entity {
    let model = test_app.add_model("animal", &package());
    let clip = PelageClip::new(first_clip(test_app, &model));
    test_app.spawn_camera(SIZE, Msaa::Off, Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y));
    test_app.spawn_sun(Vec3::new(-0.5, 0.8, 0.6), false);
    test_app.world().spawn((Pelage::fur(model), clip)).id()
}

fn first_clip(test_app: &mut TestApp, model: &bevy_asset::Handle<bevy_pelage::PelageModel>) -> String {
    let models = test_app.world().resource::<bevy_asset::Assets<bevy_pelage::PelageModel>>();
    models.get(model).unwrap().clips().next().map_or_else(String::new, |(name, _)| name.to_owned())
}

/// Returns a function that draws a frame with the runtime alone on the same device. Its arguments: time of the clip,
/// and whether to draw the animal.
fn runtime_drawer(gpu: &Gpu) -> impl FnMut(f32, bool) {
    let options = RendererOptions {
        color_format: wgpu::TextureFormat::Rgba16Float,
        reversed_depth: true,
        ..RendererOptions::default()
    };
    let canvas = Canvas::new(gpu, (SIZE[0], SIZE[1]), &(&options).into());
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let model = renderer.load_bytes(&package()).unwrap();
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let projection = runtime::Projection::Perspective { fov_y_rad: 0.6, aspect, near_m: 0.1, far_m: f32::INFINITY };
    let params =
        FrameParams::new(runtime::Camera::look_at(EYE, Vec3::ZERO, projection), SIZE).with(|p| p.soft_shadow = false);
    let gpu = gpu.clone();
    move |time_s, there| {
        let animal = Instance::new(0, &model).moving(Motion::Clip { clip: 0, time_s });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &params, there.then_some(animal)).unwrap();
        let mut pass = canvas.pass(&mut encoder, "runtime alone", Some(wgpu::Color::BLACK));
        frame.draw(&mut pass);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
    }
}

#[test]
#[ignore = "measures: cargo test --profile example --test bevy -- --ignored --nocapture runtime_alone"]
fn frame_cost_is_measured_against_the_runtime_alone() {
    let mut test_app = TestApp::new();
    let world = test_app.render_world();
    let device = world.resource::<RenderDevice>().wgpu_device().clone();
    let queue = wgpu::Queue::clone(world.resource::<RenderQueue>());
    let info = (**world.resource::<RenderAdapterInfo>()).clone();
    let gpu = Gpu { device: device.clone(), queue, info };
    let animal = spawn_animal(&mut test_app);
    let mut draw_alone = runtime_drawer(&gpu);
    // Interleave the variants, so that other load on the machine affects all of them alike. The minimum time of each
    // variant is the least disturbed.
    let mut fastest = [f64::INFINITY; 4];
    for number in 0..WARM + FRAMES {
        let time_s = STEP_S * number as f32;
        let times = [
            bevy_frame_ms(&mut test_app, &device, animal, Visibility::Inherited),
            bevy_frame_ms(&mut test_app, &device, animal, Visibility::Hidden),
            elapsed_ms(&device, || draw_alone(time_s, true)),
            elapsed_ms(&device, || draw_alone(time_s, false)),
        ];
        if number >= WARM {
            fastest = std::array::from_fn(|i| fastest[i].min(times[i]));
        }
    }
    let [bevy_with, bevy_without, with, without] = fastest;
    let (bevy, runtime) = (bevy_with - bevy_without, with - without);
    println!("{}: {SIZE:?}, fastest of {FRAMES} frames, ms", gpu.info.name);
    println!("in Bevy {bevy_with:.2} with the animal, {bevy_without:.2} without: {bevy:.2}");
    println!("alone   {with:.2} with the animal, {without:.2} without: {runtime:.2}");
    println!("overhead of Bevy for the animal {:+.1} %", 100.0 * (bevy / runtime - 1.0));
}

/// Returns the time of a Bevy frame in which the animal has this `visibility`, milliseconds.
fn bevy_frame_ms(test_app: &mut TestApp, device: &wgpu::Device, animal: Entity, visibility: Visibility) -> f64 {
    *test_app.world().get_mut::<Visibility>(animal).unwrap() = visibility;
    elapsed_ms(device, || test_app.advance(STEP_S))
}
