//! Tests of the levels of detail: passes drawn, similarity to all layers, and smooth transitions.
#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_formats::meaning::srgb_to_linear;
use pelage_runtime::glam::{Mat4, Vec3};
use pelage_runtime::{
    Camera, Detail, FrameParams, FrameReport, FurParams, HairGeometry, Instance, Projection, Renderer, RendererOptions,
    Style,
};
use pelage_stage::Gpu;
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::packages::with_manifest;
use pelage_tests::pictures::{Picture, draw};
use pelage_tests::silhouette::bake_plain;
use pelage_truth::compare::compare;

const SIZE: (u32, u32) = (200, 200);
const FOV_RAD: f32 = 0.5;

fn baked(name: &str) -> Vec<u8> {
    let model = workspace().join(format!("assets/models/{name}.glb"));
    bake_plain(&model, Some(&format!("assets/recipes/{name}.toml")), &[])
}

/// Package on the device, viewed from its front left.
struct Stage<'a> {
    gpu: &'a Gpu,
    renderer: Renderer,
    instance: Instance,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu, package: &[u8]) -> Self {
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
        let model = renderer.load_bytes(package).unwrap();
        Self { gpu, renderer, instance: Instance::new(0, &model) }
    }

    /// Returns frame parameters. `distance` is relative to the distance from which the model fills the picture.
    fn params(&self, distance: f32, detail: Detail) -> FrameParams {
        let bounds = &self.instance.model.manifest().bounds;
        let center = Vec3::from(bounds.center);
        let away = bounds.radius / (0.5 * FOV_RAD).sin() * distance;
        let eye = center + Vec3::new(0.62, 0.28, 0.73).normalize() * away;
        let projection =
            Projection::Perspective { fov_y_rad: FOV_RAD, aspect: 1.0, near_m: 0.01 * away, far_m: 10.0 * away };
        // Layers are forced, because strands would replace them at close range.
        let layers = |fur: &mut FurParams| (fur.detail, fur.hair) = (detail, HairGeometry::Shells);
        FrameParams::new(Camera::look_at(eye, center, projection), SIZE.into()).with_fur(layers)
    }

    fn draw(&mut self, distance: f32, detail: Detail) -> Picture {
        let params = self.params(distance, detail);
        draw(self.gpu, &mut self.renderer, &params, &[&self.instance])
    }

    fn report(&mut self, params: &FrameParams) -> FrameReport {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let frame = self.renderer.prepare(&mut encoder, params, [&self.instance]).unwrap();
        self.gpu.queue.submit([encoder.finish()]);
        frame.report().clone()
    }
}

const AUTO: Detail = Detail::Auto { bias: 1.0 };

/// Returns the sum of the opacities, and the mean linear luminance of the covered texels.
fn coverage_and_luminance(picture: &Picture) -> (f64, f64) {
    let (mut coverage, mut light) = (0.0, 0.0);
    for [r, g, b, a] in &picture.rgba {
        let [r, g, b] = [r, g, b].map(|v| f64::from(srgb_to_linear(*v)));
        coverage += f64::from(*a) / 255.0;
        light += 0.2126 * r + 0.7152 * g + 0.0722 * b;
    }
    (coverage, light / coverage)
}

/// Returns the mean absolute difference of opacity over the covered texels.
fn opacity_difference(a: &Picture, b: &Picture) -> f64 {
    let apart = a.rgba.iter().zip(&b.rgba).map(|(p, q)| f64::from(p[3].abs_diff(q[3])) / 255.0).sum::<f64>();
    apart / coverage_and_luminance(a).0
}

/// Returns the relative differences of coverage and luminance from the picture with all layers, and the difference of
/// opacity.
fn relative_differences(full: &Picture, other: &Picture) -> [f64; 3] {
    let ((c0, l0), (c1, l1)) = (coverage_and_luminance(full), coverage_and_luminance(other));
    [c1 / c0 - 1.0, l1 / l0 - 1.0, opacity_difference(full, other)]
}

