//! Pictures drawn by the runtime, compared with a stored picture and with each other.

#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::formats::Shading;
use pelage_runtime::glam::{Mat4, Quat, Vec3};
use pelage_runtime::{
    Camera, FrameParams, Instance, Light, Motion, PassId, Projection, Renderer, RendererOptions, RuntimeError,
    SelfShadow, Style, wgpu,
};
use pelage_stage::Gpu;
use pelage_tests::binary::workspace;
use pelage_tests::gpu::gpu;
use pelage_tests::pictures::{Picture, compare_golden, difference, draw};
use pelage_tests::silhouette::bake_plain;
use pelage_tests::support::sphere::{SphereParams, package};

const SIZE: (u32, u32) = (128, 128);

fn small() -> SphereParams {
    SphereParams { quads: 12, texels: 32, strands: 90, tiles: 4, ..SphereParams::default() }
}

fn renderer(gpu: &Gpu, options: &RendererOptions) -> Renderer {
    Renderer::new(&gpu.device, &gpu.queue, options).unwrap()
}

fn instance(renderer: &Renderer, owner: u64, params: &SphereParams) -> Instance {
    Instance::new(owner, &renderer.load_bytes(&package(params)).unwrap())
}

fn front() -> FrameParams {
    FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0), SIZE.into())
}

fn without_fur() -> FrameParams {
    front().with(|p| p.style = Style::Bare)
}

/// Draws a small sphere with the given options and parameters.
fn sphere_picture(gpu: &Gpu, options: &RendererOptions, params: &FrameParams, sphere: &SphereParams) -> Picture {
    let mut renderer = renderer(gpu, options);
    let instance = instance(&renderer, 0, sphere);
    draw(gpu, &mut renderer, params, &[&instance])
}

fn default_picture(gpu: &Gpu) -> Picture {
    sphere_picture(gpu, &RendererOptions::default(), &front(), &small())
}

#[test]
fn furry_sphere_matches_its_golden_picture() {
    let Some(gpu) = gpu("furry_sphere_matches_its_golden_picture") else { return };
    compare_golden("furry_sphere", &default_picture(gpu)).unwrap();
}

#[test]
fn golden_comparison_rejects_wrong_pictures() {
    let Some(gpu) = gpu("golden_comparison_rejects_wrong_pictures") else { return };
    if std::env::var("PELAGE_WRITE_GOLDEN").is_ok_and(|v| v == "1") {
        // The negative controls must not be written as the golden picture.
        return;
    }
    let right = default_picture(gpu);
    let mut shifted = right.clone();
    shifted.rgba.rotate_right(1);
    compare_golden("furry_sphere", &shifted).expect_err("a picture moved by one pixel must differ");
    let bare = sphere_picture(gpu, &RendererOptions::default(), &without_fur(), &small());
    compare_golden("furry_sphere", &bare).expect_err("a picture without fur must differ");
    let smaller = Picture { size: (SIZE.0, SIZE.1 - 1), rgba: right.rgba[SIZE.0 as usize..].to_vec() };
    compare_golden("furry_sphere", &smaller).expect_err("a picture of another size must be rejected");
    compare_golden("there_is_no_such_picture", &right).expect_err("a missing golden picture must be an error");
}

#[test]
fn fur_reaches_past_the_skin_and_hides_it() {
    let Some(gpu) = gpu("fur_reaches_past_the_skin_and_hides_it") else { return };
    let fur = default_picture(gpu);
    let bare = sphere_picture(gpu, &RendererOptions::default(), &without_fur(), &small());
    // Fur of a quarter of the radius enlarges the disc by (1.25 / 1)^2 = 1.56; the edge of the fur is thin.
    let ratio = fur.covered() as f64 / bare.covered() as f64;
    assert!((1.3..1.6).contains(&ratio), "covered {ratio} times as much");
    // Contrast is the mean difference of neighbouring pixels inside the disc. Hair has contrast, bare surfaces have
    // none.
    let contrast = |p: &Picture| {
        let row = &p.rgba[64 * 128 + 40..64 * 128 + 88];
        row.windows(2).map(|w| f64::from(w[0][1].abs_diff(w[1][1]))).sum::<f64>() / 47.0
    };
    assert!(contrast(&fur) > 4.0 * contrast(&bare), "contrast {} and {}", contrast(&fur), contrast(&bare));
    // Half-transparent edges must be premultiplied: no channel may exceed the brightest light at that opacity.
    let edge = fur.rgba.iter().filter(|p| (1..255).contains(&p[3])).count();
    assert!(edge > 100, "only {edge} texels are between transparent and opaque");
}

