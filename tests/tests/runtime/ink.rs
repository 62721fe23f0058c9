//! Tests of the ink style: where it paints, and how it combines with the application's own objects.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::InkShading;
use pelage_runtime::glam::{Mat4, Vec3};
use pelage_runtime::{
    Anchoring, Camera, DebugView, FrameParams, InkBackground, InkDebugView, InkParams, Instance, LineWidth, Motion,
    PassId, Projection, Renderer, RendererOptions, SphereMapForm, Study, Style, wgpu,
};
use pelage_stage::{Canvas, Gpu};
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, difference, draw};
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: (u32, u32) = (160, 160);

fn sphere() -> SphereParams {
    SphereParams { quads: 12, texels: 16, strands: 40, ink: true, ..SphereParams::default() }
}

fn from(towards: Vec3) -> FrameParams {
    // Random variation is off, so that the measurement depends only on the geometry.
    let still = InkParams::default().with(|ink| {
        (ink.pressure, ink.dryness, ink.roughness_px, ink.paper_grain) = (0.0, 0.0, 0.0, 0.0);
        ink.width = LineWidth::Pixels(6.0);
    });
    FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, towards, 0.6, 1.0), SIZE.into()).with_ink(still)
}

fn with(change: impl FnOnce(&mut InkParams, &mut Study, &mut DebugView)) -> FrameParams {
    let mut params = from(Vec3::Z);
    match &mut params.style {
        Style::Ink(ink) => change(ink, &mut params.study, &mut params.debug),
        other => panic!("{other:?} is not ink"),
    }
    params
}

fn draw_package(gpu: &Gpu, params: &FrameParams, sphere: &SphereParams) -> Picture {
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(&package(sphere)).unwrap());
    draw(gpu, &mut renderer, params, &[&instance])
}

/// Returns the pixels that are darker than middle grey.
fn dark(picture: &Picture) -> Vec<(u32, u32)> {
    let pixels = picture.rgba.iter().enumerate().filter(|(_, p)| p[0] < 128);
    pixels.map(|(i, _)| (i as u32 % picture.size.0, i as u32 / picture.size.0)).collect()
}

#[test]
fn outline_strokes_have_the_requested_width() {
    let Some(gpu) = gpu("outline_strokes_have_the_requested_width") else { return };
    let features = dark(&draw_package(gpu, &with(|_, _, debug| debug.ink = InkDebugView::Features), &sphere()));
    // The camera frames a radius of 0.13 m; the sphere has a radius of 0.1 m.
    let middle = 0.5 * SIZE.0 as f32 - 0.5;
    let place = |(x, y): &(u32, u32)| ((*x as f32 - middle).powi(2) + (*y as f32 - middle).powi(2)).sqrt();
    let radius = features.iter().map(place).sum::<f32>() / features.len() as f32;
    assert!(features.iter().all(|p| (place(p) - radius).abs() < 1.5), "features off the outline");
    // The ring has about one pixel per pixel of its circumference, and fewer where its steps are diagonal.
    let ring = 2.0 * std::f32::consts::PI * radius;
    assert!((0.85 * ring..1.9 * ring).contains(&(features.len() as f32)), "{} features on {ring}", features.len());

    let lines = |width: f32| {
        let shown = with(|ink, _, debug| {
            (debug.ink, ink.width, ink.swell) = (InkDebugView::Lines, LineWidth::Pixels(width), 4.0);
        });
        dark(&draw_package(gpu, &shown, &sphere()))
    };
    for width in [4.0f32, 8.0, 16.0] {
        let lines = lines(width);
        let reach = lines.iter().map(|p| place(p) - radius).fold([0.0f32, 0.0], |[a, b], d| [a.min(d), b.max(d)]);
        assert!(reach[1] - reach[0] <= width + 1.5, "a line of {width} px reaches from {reach:?}");
        assert!(reach[1] - reach[0] >= 0.5 * width, "a line of {width} px reaches from {reach:?}");
    }
    let templated = lines(6.0).len();
    let free = with(|ink, study, debug| (debug.ink, study.template, ink.swell) = (InkDebugView::Lines, false, 4.0));
    assert!(
        dark(&draw_package(gpu, &free, &sphere())).len() > 2 * templated,
        "without the template, the rim must be filled"
    );
}