#[test]
fn levels_of_detail_look_like_all_layers() {
    let Some(gpu) = gpu("levels_of_detail_look_like_all_layers") else { return };
    for name in ["hare", "knot", "torus"] {
        let bytes = baked(name);
        let mut stage = Stage::new(gpu, &bytes);
        let levels = stage.instance.model.manifest().detail.clone();
        assert_eq!(levels.iter().map(|l| l.step).collect::<Vec<_>>(), [1, 2, 4, 0], "{name}");
        // In the naive form, opacities have no exponents: the remaining layers keep their own opacity.
        let naive = with_manifest(&bytes, |m| m.detail[1].density = 1.0 / m.detail[1].step as f32);
        let mut naive = Stage::new(gpu, &naive);
        for distance in [1.0, 2.0, 4.0] {
            let full = stage.draw(distance, Detail::Full);
            let at = |stage: &mut Stage<'_>, level| {
                let found = relative_differences(&full, &stage.draw(distance, Detail::Level(level)));
                println!("{name} at {distance}, level {level}: {found:.4?}");
                found
            };
            let [half, quarter, fading, coat] = [1.0, 2.0, 2.5, 3.0].map(|level| at(&mut stage, level));
            assert!(half[0].abs() < 0.01 && half[1].abs() < 0.05 && half[2] < 0.02, "{name} at {distance}: {half:?}");
            assert!(
                quarter[0].abs() < 0.04 && quarter[1].abs() < 0.14 && quarter[2] < 0.04,
                "{name} at {distance}: {quarter:?}"
            );
            assert!(
                fading[0].abs() < 0.05 && fading[1].abs() < 0.17 && fading[2] < 0.05,
                "{name} at {distance}: {fading:?}"
            );
            assert!(coat[0].abs() < 0.03 && coat[1].abs() < 0.3 && coat[2] < 0.08, "{name} at {distance}: {coat:?}");
            // Negative control: without exponents, coverage or luminance must be lost.
            let lost = at(&mut naive, 1.0);
            assert!(lost[1] < -0.03 || lost[0] < -0.01, "{name} at {distance}: without exponents: {lost:?}");
        }
    }
}

/// Returns the largest FLIP between consecutive frames while the camera moves away in small steps.
fn largest_flip_step(stage: &mut Stage<'_>, detail: Detail, steps: impl Iterator<Item = f32>) -> f64 {
    let opaque = |picture: Picture| {
        let texels = picture.rgba.iter().flat_map(|[r, g, b, _]| [*r, *g, *b, 255]).collect();
        image::RgbaImage::from_raw(SIZE.0, SIZE.1, texels).unwrap()
    };
    let frames: Vec<_> = steps.map(|distance| opaque(stage.draw(distance, detail))).collect();
    let flip = |pair: &[image::RgbaImage]| compare(&pair[0], &pair[1], [0; 3]).unwrap().0.flip.mean;
    frames.windows(2).map(flip).fold(0.0, f64::max)
}

#[test]
fn level_changes_do_not_pop_while_the_camera_recedes() {
    let Some(gpu) = gpu("level_changes_do_not_pop_while_the_camera_recedes") else { return };
    let bytes = baked("hare");
    let mut stage = Stage::new(gpu, &bytes);
    let levels = stage.instance.model.manifest().detail.clone();
    // In the naive form, each level switches abruptly in the middle of its fade.
    let hard = with_manifest(&bytes, |m| {
        for level in &mut m.detail {
            level.full_px = (level.full_px * level.gone_px).sqrt();
            level.gone_px = level.full_px;
        }
    });
    let mut hard = Stage::new(gpu, &hard);
    let fur_px = |stage: &mut Stage<'_>, distance| {
        let params = stage.params(distance, AUTO);
        stage.report(&params).instances[0].fur_px.unwrap()
    };
    for level in &levels[..levels.len() - 1] {
        // Finds by bisection the distance at which the fur has the given height in pixels.
        let mut find = |px: f32| {
            let (mut near, mut far) = (0.01f32, 100.0f32);
            for _ in 0..40 {
                let middle = (near * far).sqrt();
                if fur_px(&mut stage, middle) > px { near = middle } else { far = middle }
            }
            near
        };
        // The steps are around the beginning, the middle and the end of the fade. They are so small that the camera's
        // motion itself hardly changes the picture.
        let middle_px = (level.full_px * level.gone_px).sqrt();
        let middles = [level.full_px, middle_px, level.gone_px].map(&mut find);
        let largest = |stage: &mut Stage<'_>, detail| {
            let steps = |at: f32| (-4..=4).map(move |i| at * 1.001f32.powi(i));
            let found = middles.map(|at| largest_flip_step(stage, detail, steps(at)));
            println!("beginning, middle and end: {found:.5?}");
            found.into_iter().fold(0.0, f64::max)
        };
        let without = largest(&mut stage, Detail::Full);
        let with = largest(&mut stage, AUTO);
        let switched = largest(&mut hard, AUTO);
        println!(
            "from {:.2} to {:.2} px: largest FLIP between frames {without:.5} without levels, \
             {with:.5} with, {switched:.5} switched at once",
            level.full_px, level.gone_px
        );
        assert!(with < 1.5 * without, "step {}: FLIP {with} with levels, {without} without", level.step);
        assert!(
            switched > 1.25 * with,
            "step {}: FLIP {switched} when switched at once, {with} when faded: the switch was not detected",
            level.step
        );
    }
}

