//! Tests of the fins pass: where it draws, how opaque fins are, and that it costs nothing elsewhere.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::{Mat4, Quat, Vec3};
use pelage_runtime::shared::fins::fin_opacity;
use pelage_runtime::{
    Camera, FrameParams, FrameReport, Instance, Motion, PassId, Projection, Renderer, RendererOptions, Style, wgpu,
};
use pelage_stage::{Canvas, Gpu};
use pelage_tests::gpu::gpu;
use pelage_tests::packages::{ALPHA, with_fins};
use pelage_tests::pictures::{draw, draw_passes, draw_with_statistics};
use pelage_tests::plane::plane;
use pelage_tests::silhouette::half_to_f32;
use pelage_tests::support::sphere::{self, SphereParams};

const SIZE: (u32, u32) = (64, 64);
/// Returns the plane at z = 0 with one fin, on the edge along y at x = −0.1.
fn plane_with_a_fin() -> Vec<u8> {
    with_fins(&plane(4, 0), &[(0, 3)])
}

fn renderer(gpu: &Gpu) -> Renderer {
    let options = RendererOptions { color_format: wgpu::TextureFormat::Rgba16Float, ..RendererOptions::default() };
    Renderer::new(&gpu.device, &gpu.queue, &options).unwrap()
}

/// Returns a camera that looks at the middle of the fin, perpendicular to it, from the given angle above the plane.
fn params(above_deg: f32) -> FrameParams {
    let eye = Quat::from_rotation_y(-above_deg.to_radians()) * Vec3::NEG_X;
    let target = Vec3::new(-0.1, 0.0, 0.0);
    let projection = Projection::Orthographic { height_m: 0.08, aspect: 1.0, near_m: 0.0, far_m: 3.0 };
    FrameParams::new(Camera::look_at(target + eye, target, projection), SIZE.into())
}

/// Returns the opacity of every pixel after the given passes have been drawn.
fn opacities(gpu: &Gpu, instance: &Instance, params: &FrameParams, passes: &[PassId]) -> Vec<f32> {
    let texels = draw_passes(gpu, &mut renderer(gpu), params, &[instance], passes);
    texels.chunks_exact(8).map(|t| half_to_f32([t[6], t[7]])).collect()
}

#[test]
fn fin_opacity_follows_the_viewing_angle() {
    let Some(gpu) = gpu("fin_opacity_follows_the_viewing_angle") else { return };
    let model = renderer(gpu).load_bytes(&plane_with_a_fin()).unwrap();
    let instance = Instance::new(0, &model);
    for degrees in [0.0f32, 20.0, 45.0, 55.0, 60.5, 75.0, 90.0, -30.0, 135.0, 180.0] {
        let alphas = opacities(gpu, &instance, &params(degrees), &[PassId::FINS]);
        let expected = fin_opacity(degrees.to_radians().cos()) * f32::from(ALPHA) / 255.0;
        let most = alphas.iter().copied().fold(0.0, f32::max);
        assert!((most - expected).abs() < 0.004, "at {degrees} degrees: {most}, expected {expected}");
        if expected > 0.01 {
            // The fin must be as high as the fur. Its edge is longer than the picture is wide, so it crosses the whole
            // picture.
            let covered = alphas.iter().filter(|a| **a > 0.5 * expected).count() as f32 / alphas.len() as f32;
            let height = model.manifest().fur.height_m * degrees.to_radians().cos().abs() / 0.08;
            assert!((covered - height).abs() < 0.03, "at {degrees} degrees: {covered}, expected {height}");
        }
    }
}

/// Checks that a fin fades smoothly while the camera turns. Per degree, its opacity must change by at most twice the
/// change of the cosine.
#[test]
fn fins_do_not_pop() {
    let Some(gpu) = gpu("fins_do_not_pop") else { return };
    let model = renderer(gpu).load_bytes(&plane_with_a_fin()).unwrap();
    let instance = Instance::new(0, &model);
    let most =
        |degrees: f32| opacities(gpu, &instance, &params(degrees), &[PassId::FINS]).into_iter().fold(0.0, f32::max);
    let turn: Vec<_> = (40..80).map(|degrees| most(degrees as f32)).collect();
    assert!(turn[0] > 0.2 && turn[39] == 0.0, "{turn:?}");
    let step = 2.0 * 1f32.to_radians() * f32::from(ALPHA) / 255.0 + 0.002;
    assert!(turn.windows(2).all(|w| (0.0..step).contains(&(w[0] - w[1]))), "more than {step} at once: {turn:?}");
}

/// Checks that invisible fins produce no fragments, if the device can count them.
#[test]
fn faded_fins_cost_no_fragments() {
    if gpu("faded_fins_cost_no_fragments").is_none() {
        return;
    }
    let gpu = Gpu::with(wgpu::Features::PIPELINE_STATISTICS_QUERY, Some(wgpu::Limits::default())).unwrap();
    let mut renderer = renderer(&gpu);
    let model = renderer.load_bytes(&plane_with_a_fin()).unwrap();
    let instance = Instance::new(0, &model);
    let mut count = |degrees: f32| {
        let targets = Canvas::new(&gpu, SIZE, &renderer.options().into());
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let frame = renderer.prepare(&mut encoder, &params(degrees), [&instance]).unwrap();
        draw_with_statistics(&gpu, &targets, encoder, |pass| frame.draw_pass(PassId::FINS, pass)).fragments
    };
    assert!(count(0.0) > 500, "the query must count fragments");
    for degrees in [60.5, 75.0, 90.0, 100.0] {
        assert_eq!(count(degrees), 0, "at {degrees} degrees");
    }
}

