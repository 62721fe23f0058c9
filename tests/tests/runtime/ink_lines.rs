//! Compares ink lines with the lines of the mesh: position, shape and stability.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Mat4, Vec3, vec3};
use pelage_bake::strands::PosedMesh;
use pelage_lab::chart::ink::{InkSettings, on_blank_paper, template_px};
use pelage_lab::compare_motion::{Flicker, FlickerFrame, MeanOf, flicker};
use pelage_lab::mask::Mask;
use pelage_needs::data;
use pelage_runtime::ClipLayer;
use pelage_runtime::formats::{Limits, Package};
use pelage_runtime::{
    Anchoring, Camera, FrameParams, InkDebugView, InkParams, Instance, Motion, PassId, Renderer, RendererOptions, Study,
};
use pelage_stage::Gpu;
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::draw_passes;
use pelage_tests::schema;
use pelage_tests::silhouette::bake_plain;
use pelage_truth::{Lens, SurfaceVisibility, TrueCamera};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Bake settings with little fur: fur takes long to bake, and ink does not use it.
const QUICK: [&str; 4] = ["slice.layers=4", "slice.tile_texels=64", "fins.enabled=false", "hair.density=50"];

/// Returns the path of one of the project's own models.
fn built_in_model(name: &str) -> PathBuf {
    workspace().join(format!("assets/models/{name}.glb"))
}

/// Returns the path of a model in the test data, for the named test.
fn data_model(test: &str, path: &str) -> Option<PathBuf> {
    data(test).map(|data| data.join("meshes").join(path))
}

/// Returns the rows `rows` of `pelage chart ink` for a model.
fn chart(model: &Path, rows: &str) -> Vec<Value> {
    let sandbox = Sandbox::new().with_lab();
    let mut args = vec!["chart", "ink", model.to_str().unwrap(), "--rows", rows, "-o", "out", "--json", "-q"];
    let plain = ["pack.shell_format=rgba8", "pack.direction_format=rg8", "pack.base_color_format=rgba8"];
    args.extend(plain.iter().chain(&QUICK).flat_map(|set| ["--set", set]));
    let run = sandbox.run(&args);
    schema::parse_success(&run, "chart")["rows"].as_array().unwrap().clone()
}

fn number(row: &Value, column: &str) -> f64 {
    row[column].as_f64().unwrap_or_else(|| panic!("no {column}: {row}"))
}

/// Minimum precision and recall within two pixels, at default settings.
const BAR: f64 = 0.9;

#[track_caller]
fn assert_lines_match_mesh(model: &Path) {
    let name = model.file_stem().unwrap().to_string_lossy().into_owned();
    let rows = chart(model, "1");
    let (precision, recall) = (number(&rows[0], "precision"), number(&rows[0], "recall"));
    println!("{name}: precision {precision:.3}, recall {recall:.3}");
    assert_eq!((&rows[0]["series"], &rows[0]["lines"]), (&"pixels".into(), &"pixels".into()));
    assert!(precision >= BAR && recall >= BAR, "{name}: precision {precision}, recall {recall}");
}

#[test]
fn ink_lines_of_asset_models_match_the_mesh() {
    if gpu("ink_lines_of_asset_models_match_the_mesh").is_none() {
        return;
    }
    ["hare", "knot"].iter().for_each(|name| assert_lines_match_mesh(&built_in_model(name)));
}

#[test]
fn ink_lines_of_known_meshes_match_the_mesh() {
    if gpu("ink_lines_of_known_meshes_match_the_mesh").is_none() {
        return;
    }
    for path in ["static/bunny.obj", "skinned/quaternius_Cow.glb", "skinned/quaternius_Horse.glb"] {
        let Some(model) = data_model("ink_lines_of_known_meshes_match_the_mesh", path) else { return };
        assert_lines_match_mesh(&model);
    }
}

/// Checks that the published rule misses most lines: along a straight edge, the four neighbours of a pixel never all
/// differ.
#[test]
fn published_line_rule_misses_most_lines() {
    if gpu("published_line_rule_misses_most_lines").is_none() {
        return;
    }
    let printed = pelage_lab::chart::ink::configurations();
    let index = printed.iter().position(|c| c.series == "as published").unwrap();
    let rows = chart(&built_in_model("hare"), &(index + 1).to_string());
    assert_eq!((&rows[0]["series"], &rows[0]["rule"]), (&"as published".into(), &"all".into()));
    let recall = number(&rows[0], "recall");
    println!("published rule: recall {recall:.3}");
    assert!(recall < 0.2, "recall {recall}");
}