#[test]
fn reversed_depth_draws_the_same_picture() {
    let Some(gpu) = gpu("reversed_depth_draws_the_same_picture") else { return };
    let forward = default_picture(gpu);
    let options = RendererOptions { reversed_depth: true, ..RendererOptions::default() };
    let reversed = sphere_picture(gpu, &options, &front(), &small());
    let found = difference(&forward, &reversed);
    assert!(found.mean < 0.05 && found.share < 0.001, "{found:?}");
    // Checks an infinite far plane too.
    let mut params = front();
    if let Projection::Perspective { far_m, .. } = &mut params.camera.projection {
        *far_m = f32::INFINITY;
    }
    let found = difference(&forward, &sphere_picture(gpu, &options, &params, &small()));
    assert!(found.mean < 0.05 && found.share < 0.001, "infinite far plane: {found:?}");
    // Negative control: with a forward depth matrix, a renderer for reversed depth draws the far side.
    params.camera.projection = Projection::Custom(front().camera.projection.clip_from_view(false));
    let found = difference(&forward, &sphere_picture(gpu, &options, &params, &small()));
    assert!(found.mean > 1.0, "a wrong projection was not detected: {found:?}");
}

#[test]
fn four_samples_only_smooth_the_edges() {
    let Some(gpu) = gpu("four_samples_only_smooth_the_edges") else { return };
    let options = RendererOptions { sample_count: 4, ..RendererOptions::default() };
    let found = difference(&default_picture(gpu), &sphere_picture(gpu, &options, &front(), &small()));
    assert!(found.mean > 0.0 && found.mean < 2.5, "{found:?}");
}

#[test]
fn both_direction_formats_draw_the_same_fur() {
    let Some(gpu) = gpu("both_direction_formats_draw_the_same_fur") else { return };
    let three = SphereParams { planar_directions: false, ..small() };
    let three = sphere_picture(gpu, &RendererOptions::default(), &front(), &three);
    let found = difference(&default_picture(gpu), &three);
    assert!(found.mean > 0.0 && found.mean < 1.5, "{found:?}");
}

/// Checks that block-compressed textures are decoded on devices that cannot sample them. The package must look like one
/// with uncompressed texels, and use as much memory.
#[test]
fn block_textures_are_decoded_where_unsupported() {
    let Some(_) = gpu("block_textures_are_decoded_where_unsupported") else { return };
    let gpu = &Gpu::with(wgpu::Features::empty(), Some(wgpu::Limits::default())).unwrap();
    let drawn = |formats: &[&str]| {
        let small = ["slice.layers=6", "slice.tile_texels=32", "ink.enabled=false"];
        let torus = workspace().join("assets/models/torus.glb");
        let package = bake_plain(&torus, None, &[&small[..], formats].concat());
        let mut renderer = renderer(gpu, &RendererOptions::default());
        let model = renderer.load_bytes(&package).unwrap();
        let bounds = model.manifest().bounds;
        let camera = Camera::framing(Vec3::from(bounds.center), bounds.radius, Vec3::new(-0.3, 0.35, 1.0), 0.6, 1.0);
        let params = FrameParams::new(camera, SIZE.into());
        (draw(gpu, &mut renderer, &params, &[&Instance::new(0, &model)]), model.gpu_bytes(), package.len())
    };
    let blocks = ["pack.shell_format=bc7", "pack.direction_format=bc5", "pack.base_color_format=bc7"];
    let (blocks, block_bytes, small) = drawn(&blocks);
    let (plain, plain_bytes, large) = drawn(&["pack.direction_format=rgba8"]);
    assert!(small < large, "{small} and {large} bytes: the package has no block-compressed textures");
    assert_eq!(block_bytes, plain_bytes);
    let found = difference(&blocks, &plain);
    assert!(found.mean > 0.0 && found.mean < 1.0, "{found:?}");
}