/// Returns the report of a frame: which passes ran, and why.
fn report(gpu: &Gpu, bytes: &[u8], params: &FrameParams) -> FrameReport {
    let mut renderer = renderer(gpu);
    let instance = Instance::new(0, &renderer.load_bytes(bytes).unwrap());
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    renderer.prepare(&mut encoder, params, [&instance]).unwrap().report().clone()
}

#[test]
fn report_states_whether_and_why_fins_ran() {
    let Some(gpu) = gpu("report_states_whether_and_why_fins_ran") else { return };
    let (bald, finned) = (plane(4, 0), plane_with_a_fin());
    let plain = params(0.0);
    let of = |bytes: &[u8], params: &FrameParams| {
        let report = report(gpu, bytes, params);
        let names: Vec<_> = report.passes.iter().map(|p| p.name).collect();
        assert_eq!(names, PassId::all().map(PassId::name).collect::<Vec<_>>());
        let fins = report.passes.iter().find(|p| p.name == PassId::FINS.name()).unwrap();
        (fins.ran, fins.reason.clone())
    };
    assert_eq!(of(&finned, &plain), (true, "1 instances, 1 edges".into()));
    assert_eq!(of(&bald, &plain), (false, "no package has fins".into()));
    assert_eq!(of(&finned, &plain.clone().with_fur(|f| f.fins = false)), (false, "switched off".into()));
    let skin = plain.clone().with_fur(|f| f.layers = Some(1));
    assert_eq!(of(&finned, &skin), (false, "the only layer is the skin".into()));
    let bare = plain.with(|p| p.style = Style::Bare);
    assert_eq!(of(&finned, &bare), (false, "style is bare".into()));
}

/// Checks that fins only add to the picture: everything around them is drawn as without fins.
#[test]
fn package_without_fins_draws_unchanged() {
    let Some(gpu) = gpu("package_without_fins_draws_unchanged") else { return };
    let bald = sphere::package(&SphereParams { quads: 8, texels: 16, strands: 60, ..SphereParams::default() });
    let params = FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0), SIZE.into());
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let mut picture = |bytes: &[u8], fins: bool| {
        let instance = Instance::new(0, &renderer.load_bytes(bytes).unwrap());
        draw(gpu, &mut renderer, &params.clone().with_fur(|f| f.fins = fins), &[&instance])
    };
    let plain = picture(&bald, false);
    assert_eq!(picture(&bald, true), plain);
    let finned = with_fins(&bald, &[(0, 1), (1, 2), (9, 10)]);
    assert_eq!(picture(&finned, false), plain);
}

/// Checks that fins follow the posed mesh surface and the transform of the instance.
#[test]
fn fins_follow_the_pose_and_the_instance() {
    let Some(gpu) = gpu("fins_follow_the_pose_and_the_instance") else { return };
    let quads = 8;
    let params = SphereParams { quads, texels: 16, strands: 60, skeleton: true, ..SphereParams::default() };
    // The fins are on the rows of quads of the first cube face of the sphere. These rows are viewed along their length.
    let row = |j: u32| (0..quads).map(move |i| (j * (quads + 1) + i, j * (quads + 1) + i + 1));
    let edges: Vec<_> = (0..=quads).flat_map(row).collect();
    let model = renderer(gpu).load_bytes(&with_fins(&sphere::package(&params), &edges)).unwrap();
    let look = |eye: Vec3| FrameParams::new(Camera::framing(Vec3::ZERO, 0.16, eye, 0.6, 1.0), SIZE.into());
    let drawn = |instance: &Instance, params: &FrameParams| opacities(gpu, instance, params, &[PassId::FINS]);

    let rest = Instance::new(0, &model);
    let above = look(Vec3::Y);
    let plain = drawn(&rest, &above);
    let sum = |alphas: &[f32]| alphas.iter().sum::<f32>();
    assert!(sum(&plain) > 5.0, "{}", sum(&plain));
    let bent = Instance::new(0, &model).moving(Motion::Clip { clip: 0, time_s: 0.5 });
    let moved = drawn(&bent, &above);
    let apart: f32 = plain.iter().zip(&moved).map(|(a, b)| (a - b).abs()).sum();
    assert!(apart > 0.2 * sum(&plain), "the clip moves the fins: {apart}");

    // Checks that the picture is the same if instance and camera are rotated together.
    let turned = Instance::new(0, &model).at(Mat4::from_rotation_z(-std::f32::consts::FRAC_PI_2));
    let mut beside = above.clone();
    beside.camera.view_from_world *= turned.transform.inverse();
    let same = drawn(&turned, &beside);
    let apart: f32 = plain.iter().zip(&same).map(|(a, b)| (a - b).abs()).sum();
    assert!(apart < 0.02 * sum(&plain), "turned with the camera: {apart} of {}", sum(&plain));
}