#[test]
fn edges_of_lines_are_soft_and_specks_are_left_out() {
    let Some(gpu) = gpu("edges_of_lines_are_soft_and_specks_are_left_out") else { return };
    let between = |printed: bool| {
        let shown = with(|_, study, debug| (debug.ink, study.printed_lines) = (InkDebugView::Lines, printed));
        let lines = draw_package(gpu, &shown, &sphere());
        lines.rgba.iter().filter(|p| (1..255).contains(&p[0])).count()
    };
    assert!(between(false) > 200, "lines have hard edges");
    assert_eq!(between(true), 0, "in the published form, a pixel is ink or not");

    // The spheres differ in size: the outline of the smaller one encloses about one pixel.
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&package(&sphere())).unwrap();
    let mut seen = |show, scale: f32| {
        let params = with(|_, _, debug| debug.ink = show);
        // The centre of the picture is the corner of four pixels. Half of the picture's height is 0.13 m.
        let half_pixel = 0.5 * 0.13 / (0.5 * SIZE.0 as f32);
        let instance = Instance::new(0, &model)
            .at(Mat4::from_translation(Vec3::new(half_pixel, half_pixel, 0.0)) * Mat4::from_scale(Vec3::splat(scale)));
        dark(&draw(gpu, &mut renderer, &params, &[&instance])).len()
    };
    assert_eq!(seen(InkDebugView::Features, 0.01), 1, "a sphere of one pixel");
    assert_eq!(seen(InkDebugView::Lines, 0.01), 0, "one pixel is no line");
    assert!(seen(InkDebugView::Lines, 0.08) > 30, "a small sphere has its outline");
}

#[test]
fn lines_in_metres_are_thinner_with_distance() {
    let Some(gpu) = gpu("lines_in_metres_are_thinner_with_distance") else { return };
    let area = |distance: f32, width| {
        let mut params = with(|ink, _, debug| (debug.ink, ink.width) = (InkDebugView::Lines, width));
        let projection = Projection::Perspective { fov_y_rad: 0.6, aspect: 1.0, near_m: 0.01, far_m: 10.0 };
        params.camera = Camera::look_at(Vec3::Z * distance, Vec3::ZERO, projection);
        dark(&draw_package(gpu, &params, &sphere())).len() as f32
    };
    // At twice the distance, the perimeter is half as long; the width is halved only if it is in metres.
    let metres = area(0.45, LineWidth::Metres(0.012)) / area(0.9, LineWidth::Metres(0.012));
    let pixels = area(0.45, LineWidth::Pixels(8.0)) / area(0.9, LineWidth::Pixels(8.0));
    assert!(metres > 1.4 * pixels, "area ratio {metres} for widths in metres, {pixels} in pixels");
}

#[test]
fn the_wash_fades_from_its_centre_and_blank_paper_stays() {
    let Some(gpu) = gpu("the_wash_fades_from_its_centre_and_blank_paper_stays") else { return };
    let picture = draw_package(gpu, &with(|_, _, debug| debug.ink = InkDebugView::Wash), &sphere());
    let mean = |rows: std::ops::Range<u32>| {
        let texel = |y: u32| f64::from(picture.rgba[(y * SIZE.0 + SIZE.0 / 2) as usize][0]);
        rows.clone().map(texel).sum::<f64>() / rows.len() as f64
    };
    let (top, bottom) = (mean(24..34), mean(110..130));
    assert!(top + 25.0 < bottom, "grey {top} near the centre of the wash, {bottom} away from it");
    assert_eq!(picture.rgba[0], [255; 4], "beside the sphere there is no wash");
}

