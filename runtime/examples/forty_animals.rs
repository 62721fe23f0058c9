//! Forty animals in one frame: copies of one model, each with its own position and pose. The application's ground and
//! the animals cast shadows on each other.
//!
//! ```text
//! cargo run --release --example forty_animals -- [PACKAGE.pelage] [PICTURE.png]
//! ```
//!
//! Without a package it uses a small furry sphere. Device and targets are those of `pelage-stage`. The application's
//! ground and shader are in `support/ground.rs`.

#![allow(clippy::unwrap_used, reason = "an example stops at the first surprise")]

#[path = "support/mod.rs"]
mod support;

use pelage_runtime::glam::{Mat4, Quat, Vec3};
use pelage_runtime::{
    Camera, CasterPass, Casters, Detail, FrameParams, Hooks, Instance, Light, LightView, Model, Motion, Renderer,
    RendererOptions, Sphere, wgpu,
};
use pelage_stage::{Canvas, Gpu};
use support::ground::{Cuboid, Scene};

const SIZE: (u32, u32) = (1200, 640);
const COLUMNS: u64 = 8;
const ANIMALS: u64 = 40;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let package = support::package_or_sphere(arguments.next());
    let picture = arguments.next().unwrap_or_else(|| "target/forty_animals.png".into());

    // The application's device and targets. Colour and depth have four samples per pixel, which the options specify for
    // pelage.
    let gpu = Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default())).unwrap();
    let options = RendererOptions { sample_count: 4, ..RendererOptions::default() };
    let targets = Canvas::new(&gpu, SIZE, &(&options).into());

    // Once: create a renderer for this kind of pass, and the model of all copies.
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let model = renderer.load_bytes(&package).unwrap();

    // Create the application's scene: a meadow that receives shadows.
    let reach = 12.0 * radius(&model);
    let (low, high) = (Vec3::new(-4.0, -0.1, -4.0) * reach, Vec3::new(4.0, 0.0, 4.0) * reach);
    let scene = Scene::new(&gpu.device, &options, &[Cuboid { low, high, color: Vec3::new(0.26, 0.36, 0.15) }]);
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let camera = Camera::framing(Vec3::ZERO, 0.62 * reach, Vec3::new(0.25, 0.7, 1.0), 0.6, aspect);
    let towards_sun = Vec3::new(-0.7, 0.8, 0.3).normalize();

    // Every frame: set the drawing parameters. The key light casts the shadows; the fill light brightens them.
    let params = FrameParams::new(camera, SIZE.into())
        .with(|p| {
            p.light = Light::Directional { towards_light: towards_sun, color: Vec3::new(1.0, 0.96, 0.88) };
            let sky =
                Light::Directional { towards_light: Vec3::new(0.6, 0.9, -0.2), color: Vec3::new(0.1, 0.13, 0.18) };
            p.fill_lights = vec![sky];
            // A single map covers all animals: it needs more texels than a map for one animal, but fewer layers.
            (p.shadows.map_size, p.shadows.map_layers, p.shadows.shrink) = (2048, Some(6), 8);
        })
        .with_fur(|fur| fur.detail = Detail::Auto { bias: 1.0 });
    // Every frame: list the instances. Fur is blended, so they are sorted from far to near.
    let mut herd: Vec<Instance> = (0..ANIMALS).map(|owner| animal(owner, &model)).collect();
    let nearness = |animal: &Instance| (camera.view_from_world * animal.transform.w_axis).z;
    herd.sort_by(|a, b| nearness(a).total_cmp(&nearness(b)));

    // The ground receives shadows, so it must also be drawn into the shadow maps.
    let mut draw_ground = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
        scene.draw_depth(&gpu.device, pass, view, which);
    };
    let bounds = Some(Sphere { center: Vec3::ZERO, radius: reach });
    let hooks = Hooks::default().casters(Casters { bounds, revision: 0, draw: &mut draw_ground });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare_with(&mut encoder, &params, &herd, hooks).unwrap();

    // Draw into the application's own pass.
    let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color { r: 0.45, g: 0.58, b: 0.72, a: 1.0 }));
    let clip_from_world = camera.projection.clip_from_view(options.reversed_depth) * camera.view_from_world;
    scene.draw(&gpu.device, &mut pass, clip_from_world, towards_sun.extend(0.0), &frame);
    frame.draw(&mut pass);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);

    image::save_buffer(&picture, &targets.texels(&gpu).unwrap(), SIZE.0, SIZE.1, image::ColorType::Rgba8).unwrap();
    println!("{picture}: drawn by {}", gpu.info.name);
    for pass in &frame.report().passes {
        println!("{}: {} ({})", pass.name, if pass.ran { "ran" } else { "did not run" }, pass.reason);
    }
}

/// Returns one animal of the herd. It stands at its row and column, slightly displaced, with its own rotation and size.
/// Every third animal moves if the package has clips.
fn animal(owner: u64, model: &Model) -> Instance {
    let bounds = model.manifest().bounds;
    let [column, row] = [owner % COLUMNS, owner / COLUMNS].map(|n| n as f32);
    let odd = |seed: f32| (seed * owner as f32).sin();
    let place = Vec3::new(2.7 * (column - 3.5 + 0.25 * odd(1.9)), 0.0, 3.3 * (row - 2.0 + 0.25 * odd(2.9)));
    let (turn, size) = (Quat::from_rotation_y(0.7 + 0.8 * odd(2.6)), Vec3::splat(0.9 + 0.1 * odd(5.3)));
    // The animal stands on its feet: the bottom centre of the package's bounds is at its position.
    let feet = Vec3::new(bounds.center[0], bounds.min[1], bounds.center[2]);
    let transform =
        Mat4::from_scale_rotation_translation(size, turn, place * radius(model)) * Mat4::from_translation(-feet);
    let standing = Instance::new(owner, model).at(transform);
    match model.clips().first() {
        Some(clip) if owner.is_multiple_of(3) => {
            standing.moving(Motion::Clip { clip: 0, time_s: 0.13 * owner as f32 % clip.duration_s.max(1e-3) })
        }
        _ => standing,
    }
}

fn radius(model: &Model) -> f32 {
    model.manifest().bounds.radius + model.manifest().fur.height_m
}
