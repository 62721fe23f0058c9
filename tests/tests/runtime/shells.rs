//! Checks that the optimisations of shells leave the picture unchanged.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::Vec3;
use pelage_runtime::{Camera, FrameParams, Instance, Light, LightingStage, Renderer, RendererOptions, SlantForm};
use pelage_stage::Gpu;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, draw};
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: (u32, u32) = (192, 192);

fn sphere() -> SphereParams {
    SphereParams { quads: 12, texels: 32, strands: 90, tiles: 4, ..SphereParams::default() }
}

fn front() -> FrameParams {
    FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0), SIZE.into())
}

fn picture(gpu: &Gpu, sphere: &SphereParams, params: &FrameParams) -> Picture {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(&package(sphere)).unwrap());
    draw(gpu, &mut renderer, params, &[&instance])
}

/// Returns the largest difference of a channel, 0..=255.
fn largest_difference(a: &Picture, b: &Picture) -> u8 {
    let channels = a.rgba.as_flattened().iter().zip(b.rgba.as_flattened());
    channels.map(|(x, y)| x.abs_diff(*y)).max().unwrap()
}

#[test]
fn shell_shader_variants_draw_the_same() {
    let Some(gpu) = gpu("shell_shader_variants_draw_the_same") else { return };
    let plain = picture(gpu, &sphere(), &front());
    assert!(plain.covered() > 8000, "{} pixels of fur", plain.covered());
    // The neutral texture and the black light force the longer variants of the shader.
    let mapped = picture(gpu, &SphereParams { white_texture: true, ..sphere() }, &front());
    assert!(largest_difference(&plain, &mapped) <= 1, "mapped: {} of 255", largest_difference(&plain, &mapped));
    let mut params = front();
    params.fill_lights = vec![Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO }];
    let filled = picture(gpu, &sphere(), &params);
    assert!(largest_difference(&plain, &filled) <= 1, "filled: {} of 255", largest_difference(&plain, &filled));
    // This is the negative control: a second light must change the picture.
    params.fill_lights = vec![Light::Directional { towards_light: Vec3::Y, color: Vec3::splat(0.2) }];
    assert!(
        largest_difference(&plain, &picture(gpu, &sphere(), &params)) > 8,
        "a second light must change the picture"
    );
    let striped = picture(gpu, &SphereParams { stripes: true, ..sphere() }, &front());
    assert!(largest_difference(&plain, &striped) > 8, "stripes must change the picture");
}

/// Returns two means over pixels that are opaque in every picture: the luminance (0..=255), and its difference to the
/// right-hand neighbour.
fn luminance_and_contrast(picture: &Picture, opaque: &dyn Fn(usize) -> bool) -> (f64, f64) {
    let at = |i: usize| {
        let [r, g, b, _] = picture.rgba[i].map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    let inside: Vec<usize> = (0..picture.rgba.len() - 1).filter(|i| opaque(*i) && opaque(i + 1)).collect();
    let n = inside.len() as f64;
    let mean = |f: &dyn Fn(usize) -> f64| inside.iter().map(|i| f(*i)).sum::<f64>() / n;
    (mean(&at), mean(&|i| (at(i) - at(i + 1)).abs()))
}

#[test]
fn vertex_lighting_is_as_bright_and_smoother() {
    let Some(gpu) = gpu("vertex_lighting_is_as_bright_and_smoother") else { return };
    for planar_directions in [true, false] {
        let sphere = SphereParams { planar_directions, quads: 20, ..sphere() };
        let mut params = front();
        let pixel = picture(gpu, &sphere, &params);
        params.study.lighting = LightingStage::Vertex;
        let vertex = picture(gpu, &sphere, &params);
        assert!(largest_difference(&pixel, &vertex) > 8, "only {} of 255 apart", largest_difference(&pixel, &vertex));
        let opaque = |i: usize| pixel.rgba[i][3] == 255 && vertex.rgba[i][3] == 255;
        let (bright, sharp) = luminance_and_contrast(&pixel, &opaque);
        let (bright_at_vertices, sharp_at_vertices) = luminance_and_contrast(&vertex, &opaque);
        let brightness = bright_at_vertices / bright;
        assert!((0.95..1.05).contains(&brightness), "{brightness} times as bright");
        let contrast = sharp_at_vertices / sharp;
        assert!((0.5..0.97).contains(&contrast), "{contrast} times the contrast");
        // Without key light, both forms must give the same picture.
        params.light = Light::Directional { towards_light: Vec3::Y, color: Vec3::ZERO };
        // The published form interpolates the view direction between vertices, so the direction differs slightly from
        // that of the pixel.
        params.study.view_slant = SlantForm::Printed;
        let dark = picture(gpu, &sphere, &params);
        params.study.lighting = LightingStage::Pixel;
        assert!(largest_difference(&dark, &picture(gpu, &sphere, &params)) <= 1, "without light");
    }
}