#[test]
fn small_animals_use_fewer_layers_and_passes() {
    let Some(gpu) = gpu("small_animals_use_fewer_layers_and_passes") else { return };
    let mut stage = Stage::new(gpu, &baked("hare"));
    let mut at = |distance| {
        let params = stage.params(distance, AUTO);
        stage.report(&params)
    };
    let ran = |report: &FrameReport| {
        let ran = report.passes.iter().filter(|p| p.ran).map(|p| p.name);
        ran.filter(|name| *name != "pose").collect::<Vec<_>>().join(" ")
    };
    let (large, middle, small) = (at(0.3), at(2.0), at(20.0));
    let layers = |report: &FrameReport| report.instances[0].layers;
    assert_eq!((layers(&large), layers(&middle), layers(&small)), (15, 3, 0));
    assert_eq!(ran(&large), "layer_shadow shadow_width skin shells");
    // The shadow map drawn for all layers has the number of layers that this level requires, so it is reused.
    assert_eq!(ran(&middle), "skin shells");
    let triangles = |report: &FrameReport| report.instances[0].triangles;
    assert!(triangles(&large) == triangles(&middle) && triangles(&middle) > 2 * triangles(&small));
    assert_eq!(ran(&small), "shadow_width skin");
    let reason = |report: &FrameReport, name| report.passes.iter().find(|p| p.name == name).unwrap().reason.clone();
    assert_eq!(reason(&large, "shells"), "1 instances, 15 layers");
    assert_eq!(reason(&middle, "shells"), "1 instances, 3 of 15 layers");
    assert_eq!(reason(&large, "layer_shadow"), "one map of 2 layers, 512 x 512");
    assert_eq!(reason(&middle, "layer_shadow"), "light, poses and models are unchanged");
    assert!(
        reason(&small, "shells").contains("too small")
            && reason(&small, "layer_shadow").contains("only far fur layers")
    );
    assert!(reason(&small, "skin").contains("1 with the far fur layer"));
}

#[test]
fn near_and_far_instances_are_drawn_in_one_frame() {
    let Some(gpu) = gpu("near_and_far_instances_are_drawn_in_one_frame") else { return };
    let mut stage = Stage::new(gpu, &baked("hare"));
    let params = stage.params(0.3, AUTO);
    let away = Mat4::from_translation(Vec3::new(-0.62, -0.28, -0.73) * 20.0);
    let far = Instance::new(1, &stage.instance.model).at(away);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = stage.renderer.prepare(&mut encoder, &params, [&far, &stage.instance]).unwrap();
    let report = frame.report();
    assert_eq!(report.instances.iter().map(|i| i.layers).collect::<Vec<_>>(), [0, 15]);
    let maps = report.passes.iter().find(|p| p.name == "layer_shadow").unwrap();
    assert!(maps.ran && maps.reason.contains("one map of 2 layers"), "{}", maps.reason);
    let shells = report.passes.iter().find(|p| p.name == "shells").unwrap();
    assert_eq!(shells.reason, "1 instances, 15 of 30 layers");
}

#[test]
fn full_detail_equals_a_package_without_levels() {
    let Some(gpu) = gpu("full_detail_equals_a_package_without_levels") else { return };
    let bytes = baked("hare");
    let plain = with_manifest(&bytes, |m| m.detail.clear());
    let [mut with, mut without] = [&bytes, &plain].map(|package| Stage::new(gpu, package));
    let full = without.draw(1.0, Detail::Full);
    for detail in [Detail::Full, Detail::Level(0.0), Detail::Auto { bias: 1e6 / SIZE.1 as f32 }] {
        assert!(with.draw(1.0, detail) == full, "{detail:?}");
    }
    // A package without levels is drawn in full, whatever level is requested.
    assert!(without.draw(1.0, Detail::Level(2.0)) == full);
    assert!(with.draw(1.0, Detail::Level(1.0)) != full);
    // Bare surfaces do not depend on the level.
    let [bare, same] = [&mut with, &mut without].map(|stage| {
        let params = stage.params(1.0, Detail::Level(2.0)).with(|p| p.style = Style::Bare);
        draw(gpu, &mut stage.renderer, &params, &[&stage.instance])
    });
    assert!(bare == same);
}
