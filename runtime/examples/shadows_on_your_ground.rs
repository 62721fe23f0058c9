//! Shadows between fur and an application's own geometry. A ground and a post are drawn into the shadow maps, and the
//! application's shader receives the shadows. Both are in `support/ground.rs`.
//!
//! ```text
//! cargo run --release --example shadows_on_your_ground -- [PACKAGE.pelage] [PICTURE.png]
//! ```
//!
//! Without a package it uses a small furry sphere.

#![allow(clippy::unwrap_used, reason = "an example stops at the first surprise")]

#[path = "support/mod.rs"]
mod support;

use pelage_runtime::glam::{Mat4, Vec3};
use pelage_runtime::{
    Camera, CasterPass, Casters, FrameParams, Hooks, Instance, Light, LightView, Renderer, RendererOptions, Sphere,
    wgpu,
};
use pelage_stage::{Canvas, Gpu};
use support::ground::{Cuboid, Scene};

const SIZE: (u32, u32) = (834, 424);

fn main() {
    let mut arguments = std::env::args().skip(1);
    let package = support::package_or_sphere(arguments.next());
    let picture = arguments.next().unwrap_or_else(|| "target/shadows_on_your_ground.png".into());

    let gpu = Gpu::with(wgpu::Features::TEXTURE_COMPRESSION_BC, Some(wgpu::Limits::default())).unwrap();
    let options = RendererOptions::default();
    let targets = Canvas::new(&gpu, SIZE, &(&options).into());
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let model = renderer.load_bytes(&package).unwrap();
    let (bounds, height) = (model.manifest().bounds, model.manifest().fur.height_m);
    let r = bounds.radius + height;
    let center = Vec3::from(bounds.center);
    let feet_on_the_ground = Vec3::new(-center.x, height - bounds.min[1], -center.z);
    let animal = Instance::new(0, &model).at(Mat4::from_translation(feet_on_the_ground));

    let green = Vec3::new(0.3, 0.45, 0.2);
    let red = Vec3::new(0.6, 0.15, 0.1);
    let ground = Cuboid { low: Vec3::new(-2.2, -0.1, -2.2) * r, high: Vec3::new(2.2, 0.0, 2.2) * r, color: green };
    let post = Cuboid { low: Vec3::new(-1.75, 0.0, 0.35) * r, high: Vec3::new(-1.5, 2.1, 0.6) * r, color: red };
    let scene = Scene::new(&gpu.device, &options, &[ground, post]);

    let towards_light = Vec3::new(-0.8, 0.8, 0.2).normalize();
    let camera =
        Camera::framing(Vec3::Y * 0.8 * r, r * 1.6, Vec3::new(-0.5, 0.6, 1.0), 0.6, SIZE.0 as f32 / SIZE.1 as f32);
    let light = Light::Directional { towards_light, color: Vec3::ONE };
    // The width of a penumbra is at most 4/3 times `shrink` map texels. Here the maps cover a ground, so their texels
    // are larger than those for an animal alone.
    let params = FrameParams::new(camera, SIZE.into()).with(|p| {
        p.light = light;
        p.shadows.shrink = 8;
    });

    // The application draws its geometry into the maps. The bounds contain everything that may cast or receive a
    // shadow; points outside are lit. A changed revision says that the geometry has moved.
    let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
        scene.draw_depth(&gpu.device, pass, view, which);
    };
    let bounds = Some(Sphere { center: Vec3::ZERO, radius: 3.2 * r });
    let casters = Casters { bounds, revision: 0, draw: &mut draw };
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare_with(&mut encoder, &params, [&animal], Hooks::default().casters(casters)).unwrap();
    let mut pass = targets.pass(&mut encoder, "application", Some(wgpu::Color { r: 0.35, g: 0.45, b: 0.6, a: 1.0 }));
    scene.draw(
        &gpu.device,
        &mut pass,
        camera.projection.clip_from_view(false) * camera.view_from_world,
        towards_light.extend(0.0),
        &frame,
    );
    frame.draw(&mut pass);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);

    image::save_buffer(&picture, &targets.texels(&gpu).unwrap(), SIZE.0, SIZE.1, image::ColorType::Rgba8).unwrap();
    println!("{picture}: drawn by {}", gpu.info.name);
}
