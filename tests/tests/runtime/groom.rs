//! Tests of the groom's effects on a picture: bare surfaces, wet hair, lean.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::Shading;
use pelage_runtime::glam::Vec3;
use pelage_runtime::{
    Camera, FrameParams, Instance, Projection, Renderer, RendererOptions, SelfShadow, SlantForm, Style,
};
use pelage_stage::Gpu;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, difference, draw};
use pelage_tests::plane::{PlaneGroom, groomed_plane};

const SIZE: (u32, u32) = (64, 64);
const LAYERS: u32 = 8;
const OPACITY: u8 = 90;

/// Returns a view straight from above, in which the plane of 0.2 m fills the picture.
fn above() -> FrameParams {
    let projection = Projection::Orthographic { height_m: 0.2, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    // Shadows are off, because the compared planes have different neighbours that would shade them.
    let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, projection);
    let params = FrameParams::new(camera, SIZE.into()).with_fur(|f| f.self_shadow = SelfShadow::Off);
    // The hair is upright and viewed along its strands, so that the picture shows the stored opacities unchanged.
    params.with(|p| (p.soft_shadow, p.study.view_slant) = (false, SlantForm::Printed))
}

fn picture(gpu: &Gpu, params: &FrameParams, opacity: u8, shading: Shading, groom: &PlaneGroom) -> Picture {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let package = groomed_plane(LAYERS, opacity, shading, groom);
    let plane = Instance::new(0, &renderer.load_bytes(&package).unwrap());
    draw(gpu, &mut renderer, params, &[&plane])
}

/// Returns light whose terms sum to 1. The bare style then does not compress highlights, so that bare surfaces look the
/// same in both styles.
fn even_light() -> Shading {
    Shading { ambient: [0.35; 3], diffuse: [0.65; 3], ..Shading::default() }
}

fn plain(gpu: &Gpu, groom: &PlaneGroom) -> Picture {
    picture(gpu, &above(), OPACITY, even_light(), groom)
}

fn bare(gpu: &Gpu) -> Picture {
    let params = above().with(|p| p.style = Style::Bare);
    picture(gpu, &params, OPACITY, even_light(), &PlaneGroom::default())
}

#[test]
fn bare_vertices_show_the_skin() {
    let Some(gpu) = gpu("bare_vertices_show_the_skin") else { return };
    let furry = plain(gpu, &PlaneGroom::default());
    let bald = plain(gpu, &PlaneGroom { vertex: [255, 0], ..PlaneGroom::default() });
    assert!(difference(&bald, &bare(gpu)).mean < 0.5, "{:?}", difference(&bald, &bare(gpu)));
    assert!(difference(&bald, &furry).mean > 5.0, "the mask has no effect");
    let half = plain(gpu, &PlaneGroom { vertex: [128, 0], ..PlaneGroom::default() });
    let green = [&furry, &half, &bald].map(|p| p.mean(1));
    let between = green[0].min(green[2])..green[0].max(green[2]);
    assert!(between.contains(&green[1]), "furry, half and bald: {green:?}");
}

#[test]
fn bare_texels_show_the_skin_and_others_the_fur() {
    let Some(gpu) = gpu("bare_texels_show_the_skin_and_others_the_fur") else { return };
    // Each half of the texture has two texels, so that filtering has no effect at the sampled points.
    let texels = vec![[0, 0], [0, 0], [255, 0], [255, 0]];
    let left_bare = PlaneGroom { texture: Some((4, texels)), ..PlaneGroom::default() };
    let masked = plain(gpu, &left_bare);
    let (furry, bald) = (plain(gpu, &PlaneGroom::default()), bare(gpu));
    // The sampled points are away from the middle and the border, where the filter mixes both halves.
    for (x, expected, name) in [(16, &bald, "bald"), (48, &furry, "furry")] {
        for y in [8, 32, 56] {
            let at = y * SIZE.0 as usize + x;
            let found = masked.rgba[at].iter().zip(expected.rgba[at]).map(|(a, b)| a.abs_diff(b)).max();
            assert!(found <= Some(2), "{x}, {y}: {:?}, expected as {name}: {:?}", masked.rgba[at], expected.rgba[at]);
        }
    }
}

#[test]
fn wetness_interpolates_between_dry_and_wet_hair() {
    let Some(gpu) = gpu("wetness_interpolates_between_dry_and_wet_hair") else { return };
    let shading = Shading { specular: [0.4; 3], ..Shading::default() };
    let wet_opacity = 20;
    let (dry, wet) = (OPACITY, Some(wet_opacity));
    let draw = |vertex: [u8; 2], texture: Option<(u32, Vec<[u8; 2]>)>| {
        picture(gpu, &above(), dry, shading, &PlaneGroom { vertex, texture, wet_opacity: wet, ..PlaneGroom::default() })
    };
    let all_dry = picture(gpu, &above(), dry, shading, &PlaneGroom::default());
    let all_wet = picture(gpu, &above(), wet_opacity, shading.wet(), &PlaneGroom::default());
    assert!(difference(&all_dry, &all_wet).mean > 5.0, "dry and wet look alike");
    for (name, found, expected) in [
        ("dry vertices", draw([0, 0], None), &all_dry),
        ("wet vertices", draw([0, 255], None), &all_wet),
        ("wet texels", draw([0, 0], Some((1, vec![[255, 255]]))), &all_wet),
        ("half from each", draw([0, 128], Some((1, vec![[255, 128]]))), &all_wet),
    ] {
        let found = difference(&found, expected);
        assert!(found.mean < 0.5, "{name}: {found:?}");
    }
}

#[test]
fn lean_moves_the_outer_layers_along_the_comb_direction() {
    let Some(gpu) = gpu("lean_moves_the_outer_layers_along_the_comb_direction") else { return };
    // In this view from the right, the bitangent +y is up: fully leaning fur 25 mm high must reach 25 mm beyond the
    // plane's edge.
    let projection = Projection::Orthographic { height_m: 0.3, aspect: 1.0, near_m: 0.0, far_m: 4.0 };
    let params = FrameParams::new(Camera::look_at(Vec3::new(2.0, 0.0, 0.9), Vec3::ZERO, projection), SIZE.into());
    let rows = |lean: f32| {
        let picture = picture(gpu, &params, 255, Shading::default(), &PlaneGroom { lean, ..PlaneGroom::default() });
        let covered = |row: &[[u8; 4]]| row.iter().any(|p| p[3] > 0);
        let mut rows = picture.rgba.chunks_exact(SIZE.0 as usize);
        (rows.position(covered).unwrap(), rows.filter(|row| covered(row)).count())
    };
    let (upright, leaned) = (rows(0.0), rows(1.0));
    let per_row_m = 0.3 / SIZE.1 as f32;
    let moved = (upright.0 as f32 - leaned.0 as f32) * per_row_m;
    assert!(
        (moved - 0.025).abs() < 1.5 * per_row_m,
        "the upper edge moved by {moved} m, from {upright:?} to {leaned:?}"
    );
}
