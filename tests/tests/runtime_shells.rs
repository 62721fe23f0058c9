//! What makes shells cheap leaves the picture as it is.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::Vec3;
use pelage_runtime::{Camera, FrameParams, Instance, Light, Renderer, RendererOptions};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, draw};
use pelage_tests::support::headless::Gpu;
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: (u32, u32) = (192, 192);

fn sphere() -> SphereParams {
    SphereParams { quads: 12, texels: 32, strands: 90, tiles: 4, ..SphereParams::default() }
}

fn front() -> FrameParams {
    FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0))
}

fn picture(gpu: &Gpu, sphere: &SphereParams, params: &FrameParams) -> Picture {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let mut instance = Instance::new(&renderer.load_bytes(&gpu.device, &gpu.queue, &package(sphere)).unwrap());
    draw(gpu, &mut renderer, SIZE, params, &mut [&mut instance])
}

/// Largest difference of a channel, 0..=255.
fn largest(a: &Picture, b: &Picture) -> u8 {
    let channels = a.rgba.as_flattened().iter().zip(b.rgba.as_flattened());
    channels.map(|(x, y)| x.abs_diff(*y)).max().unwrap()
}

#[test]
fn forms_of_the_varyings_draw_the_same() {
    let Some(gpu) = gpu("forms_of_the_varyings_draw_the_same") else { return };
    let plain = picture(gpu, &sphere(), &front());
    assert!(plain.covered() > 8000, "{} pixels of fur", plain.covered());
    // A texture that changes nothing, and a light that adds nothing, need the longer forms.
    let mapped = picture(gpu, &SphereParams { white_texture: true, ..sphere() }, &front());
    assert!(largest(&plain, &mapped) <= 1, "mapped: {} of 255", largest(&plain, &mapped));
    let mut params = front();
    params.fill_lights = vec![Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO }];
    let filled = picture(gpu, &sphere(), &params);
    assert!(largest(&plain, &filled) <= 1, "filled: {} of 255", largest(&plain, &filled));
    // The comparison sees what it should.
    params.fill_lights = vec![Light::Directional { towards_light: Vec3::Y, color: Vec3::splat(0.2) }];
    assert!(largest(&plain, &picture(gpu, &sphere(), &params)) > 8, "a light that is there shows");
    let striped = picture(gpu, &SphereParams { stripes: true, ..sphere() }, &front());
    assert!(largest(&plain, &striped) > 8, "stripes show");
}
