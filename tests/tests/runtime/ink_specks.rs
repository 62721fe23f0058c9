//! Tests of ink on difficult meshes: lines of dense scans must not break into specks, and fur strokes must touch the
//! body.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Vec3, vec3};
use pelage_lab::chart::ink::{InkSettings, on_blank_paper, template_px};
use pelage_lab::mask::Mask;
use pelage_needs::data;
use pelage_runtime::formats::{InkShading, Limits, Package};
use pelage_runtime::{Camera, FrameParams, InkBackground, InkDebugView, Instance, PassId, Renderer, RendererOptions};
use pelage_stage::Gpu;
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{draw, draw_passes};
use pelage_tests::silhouette::bake_plain;
use pelage_tests::specks::{Specks, detached_px, specks};
use std::path::PathBuf;

const SIZE: (u32, u32) = (834, 424);
/// Number of views, evenly spaced around the model.
const VIEWS: u32 = 6;

/// Returns the path of one of the project's own models.
fn built_in_model(name: &str) -> PathBuf {
    workspace().join(format!("assets/models/{name}.glb"))
}

/// Returns the path of a model in the test data, for the named test.
fn data_model(test: &str, path: &str) -> Option<PathBuf> {
    data(test).map(|data| data.join("meshes").join(path))
}

/// Returns [`VIEWS`] cameras around a package, each of which frames the whole model.
fn cameras(package: &[u8]) -> Vec<Camera> {
    let opened = Package::open(package, &Limits::default()).unwrap();
    let bounds = opened.manifest().bounds;
    let aspect = SIZE.0 as f32 / SIZE.1 as f32;
    let from = |view| {
        let turn = std::f32::consts::TAU * view as f32 / VIEWS as f32;
        vec3(turn.sin(), 0.2, turn.cos())
    };
    (0..VIEWS).map(|view| Camera::framing(Vec3::from(bounds.center), bounds.radius, from(view), 0.5, aspect)).collect()
}

/// Counts the ink in line components that are shorter than three line widths, over all views.
fn short_lines(gpu: &Gpu, package: &[u8]) -> Specks {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let ink = on_blank_paper(&InkSettings::default().ink);
    let shorter_than_px = 3.0 * template_px(&ink, SIZE.1);
    let mut found = Specks::default();
    for camera in cameras(package) {
        let params = FrameParams::new(camera, SIZE.into()).with_ink(ink.clone());
        let params = params.with(|p| p.debug.ink = InkDebugView::Lines);
        let texels = draw_passes(gpu, &mut renderer, &params, &[&instance], &[PassId::INK_COMPOSITE]);
        let pixels = texels.chunks_exact(4).map(|p| p[0] < 188).collect();
        found = found.sum(specks(&Mask { width: SIZE.0, height: SIZE.1, pixels }, shorter_than_px));
    }
    found
}

#[test]
fn ink_lines_of_dense_scans_have_few_specks() {
    let Some(gpu) = gpu("ink_lines_of_dense_scans_have_few_specks") else { return };
    let mut models = vec![("hare", built_in_model("hare"), Some("assets/recipes/hare.toml"), 14.0)];
    for (name, path, most) in
        [("bunny", "static/stanford-bunny-full.obj", 16.0), ("armadillo", "static/armadillo.obj", 36.0)]
    {
        models.extend(
            data_model("ink_lines_of_dense_scans_have_few_specks", path).map(|model| (name, model, None, most)),
        );
    }
    let mut wrong = Vec::new();
    for (name, model, recipe, most) in models {
        // For models without a recipe, fur strokes are disabled, so that only the lines of the bare body are drawn.
        let stone = if recipe.is_none() { &["ink.fur=0"][..] } else { &[] };
        let sets = [&["slice.layers=4", "fins.enabled=false"], stone].concat();
        let found = short_lines(gpu, &bake_plain(&model, recipe, &sets));
        println!("{name}: {:.1} of a thousand ink pixels are in {} specks", found.per_mille(), found.count);
        if found.ink < 10_000 || found.per_mille() > most {
            wrong.push(format!("{name}: {found:?}, at most {most} in a thousand"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}

/// Returns the number of fur stroke pixels that do not touch the body, per thousand pixels of the body.
fn detached_per_mille(gpu: &Gpu, package: &[u8]) -> f64 {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(package).unwrap());
    let shading = Package::open(package, &Limits::default()).unwrap().ink().unwrap().unwrap().info.shading;
    let (mut hanging, mut whole) = (0, 0);
    for camera in cameras(package) {
        let mut covered = |fur: f32| {
            let ink = on_blank_paper(&InkSettings::default().ink).with(|ink| {
                ink.background = InkBackground::Picture;
                ink.shading = Some(InkShading { fur, ..shading });
            });
            let picture = draw(gpu, &mut renderer, &FrameParams::new(camera, SIZE.into()).with_ink(ink), &[&instance]);
            let pixels = picture.rgba.iter().map(|p| p[3] > 64).collect();
            Mask { width: SIZE.0, height: SIZE.1, pixels }
        };
        let (body, all) = (covered(0.0), covered(1.0));
        let fur = Mask { pixels: all.pixels.iter().zip(&body.pixels).map(|(a, b)| *a && !b).collect(), ..all };
        (hanging, whole) = (hanging + detached_px(&fur, &body), whole + body.count());
    }
    1000.0 * hanging as f64 / whole as f64
}

#[test]
fn fur_strokes_are_connected_to_the_body() {
    let Some(gpu) = gpu("fur_strokes_are_connected_to_the_body") else { return };
    let mut models = vec![
        ("hare", built_in_model("hare"), Some("assets/recipes/hare.toml"), "hair.density=300", 0.05),
        ("hare with long hair", built_in_model("hare"), Some("assets/recipes/hare.toml"), "hair.length_m=0.05", 0.8),
    ];
    for (name, path, set, most) in [
        ("fox", "skinned/Fox.glb", "hair.density=300", 0.01),
        ("wolf with long hair", "skinned/quaternius_Wolf.glb", "hair.length_m=0.25", 0.1),
    ] {
        models.extend(
            data_model("fur_strokes_are_connected_to_the_body", path).map(|model| (name, model, None, set, most)),
        );
    }
    let mut wrong = Vec::new();
    for (name, model, recipe, set, most) in models {
        let found = detached_per_mille(gpu, &bake_plain(&model, recipe, &["slice.layers=4", set]));
        println!("{name}: {found:.3} pixels per thousand are detached from the body");
        if found > most {
            wrong.push(format!("{name}: {found}, at most {most} in a thousand"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}