#[test]
fn instances_have_their_own_position_and_pose() {
    let Some(gpu) = gpu("instances_have_their_own_position_and_pose") else { return };
    let sphere = SphereParams { skeleton: true, stripes: true, ..small() };
    let mut renderer = renderer(gpu, &RendererOptions::default());
    let left = instance(&renderer, 0, &sphere).at(Mat4::from_translation(Vec3::new(-0.15, 0.0, 0.0)));
    let mut right = Instance::new(1, &left.model).at(Mat4::from_translation(Vec3::new(0.15, 0.0, 0.0)));
    let projection = Projection::Orthographic { height_m: 0.3, aspect: 2.0, near_m: 0.0, far_m: 4.0 };
    // Shadows are off, because the instances would cast them on each other.
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, projection);
    let params = FrameParams::new(camera, [256, 128])
        .with(|p| p.soft_shadow = false)
        .with_fur(|f| f.self_shadow = SelfShadow::Off);
    let half = |p: &Picture, from: usize| Picture {
        size: (128, 128),
        rgba: p.rgba.chunks_exact(256).flat_map(|row| row[from..from + 128].to_vec()).collect(),
    };
    let same = draw(gpu, &mut renderer, &params, &[&left, &right]);
    // With an orthographic camera and a directional light, two instances at rest must look the same.
    let found = difference(&half(&same, 0), &half(&same, 128));
    assert!(found.share < 0.01, "copies at rest differ: {found:?}");

    let clip = right.model.clip_index("bend").unwrap();
    right.motion = Motion::Clip { clip, time_s: 0.5 };
    let bent = draw(gpu, &mut renderer, &params, &[&left, &right]);
    assert!(half(&bent, 0) == half(&same, 0), "the left copy moved with the right");
    let found = difference(&half(&bent, 128), &half(&same, 128));
    assert!(found.share > 0.05, "the right copy did not move: {found:?}");

    // The application supplies the joints of the same pose.
    let mut pose = pelage_runtime::formats::Pose::default();
    pose.sample(right.model.skeleton().unwrap(), Some(clip), 0.5);
    right.motion = Motion::Joints(pose.joints.clone());
    assert_eq!(draw(gpu, &mut renderer, &params, &[&left, &right]), bent);
    right.motion = Motion::Joints(vec![Mat4::IDENTITY]);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let error = renderer.prepare(&mut encoder, &params, [&right]).unwrap_err();
    assert!(error.to_string().contains("1 joints, expected the 2 joints"), "{error}");
}

#[test]
fn moved_and_mirrored_instances_draw_moved_and_mirrored_pictures() {
    let Some(gpu) = gpu("moved_and_mirrored_instances_draw_moved_and_mirrored_pictures") else { return };
    let mut renderer = renderer(gpu, &RendererOptions::default());
    let mut copy = instance(&renderer, 0, &SphereParams { stripes: true, ..small() });
    let look = |x: f32| Camera::framing(Vec3::ZERO, 0.13, Vec3::new(x, 0.2, 1.0), 0.6, 1.0);
    let light = |x: f32| Light::Directional { towards_light: Vec3::new(x, 0.8, 0.6), color: Vec3::ONE };
    let params = FrameParams::new(look(-0.4), SIZE.into()).with(|p| p.light = light(-0.5));
    let plain = draw(gpu, &mut renderer, &params, &[&copy]);

    // The picture must be the same if the instance is rotated and scaled together with camera and light.
    let turn = Quat::from_rotation_x(0.7) * Quat::from_rotation_y(1.1);
    copy.transform = Mat4::from_scale_rotation_translation(Vec3::splat(3.0), turn, Vec3::new(5.0, -2.0, 1.0));
    let view_from_world = params.camera.view_from_world;
    let rigid = Mat4::from_rotation_translation(turn, Vec3::new(5.0, -2.0, 1.0));
    let mut moved = params.clone();
    // The picture must be the same if camera space is scaled by three.
    let mut view = view_from_world;
    view.w_axis *= pelage_runtime::glam::Vec4::new(3.0, 3.0, 3.0, 1.0);
    moved.camera.view_from_world = view * rigid.inverse();
    if let Projection::Perspective { near_m, far_m, .. } = &mut moved.camera.projection {
        (*near_m, *far_m) = (*near_m * 3.0, *far_m * 3.0);
    }
    moved.light = Light::Directional { towards_light: turn * Vec3::new(-0.5, 0.8, 0.6), color: Vec3::ONE };
    // The shadow maps have a different position relative to the same hair, which causes small differences.
    let found = difference(&plain, &draw(gpu, &mut renderer, &moved, &[&copy]));
    assert!(found.mean < 0.6 && found.share < 0.01, "turned and scaled: {found:?}");

    // If the instance is mirrored together with camera and light, the picture must be mirrored.
    copy.transform = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let params = FrameParams::new(look(0.4), SIZE.into()).with(|p| p.light = light(0.5));
    let mut mirrored = draw(gpu, &mut renderer, &params, &[&copy]);
    mirrored.rgba.chunks_exact_mut(SIZE.0 as usize).for_each(<[_]>::reverse);
    let found = difference(&plain, &mirrored);
    assert!(found.mean < 0.5 && found.share < 0.01, "mirrored: {found:?}");
}

