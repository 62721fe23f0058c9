//! Ink painted with strokes: the passes that run, and the fallback to pixels.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Vec3, vec3};
use pelage_runtime::formats::{Limits, Package, Tag};
use pelage_runtime::{Camera, FrameParams, FrameReport, InkLines, InkParams, Instance, Renderer, RendererOptions};
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::packages::without_sections;
use pelage_tests::silhouette::bake_plain;

const QUICK: [&str; 4] = ["slice.layers=4", "slice.tile_texels=64", "fins.enabled=false", "hair.density=50"];
const SIZE: [u32; 2] = [240, 160];

/// Passes of each form of the lines that always run.
const PIXELS: [&str; 3] = ["ink_normals", "ink_features", "ink_composite"];
const STROKES: [&str; 3] = ["painting_depth", "painting_strokes", "painting_sheet"];

#[test]
fn packages_without_strokes_are_painted_in_pixels() {
    let Some(gpu) = gpu("packages_without_strokes_are_painted_in_pixels") else { return };
    let full = bake_plain(&workspace().join("assets/models/hare.glb"), Some("assets/recipes/hare.toml"), &QUICK);
    let older = without_sections(&full, &[Tag::STROKES, Tag::CONTOURS]);
    let bounds = Package::open(&full, &Limits::default()).unwrap().manifest().bounds;
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let camera = Camera::framing(Vec3::from(bounds.center), bounds.radius, vec3(0.9, 0.25, 0.5), 0.5, aspect);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let [full, older] = [full, older].map(|bytes| renderer.load_bytes(&bytes).unwrap());
    let mut report = |packages: &[&_], lines| -> FrameReport {
        let instances: Vec<_> = packages.iter().enumerate().map(|(k, model)| Instance::new(k as u64, model)).collect();
        let params = FrameParams::new(camera, SIZE).with_ink(InkParams::default().with(|ink| ink.lines = lines));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let report = renderer.prepare(&mut encoder, &params, &instances).unwrap().report().clone();
        gpu.queue.submit([encoder.finish()]);
        report
    };
    let pass = |report: &FrameReport, name| report.passes.iter().find(|p| p.name == name).unwrap().clone();
    let painted = report(&[&full], InkLines::Strokes);
    for (name, ran) in PIXELS.map(|name| (name, false)).into_iter().chain(STROKES.map(|name| (name, true))) {
        let found = pass(&painted, name);
        assert_eq!(found.ran, ran, "{found:?}");
        assert!(ran || found.reason == "ink is painted with strokes", "{found:?}");
    }
    for (packages, lines) in [
        (&[&older][..], InkLines::Strokes),
        // A single package without strokes changes the form of the whole frame.
        (&[&full, &older], InkLines::Strokes),
        (&[&full], InkLines::Pixels),
    ] {
        let fallback = report(packages, lines);
        for (name, ran) in PIXELS.map(|name| (name, true)).into_iter().chain(STROKES.map(|name| (name, false))) {
            let found = pass(&fallback, name);
            assert_eq!(found.ran, ran, "{found:?}");
            assert!(ran || found.reason.contains("a package or the device lacks what strokes need"), "{found:?}");
        }
    }
}