/// Returns the lightest and the darkest grey (0..=1) in the middle of the sphere, for a uniform wash with full paper
/// grain.
fn wash_over_grain(gpu: &Gpu, grey: f32) -> [f32; 2] {
    let params = with(|ink, _, debug| {
        // The paper texture of these packages is 8 texels wide, so a texel is 2 pixels wide.
        (debug.ink, ink.paper_grain, ink.paper_period_px) = (InkDebugView::Wash, 1.0, 16.0);
        let even =
            InkShading { wash_speed: 0.0, wash_range: grey, grain: 0.0, tone: 0.0, fur: 0.0, ..Default::default() };
        ink.shading = Some(even);
    });
    let picture = draw_package(gpu, &params, &sphere());
    let inside = (60..100).flat_map(|y| (60..100).map(move |x| (y * SIZE.0 + x) as usize));
    let greys: Vec<f32> = inside.map(|i| f32::from(picture.rgba[i][0]) / 255.0).collect();
    [greys.iter().copied().fold(0.0, f32::max), greys.iter().copied().fold(1.0, f32::min)]
}

#[test]
fn paper_grain_fades_out_in_dark_wash() {
    let Some(gpu) = gpu("paper_grain_fades_out_in_dark_wash") else { return };
    let [light, dark] = wash_over_grain(gpu, 0.5);
    assert!(light > dark + 0.04, "a wash of grey 0.5 shows nothing of the grain: {dark}..{light}");
    let [light, dark] = wash_over_grain(gpu, 0.08);
    println!("a wash of grey 0.08: {dark:.3}..{light:.3}");
    assert!(light < 0.1, "a wash of grey 0.08 has grey of {dark}..{light}");
    let [light, dark] = wash_over_grain(gpu, 0.0);
    assert!(light == 0.0 && dark == 0.0, "full ink has grey of {dark}..{light}");
}

#[test]
fn ink_style_reports_missing_requirements() {
    let Some(gpu) = gpu("ink_style_reports_missing_requirements") else { return };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let load = |ink| {
        let bytes = package(&SphereParams { ink, ..sphere() });
        Instance::new(0, &renderer.load_bytes(&bytes).unwrap())
    };
    let (inked, plain) = (load(true), load(false));
    let mut prepare = |params: &FrameParams, instance: &Instance| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.prepare(&mut encoder, params, [instance]).map(|f| f.report().clone())
    };
    let error = prepare(&from(Vec3::Z), &plain).unwrap_err().to_string();
    assert!(error.contains("ink style") && error.contains("bake the model again"), "{error}");
    for (bad, expected) in [
        (with(|ink, _, _| ink.threshold = 0.1), "InkParams::threshold is 0.1, expected 0.15..=1"),
        (with(|ink, _, _| ink.width = LineWidth::Pixels(33.0)), "at most 32 pixels"),
        (from(Vec3::Z).with(|p| p.viewport = [0, 5]), "FrameParams::viewport is 0x5, expected 1..="),
        (from(Vec3::Z).with(|p| p.viewport = [10, 1 << 20]), "FrameParams::viewport is 10x1048576, expected 1..="),
        (with(|ink, _, _| ink.mist_m = Some([2.0, 1.0])), "InkParams::mist_m"),
        (with(|ink, _, _| ink.paper = Vec3::NAN), "InkParams::paper"),
        (with(|ink, _, _| ink.tone = f32::NAN), "InkParams::tone is NaN"),
    ] {
        let error = prepare(&bad, &inked).unwrap_err().to_string();
        assert!(error.contains(expected), "expected {expected:?} in: {error}");
    }
    let report = prepare(&from(Vec3::Z), &inked).unwrap();
    for pass in &report.passes {
        let expected = ["ink_normals", "ink_features", "ink_trace", "ink_dilate", "ink_stroke", "ink_composite"]
            .contains(&pass.name);
        assert_eq!(pass.ran, expected, "{pass:?}");
    }
    let furry = from(Vec3::Z).with(|p| p.style = Style::default());
    let report = prepare(&furry, &plain).unwrap();
    assert!(report.passes.iter().filter(|p| p.name.starts_with("ink")).all(|p| !p.ran && p.reason == "style is fur"));
}