#[test]
fn bare_parts_have_no_fur() {
    let Some(gpu) = gpu("bare_parts_have_no_fur") else { return };
    let params = FrameParams::new(Camera::framing(Vec3::ZERO, 0.13, Vec3::Z, 0.3, 1.0), SIZE.into());
    // The fur is short, because long fur would cover the band.
    let banded = SphereParams { bare_band: true, height_m: 0.004, ..small() };
    let banded = sphere_picture(gpu, &RendererOptions::default(), &params, &banded);
    let middle = banded.rgba[58 * 128 + 64];
    assert!(middle[2] > middle[0] && middle[3] == 255, "the band's blue is {middle:?}");
    let above = banded.rgba[30 * 128 + 64];
    assert!(above[0] > above[2], "the fur above it is {above:?}");
}

#[test]
fn light_parameters_change_the_picture_as_expected() {
    let Some(gpu) = gpu("light_parameters_change_the_picture_as_expected") else { return };
    let options = RendererOptions::default();
    let picture = |change: &dyn Fn(&mut FrameParams)| {
        let mut params = front();
        change(&mut params);
        sphere_picture(gpu, &options, &params, &small())
    };
    let plain = picture(&|_| ());
    let behind = |p: &mut FrameParams| p.light = Light::Directional { towards_light: Vec3::NEG_Z, color: Vec3::ONE };
    let dark = picture(&behind);
    assert!(dark.mean(1) < 0.7 * plain.mean(1), "lit from behind {}, from the front {}", dark.mean(1), plain.mean(1));
    let through = picture(&|p| {
        behind(p);
        p.study.back_attenuation = false;
    });
    assert!(through.mean(1) > 1.2 * dark.mean(1), "Attenu_Back off: {} and {}", through.mean(1), dark.mean(1));
    let flat = picture(&|p| p.study.ambient_attenuation = false);
    assert!(flat.mean(1) > plain.mean(1), "ambient attenuation off: {} and {}", flat.mean(1), plain.mean(1));
    // Checks that a distant point light equals a directional light.
    let towards_light = Vec3::new(-0.5, 0.8, 0.6);
    let far = picture(&|p| p.light = Light::Point { position: towards_light * 1e4, color: Vec3::ONE });
    let found = difference(&plain, &far);
    assert!(found.mean < 0.1, "{found:?}");
    // Without light, the fur must be black but still opaque.
    let night = picture(&|p| {
        p.ambient = Vec3::ZERO;
        p.light = Light::Directional { towards_light, color: Vec3::ZERO };
    });
    assert!(night.mean(1) == 0.0 && night.covered() == plain.covered(), "{} {}", night.mean(1), night.covered());
    let shiny = Shading { specular: [0.9; 3], ..Shading::default() };
    assert!(picture(&|p| p.shading = Some(shiny)).mean(1) > plain.mean(1));
}

#[test]
fn layer_count_does_not_change_the_appearance() {
    let Some(gpu) = gpu("layer_count_does_not_change_the_appearance") else { return };
    let options = RendererOptions::default();
    // The tolerance is larger with shadow maps: with few layers, they are coarser than the hair itself.
    for (self_shadow, allowed) in [(false, 0.04), (true, 0.08)] {
        let params = front().with_fur(|f| f.self_shadow = if self_shadow { SelfShadow::Maps } else { SelfShadow::Off });
        let baked = sphere_picture(gpu, &options, &params, &small());
        for layers in [8, 31, 46] {
            let params = params.clone().with_fur(|f| f.layers = Some(layers));
            let other = sphere_picture(gpu, &options, &params, &small());
            let found = [1, 3].map(|c| other.mean(c) / baked.mean(c));
            assert!(
                found.iter().all(|r| (r - 1.0).abs() < allowed),
                "{layers} layers: green and alpha {found:?} times"
            );
        }
    }
    let baked = sphere_picture(gpu, &options, &front(), &small());
    let skin = sphere_picture(gpu, &options, &front().with_fur(|f| f.layers = Some(1)), &small());
    assert!(skin.covered() < baked.covered() * 4 / 5, "one layer must be the bare surface");
}