/// Offscreen renderer for the ink style.
struct InkRenderer {
    gpu: &'static Gpu,
    renderer: Renderer,
    size: (u32, u32),
}

const FOV_Y_RAD: f32 = 0.5;

impl InkRenderer {
    fn new(gpu: &'static Gpu, size: (u32, u32)) -> Self {
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
        Self { gpu, renderer, size }
    }

    /// Draws an ink debug view, and returns its RGBA texels.
    fn draw(&mut self, instance: &Instance, camera: &Camera, study: Study, ink: InkDebugView) -> Vec<[u8; 4]> {
        let blank = on_blank_paper(&InkSettings::default().ink);
        let params = FrameParams::new(*camera, self.size.into()).with_ink(blank);
        let params = params.with(|p| (p.study, p.debug.ink) = (study, ink));
        let passes = [PassId::INK_COMPOSITE];
        let bytes = draw_passes(self.gpu, &mut self.renderer, &params, &[instance], &passes);
        bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
    }

    /// Returns a mask of the line pixels that have less than half of the light of white.
    fn dark(&mut self, instance: &Instance, camera: &Camera, study: Study) -> Mask {
        let pixels = self.draw(instance, camera, study, InkDebugView::Lines).iter().map(|p| p[0] < 188).collect();
        Mask { width: self.size.0, height: self.size.1, pixels }
    }
}

/// Returns the widths of the widest stroke of a package over 24 views, pixels: with the sphere map alone, and with our
/// template.
///
/// * `towards`: returns centre and radius of the framed sphere and the camera's direction, for an angle in radians
fn widest(brush: &mut InkRenderer, package: &[u8], towards: impl Fn(f32) -> (Vec3, f32, Vec3)) -> [f64; 2] {
    let instance = Instance::new(0, &brush.renderer.load_bytes(package).unwrap());
    let mut most = [0.0f64; 2];
    for view in 0..24 {
        let (center, radius, from) = towards(std::f32::consts::TAU * view as f32 / 24.0);
        let aspect = brush.size.0 as f32 / brush.size.1 as f32;
        let camera = Camera::framing(center, radius, from, FOV_Y_RAD, aspect);
        for (most, template) in most.iter_mut().zip([false, true]) {
            let study = Study::default().with(|study| study.template = template);
            *most = most.max(brush.dark(&instance, &camera, study).widest_stroke().width_px);
        }
    }
    most
}

fn bounds(package: &[u8]) -> (Vec3, f32) {
    let opened = Package::open(package, &Limits::default()).unwrap();
    let bounds = opened.manifest().bounds;
    (Vec3::from(bounds.center), bounds.radius)
}

/// Asserts that no stroke is wider than the template, and that strokes of the sphere map alone are wider (Fang 2006,
/// Fig. 3).
#[track_caller]
fn assert_width_limited(name: &str, [alone, ours]: [f64; 2], template: f64) {
    println!("{name}: widest stroke {ours:.1} px, template {template:.1} px, sphere map alone {alone:.1} px");
    assert!(ours <= template, "{name}: {ours} px, template {template} px");
    assert!(alone >= 2.0 * template, "{name}: the sphere map alone makes {alone} px, template {template} px");
}

#[test]
fn strokes_are_no_wider_than_the_template() {
    let Some(gpu) = gpu("strokes_are_no_wider_than_the_template") else { return };
    let mut brush = InkRenderer::new(gpu, (300, 300));
    let hare = bake_plain(&built_in_model("hare"), Some("assets/recipes/hare.toml"), &QUICK);
    let (center, radius) = bounds(&hare);
    let template = template_px(&InkParams::default(), brush.size.1);
    // The camera frames the ears, the top fifth of the hare.
    let ears = center + vec3(0.0, 0.62 * radius, 0.0);
    let found = widest(&mut brush, &hare, |turn| (ears, 0.3 * radius, vec3(turn.sin(), 0.1, turn.cos())));
    assert_width_limited("hare's ears", found, template);
    if let Some(model) = data_model("strokes_are_no_wider_than_the_template", "static/bunny.obj") {
        let bunny = bake_plain(&model, None, &QUICK);
        let (center, radius) = bounds(&bunny);
        let found = widest(&mut brush, &bunny, |turn| (center, radius, vec3(turn.sin(), 0.2, turn.cos())));
        assert_width_limited("bunny", found, template);
    }
}