#[test]
fn ink_keeps_application_pixels_around_and_in_front() {
    let Some(gpu) = gpu("ink_keeps_application_pixels_around_and_in_front") else { return };
    for (reversed_depth, sample_count) in [(false, 1), (true, 4)] {
        let options = RendererOptions { reversed_depth, sample_count, ..RendererOptions::default() };
        let targets = Canvas::new(gpu, SIZE, &(&options).into());
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
        let instance = Instance::new(0, &renderer.load_bytes(&package(&sphere())).unwrap());
        let mut over = |background| {
            let params = with(|ink, _, _| ink.background = background);
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let frame = renderer.prepare(&mut encoder, &params, [&instance]).unwrap();
            frame.draw(&mut targets.pass(&mut encoder, "application", Some(wgpu::Color::BLUE)));
            gpu.queue.submit([encoder.finish()]);
            let texels = targets.texels(gpu).unwrap();
            move |x: u32, y: u32| -> [u8; 4] { texels[((y * SIZE.0 + x) * 4) as usize..][..4].try_into().unwrap() }
        };
        let blue = [0, 0, 255, 255];
        let picture = over(InkBackground::Picture);
        assert_eq!(picture(2, 2), blue, "beside the painting");
        assert!(picture(80, 100)[0] > 150, "the body is paper, {:?}", picture(80, 100));
        let paper = over(InkBackground::Paper);
        assert!(paper(2, 2)[0] > 200 && paper(2, 2)[3] == 255, "paper all over, {:?}", paper(2, 2));
        assert_eq!(paper(80, 100), picture(80, 100));
    }
}

#[test]
fn nearer_instances_hide_lines_of_those_behind() {
    let Some(gpu) = gpu("nearer_instances_hide_lines_of_those_behind") else { return };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let model = renderer.load_bytes(&package(&sphere())).unwrap();
    let near = Instance::new(0, &model);
    // The second sphere is smaller and behind the first, so it is hidden.
    let smaller = Mat4::from_translation(Vec3::Z * -0.2) * Mat4::from_scale(Vec3::splat(0.5));
    let behind = Instance::new(1, &model).at(smaller);
    let params = with(|_, _, debug| debug.ink = InkDebugView::Lines);
    let alone = draw(gpu, &mut renderer, &params, &[&near]);
    for both in [[&near, &behind], [&behind, &near]] {
        assert_eq!(draw(gpu, &mut renderer, &params, &both), alone);
    }
}