#[test]
fn parameter_errors_name_the_field() {
    let Some(gpu) = gpu("parameter_errors_name_the_field") else { return };
    let mut renderer = renderer(gpu, &RendererOptions::default());
    let mut copy = instance(&renderer, 0, &small());
    let mut error = |change: &dyn Fn(&mut FrameParams), copy: &Instance| {
        let mut params = front();
        change(&mut params);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        renderer.prepare(&mut encoder, &params, [copy]).unwrap_err().to_string()
    };
    for (message, expected) in [
        (error(&|p| *p = front().with_fur(|f| f.layers = Some(0)), &copy), "FurParams::layers is 0, expected 1..=1024"),
        (error(&|p| p.ambient = Vec3::NAN, &copy), "FrameParams::ambient"),
        (error(&|p| p.camera.view_from_world = Mat4::ZERO, &copy), "FrameParams::camera"),
        (error(&|p| p.light = Light::Directional { towards_light: Vec3::ZERO, color: Vec3::ONE }, &copy), "light"),
        (error(&|p| p.shading = Some(Shading { specular_exponent: -1.0, ..Shading::default() }), &copy), "shading"),
    ] {
        assert!(message.contains(expected), "{message:?} does not name {expected:?}");
    }
    copy.transform = Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
    assert!(error(&|_| (), &copy).contains("Instance::transform"));

    for (options, field) in [
        (RendererOptions { color_format: wgpu::TextureFormat::Depth32Float, ..Default::default() }, "color_format"),
        (RendererOptions { depth_format: wgpu::TextureFormat::Rgba8Unorm, ..Default::default() }, "depth_format"),
        (RendererOptions { sample_count: 3, ..Default::default() }, "sample_count"),
        (RendererOptions { anisotropy: 0, ..Default::default() }, "anisotropy"),
    ] {
        let error = Renderer::new(&gpu.device, &gpu.queue, &options).unwrap_err();
        assert!(matches!(&error, RuntimeError::Options { field: f, .. } if *f == field), "{field}: {error}");
    }

    let renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let bytes = package(&small());
    let cut = renderer.load_bytes(&bytes[..bytes.len() / 2]).unwrap_err();
    assert!(matches!(cut, RuntimeError::Package(_)), "{cut}");
}

#[test]
fn report_names_the_passes_and_why_they_were_skipped() {
    let Some(gpu) = gpu("report_names_the_passes_and_why_they_were_skipped") else { return };
    let mut renderer = renderer(gpu, &RendererOptions::default());
    let plain = instance(&renderer, 0, &small());
    let skinned = instance(&renderer, 1, &SphereParams { skeleton: true, ..small() });
    let report =
        |renderer: &mut Renderer, params: &FrameParams, copy: &Instance| -> Vec<(&'static str, bool, String)> {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let frame = renderer.prepare(&mut encoder, params, [copy]).unwrap();
            gpu.queue.submit([encoder.finish()]);
            frame.report().passes.iter().map(|p| (p.name, p.ran, p.reason.clone())).collect()
        };
    // Only the fur passes are compared; the ink passes have their own test.
    let of_fur = |report: &[(&'static str, bool, String)]| -> Vec<(&'static str, bool, String)> {
        report.iter().filter(|(name, ..)| !name.starts_with("ink")).cloned().collect()
    };
    let ran = |report: &[(&'static str, bool, String)]| -> String {
        of_fur(report).iter().filter(|p| p.1).map(|p| p.0).collect::<Vec<_>>().join(" ")
    };
    let reason = |report: &[(&'static str, bool, String)], id: PassId| -> String {
        report.iter().find(|p| p.0 == id.name()).unwrap().2.clone()
    };
    let furry = report(&mut renderer, &front(), &plain);
    assert_eq!(furry.iter().map(|p| p.0).collect::<Vec<_>>(), PassId::all().map(PassId::name).collect::<Vec<_>>());
    assert_eq!(ran(&furry), "layer_shadow shadow_width skin shells");
    assert!(reason(&furry, PassId::POSE).contains("no instance has a skeleton"), "{furry:?}");
    assert!(reason(&furry, PassId::STRANDS).contains("no package has strands"), "{furry:?}");
    let bare = report(&mut renderer, &without_fur(), &plain);
    assert!(ran(&bare) == "shadow_width skin" && reason(&bare, PassId::SHELLS).contains("bare"), "{bare:?}");
    assert_eq!(ran(&report(&mut renderer, &front(), &skinned)), "pose layer_shadow shadow_width skin shells");
    let again = report(&mut renderer, &front(), &skinned);
    assert_eq!(ran(&again), "skin shells");
    assert!(reason(&again, PassId::POSE).contains("no pose changed"), "{again:?}");
    assert!(reason(&again, PassId::LAYER_SHADOW).contains("are unchanged"), "{again:?}");
    renderer.invalidate();
    assert!(report(&mut renderer, &front(), &skinned)[0].1, "invalidated, but not posed again");
}