/// Returns the flicker between frames of a model that walks past, with the given anchoring of wash and lines.
fn walk_flicker(brush: &mut InkRenderer, package: &[u8], clip: &str, anchoring: Anchoring) -> Flicker {
    let opened = Package::open(package, &Limits::default()).unwrap();
    let animation = opened.animation().unwrap().unwrap();
    let names: Vec<_> = animation.clips.iter().map(|c| &c.name).collect();
    let clip = names.iter().position(|name| name.ends_with(clip)).unwrap_or_else(|| panic!("no {clip} in {names:?}"));
    let mut instance = Instance::new(0, &brush.renderer.load_bytes(package).unwrap());
    let (center, radius) = bounds(package);
    let aspect = brush.size.0 as f32 / brush.size.1 as f32;
    let camera = Camera::framing(center, radius, vec3(0.9, 0.2, 0.5), FOV_Y_RAD, aspect);
    let true_camera = TrueCamera::from_view(camera.view_from_world, Lens::Perspective { fov_y_rad: FOV_Y_RAD });
    let mut sum = Flicker::default();
    let mut before: Option<(SurfaceVisibility, Vec<f32>, Mask)> = None;
    for frame in 0..6 {
        let time_s = frame as f32 / 24.0;
        // The model moves 1.5 body lengths per second, nose first.
        let way = vec3(0.0, 0.0, 3.0 * radius * time_s);
        instance.motion = Motion::Clip { clip, time_s };
        instance.transform = Mat4::from_translation(way);
        let mut skin =
            PosedMesh::posed("model", &opened, &[ClipLayer { clip: Some(clip), time_s, share: 1.0 }]).unwrap();
        skin.vertices.iter_mut().for_each(|v| v.position_ws += way.as_dvec3());
        let sight = SurfaceVisibility::new(skin).unwrap();
        let study = Study::default().with(|study| study.anchoring = anchoring);
        let lines = brush.dark(&instance, &camera, study);
        let painting = brush.draw(&instance, &camera, study, InkDebugView::Painting);
        let grey: Vec<f32> = painting.iter().map(|p| f32::from(p[1]) / 255.0).collect();
        if let Some((sight_before, grey_before, lines_before)) = &before {
            let camera = &true_camera;
            let now = FlickerFrame { sight: sight_before, camera, grey: grey_before, lines: lines_before };
            let next = FlickerFrame { sight: &sight, camera, grey: &grey, lines: &lines };
            sum = sum.joined(flicker(&now, &next, brush.size).unwrap());
        }
        before = Some((sight, grey, lines));
    }
    sum
}

/// Checks that wash and lines anchored to the model change half as much between frames as those anchored to the screen.
/// The whole mesh surface counts, including contours that must appear and disappear. Away from lines, hardly any change
/// remains.
#[test]
fn wash_and_lines_move_with_the_model() {
    let Some(gpu) = gpu("wash_and_lines_move_with_the_model") else { return };
    let mut walkers = vec![("ox", built_in_model("ox"), Some("assets/recipes/ox.toml"))];
    walkers.extend(
        data_model("wash_and_lines_move_with_the_model", "skinned/quaternius_Horse.glb")
            .map(|model| ("horse", model, None)),
    );
    let mut brush = InkRenderer::new(gpu, (834, 424));
    for (name, model, recipe) in walkers {
        let package = bake_plain(&model, recipe, &QUICK);
        let [ours, naive] =
            [Anchoring::Surface, Anchoring::Screen].map(|a| walk_flicker(&mut brush, &package, "Walk", a));
        let both = |of: fn(&Flicker) -> MeanOf| [&ours, &naive].map(|flicker| of(flicker).mean().unwrap());
        let [all, wash, lines] = [both(|f| f.surface), both(|f| f.wash), both(|f| f.lines)];
        println!("{name}: flicker on the model and on the screen: {all:.4?}, of wash {wash:.4?}, of lines {lines:.4?}");
        assert!(ours.wash.count > 50_000 && ours.lines.count > 5_000, "{name}: {ours:?}");
        assert!(all[0] <= 0.5 * all[1], "{name}: {all:?}");
        assert!(wash[0] <= 0.25 * wash[1], "{name}, wash: {wash:?}");
        assert!(lines[0] < lines[1], "{name}, lines: {lines:?}");
    }
}