#[test]
fn stroke_variation_is_anchored_to_the_surface() {
    let Some(gpu) = gpu("stroke_variation_is_anchored_to_the_surface") else { return };
    let sphere = SphereParams { skeleton: true, ..sphere() };
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let mut instance = Instance::new(0, &renderer.load_bytes(&package(&sphere)).unwrap());
    // The camera follows the rotation of the joints, so only screen-anchored effects change.
    let mut shown = |anchoring, angle: f32| {
        let turn = Mat4::from_rotation_y(angle);
        let mut params = with(|_, study, debug| (debug.ink, study.anchoring) = (InkDebugView::Wash, anchoring));
        params.camera = Camera::framing(Vec3::ZERO, 0.13, turn.transform_vector3(Vec3::Z), 0.6, 1.0);
        instance.motion = Motion::Joints(vec![turn; 2]);
        draw(gpu, &mut renderer, &params, &[&instance])
    };
    let still = shown(Anchoring::Surface, 0.0);
    let turned = difference(&still, &shown(Anchoring::Surface, 0.7));
    assert!(turned.mean < 0.2, "the surface's own picture changed by {turned:?}");
    // Only the camera orbits. Grain anchored to the screen stays, while grain anchored to the surface moves with the
    // model.
    let mut round = |anchoring, angle: f32| {
        let mut params = with(|_, study, debug| (debug.ink, study.anchoring) = (InkDebugView::Wash, anchoring));
        let towards = Mat4::from_rotation_y(angle).transform_vector3(Vec3::Z);
        params.camera = Camera::framing(Vec3::ZERO, 0.13, towards, 0.6, 1.0);
        instance.motion = Motion::Joints(vec![Mat4::IDENTITY; 2]);
        draw(gpu, &mut renderer, &params, &[&instance])
    };
    let on_surface = difference(&round(Anchoring::Surface, 0.0), &round(Anchoring::Surface, 0.7));
    let on_screen = difference(&round(Anchoring::Screen, 0.0), &round(Anchoring::Screen, 0.7));
    assert!(on_surface.mean > 4.0 * on_screen.mean, "{on_surface:?} and {on_screen:?}");
}

#[test]
fn published_sphere_map_misses_the_outline() {
    let Some(gpu) = gpu("published_sphere_map_misses_the_outline") else { return };
    let shown = |form| {
        let params = with(|ink, study, debug| {
            (debug.ink, study.template, study.sphere_map, ink.swell) = (InkDebugView::Lines, false, form, 2.0);
        });
        dark(&draw_package(gpu, &params, &sphere())).len()
    };
    let [safe, reflected, printed] =
        [SphereMapForm::Perpendicular, SphereMapForm::Reflection, SphereMapForm::Printed].map(shown);
    let features = dark(&draw_package(gpu, &with(|_, _, debug| debug.ink = InkDebugView::Lines), &sphere())).len();
    assert!(safe > features && reflected > 0, "safe {safe}, reflected {reflected}");
    // The published form maps all normals to one point, so no rim remains, only the feature lines.
    assert!(printed < safe, "published form {printed}, safe form {safe}");
}

#[test]
fn ink_frames_in_one_submission_are_independent() {
    let Some(gpu) = gpu("ink_frames_in_one_submission_are_independent") else { return };
    let options = RendererOptions::default();
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(&package(&sphere())).unwrap());
    let views = [from(Vec3::Z), from(Vec3::Y)];
    let targets = [0, 1].map(|_| Canvas::new(gpu, SIZE, &(&options).into()));
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    // Both frames are prepared before either is drawn.
    let frames = views.each_ref().map(|v| renderer.prepare(&mut encoder, v, [&instance]).unwrap());
    for (frame, target) in frames.iter().zip(&targets) {
        frame.draw(&mut target.pass(&mut encoder, "application", Some(wgpu::Color::TRANSPARENT)));
    }
    gpu.queue.submit([encoder.finish()]);
    drop(frames);
    for (view, target) in views.iter().zip(&targets) {
        let alone = draw(gpu, &mut renderer, view, &[&instance]);
        assert!(target.texels(gpu).unwrap() == alone.rgba.as_flattened(), "the other frame shows through");
    }
}

#[test]
fn fur_strokes_extend_beyond_the_outline() {
    let Some(gpu) = gpu("fur_strokes_extend_beyond_the_outline") else { return };
    let furry = |fur: f32| {
        let params = with(|ink, _, _| {
            ink.shading = Some(InkShading { fur, line: 0.0, tone: 0.0, ..Default::default() });
            ink.background = InkBackground::Picture;
        });
        draw_package(gpu, &params, &sphere())
    };
    let (bald, hairy) = (furry(0.0), furry(1.0));
    assert!(hairy.covered() > bald.covered() + 100, "{} and {} covered", hairy.covered(), bald.covered());
    assert!(hairy.covered() < 3 * bald.covered());
    assert_eq!(PassId::INK_FUR.name(), "ink_fur");
}
