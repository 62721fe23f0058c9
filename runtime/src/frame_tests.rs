//! Tests that adding a pass takes only one folder and one line of the pass list. [`crate::passes::probe`] is a pass
//! that exists only in these tests.

use crate::camera::{Camera, Projection};
use crate::frame::PASSES;
use crate::instance::Instance;
use crate::params::{FrameParams, RendererOptions, Style};
use crate::passes::PassId;
use crate::passes::probe::COLOR;
use crate::renderer::Renderer;
use glam::{Mat4, Vec3};
use pelage_needs::{Need, gpu_is_wanted, log_available};
use pelage_stage::{Canvas, CanvasOptions, Gpu};
use std::path::{Path, PathBuf};

/// Returns a GPU device for the test `name`; `None` if GPU tests are switched off.
pub fn gpu(name: &str) -> Option<Gpu> {
    if !gpu_is_wanted(name) {
        return None;
    }
    let gpu = Gpu::with(wgpu::Features::empty(), Some(wgpu::Limits::default())).unwrap();
    log_available(Need::Gpu, name, &gpu.info.name);
    Some(gpu)
}

#[test]
fn a_pass_that_is_added_is_drawn_reported_and_listed() {
    let Some(gpu) = gpu("an_added_pass") else { return };
    let options = RendererOptions::default();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, Projection::Custom(Mat4::IDENTITY));
    // The fixture links this crate as other crates do, not as a test build.
    let RendererOptions { color_format, depth_format, sample_count, reversed_depth, .. } = options;
    let canvas = CanvasOptions { color_format, depth_format, sample_count, reversed_depth };
    let targets = Canvas::new(&gpu, (8, 8), &canvas);
    let mut draw = |style| {
        let params = FrameParams::new(camera, [8, 8]).with(|params| params.style = style);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &params, std::iter::empty::<Instance>()).unwrap();
        frame.draw(&mut targets.pass(&mut encoder, "application", Some(wgpu::Color::BLACK)));
        gpu.queue.submit([encoder.finish()]);
        let report = frame.report().passes.last().unwrap().clone();
        (targets.texels(&gpu).unwrap(), report)
    };
    let (texels, report) = draw(Style::Bare);
    let green = COLOR.map(|c| (c * 255.0) as u8);
    assert_eq!((report.name, report.ran, &report.reason[..]), ("probe", true, "in a test"));
    assert!(texels.chunks_exact(4).all(|texel| texel == green), "{texels:?}");
    let (texels, report) = draw(Style::default());
    assert_eq!((report.ran, &report.reason[..], &texels[..4]), (false, "style is fur", &[0, 0, 0, 255][..]));
    assert_eq!(PassId::all().next_back(), Some(PassId::PROBE));
    let names: std::collections::BTreeSet<_> = PassId::all().map(PassId::name).collect();
    assert_eq!(names.len(), PASSES.len(), "no two passes share a name");
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { files(&path, found) } else { found.push(path) }
    }
}

/// Checks the references to the probe outside its folder: one line of the pass list, and the declaration of its module.
#[test]
fn adding_a_pass_takes_one_folder_and_one_line() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    files(&source, &mut all);
    let mut lines = Vec::new();
    for file in all.iter().filter(|f| !f.starts_with(source.join("passes/probe")) && !f.ends_with("frame_tests.rs")) {
        let text = std::fs::read_to_string(file).unwrap();
        let name = file.strip_prefix(&source).unwrap().display().to_string();
        lines.extend(text.lines().filter(|l| l.contains("probe")).map(|line| format!("{name}: {}", line.trim())));
    }
    lines.sort();
    assert_eq!(lines, ["frame.rs: &probe::PASS,", "passes/mod.rs: pub(crate) mod probe;"]);
    // Each production pass is a folder with its shader beside its Rust file.
    for pass in PASSES {
        let folder = source.join("passes").join(pass.name);
        assert!(folder.join("mod.rs").is_file(), "{}", folder.display());
        let mut inside = Vec::new();
        files(&folder, &mut inside);
        assert!(inside.iter().any(|f| f.extension().is_some_and(|e| e == "wgsl")), "{}", folder.display());
        assert!(!pass.shaders.is_empty() && !pass.does.is_empty() && !pass.runs_when.is_empty());
    }
}

/// Checks that buffers, textures, bind groups and pipelines are created only in functions that count them. Otherwise a
/// frame could not report how many objects it created.
#[test]
fn gpu_resources_are_created_only_in_counted_places() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    files(&source, &mut all);
    let made =
        ["create_buffer", "create_texture", "create_bind_group(", "create_render_pipeline", "create_compute_pipeline"];
    let mut rooms: Vec<String> = all
        .iter()
        .filter(|f| {
            f.extension().is_some_and(|e| e == "rs") && !f.ends_with("frame_tests.rs") && !f.ends_with("swing_tests.rs")
        })
        .filter(|f| made.iter().any(|call| std::fs::read_to_string(f).unwrap().contains(call)))
        .map(|f| f.strip_prefix(&source).unwrap().display().to_string())
        .collect();
    rooms.sort();
    // The texture in `surface/mod.rs` is the white texel, which is created once, together with the renderer.
    assert_eq!(rooms, ["gpu/device.rs", "surface/mod.rs"]);
}
