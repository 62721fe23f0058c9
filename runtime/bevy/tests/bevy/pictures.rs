//! Tests of pictures: the ball among Bevy's meshes, the comparison with the runtime alone, and several cameras.

use crate::support::{Picture, TestApp, TestCamera, ball_package, gpu, painted_ball_package};
use bevy_asset::Handle;
use bevy_camera::visibility::RenderLayers;
use bevy_camera::{Camera, Viewport};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_math::{UVec2, Vec3};
use bevy_pelage::runtime::{self, FrameParams, Instance, Renderer, Style};
use bevy_pelage::{Pelage, PelageModel};
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;
use pelage_stage::{Canvas, CanvasOptions, Gpu};

const SIZE: [u32; 2] = [96, 72];
const EYE: Vec3 = Vec3::new(0.0, 0.0, 0.7);
const SUN: Vec3 = Vec3::new(-0.5, 0.8, 0.6);

fn front_view() -> Transform {
    Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y)
}

fn middle_pixel(picture: &Picture) -> [u8; 4] {
    picture.pixel(SIZE[0] / 2, SIZE[1] / 2)
}

fn is_red([r, g, b, _]: [u8; 4]) -> bool {
    r > 60 && g < r / 3 && b < r / 3
}

/// Returns the number of red pixels.
fn count_red(picture: &Picture) -> usize {
    picture.pixels().filter(|p| is_red(*p)).count()
}

/// Checks the ball in front of and behind a red cube, with and without multisampling.
fn check_occlusion(test_app: &mut TestApp, pelage: &Pelage) {
    for msaa in [Msaa::Off, Msaa::Sample4] {
        let camera = test_app.spawn_camera(SIZE, msaa, front_view());
        let ball = test_app.world().spawn(pelage.clone()).id();
        let alone = test_app.picture(&camera);
        assert!(
            alone.pixels().any(|p| p[..3] != [0; 3]) && count_red(&alone) == 0,
            "{msaa:?}: the ball is visible, and not red"
        );

        let wall = test_app.spawn_cuboid(Vec3::new(0.3, 0.3, 0.02), Vec3::Z * -0.2, Color::srgb(1.0, 0.0, 0.0));
        let before = test_app.picture(&camera);
        assert_eq!(middle_pixel(&before), middle_pixel(&alone), "{msaa:?}: the ball hides the wall behind it");
        assert!(
            count_red(&before) > 200,
            "{msaa:?}: the wall is seen beside the ball, in {} pixels",
            count_red(&before)
        );

        *test_app.world().get_mut::<Transform>(wall).unwrap() = Transform::from_xyz(0.0, 0.0, 0.3);
        let behind = test_app.picture(&camera);
        assert!(
            is_red(middle_pixel(&behind)),
            "{msaa:?}: {:?} is not the wall that hides the ball",
            middle_pixel(&behind)
        );
        test_app.remove([ball, wall, camera.entity]);
    }
}

#[test]
fn animal_and_cube_occlude_each_other() {
    let Some(mut test_app) = gpu("animal_and_cube_occlude_each_other") else { return };
    let model = test_app.add_model("ball", &ball_package());
    test_app.spawn_sun(SUN, false);
    check_occlusion(&mut test_app, &Pelage::fur(model.clone()));
    check_occlusion(&mut test_app, &Pelage::ink(model));
    assert_eq!(
        test_app.renderers().logged_messages().count(),
        0,
        "{:?}",
        test_app.renderers().logged_messages().collect::<Vec<_>>()
    );
}

fn runtime_picture(pelage: &Pelage, package: &[u8]) -> Picture {
    let gpu = Gpu::with(runtime::wgpu::Features::TEXTURE_COMPRESSION_BC, None).unwrap();
    let options = CanvasOptions::default();
    let canvas = Canvas::new(&gpu, (SIZE[0], SIZE[1]), &options);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options.renderer()).unwrap();
    let model = renderer.load_bytes(package).unwrap();
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    let projection = runtime::Projection::Perspective { fov_y_rad: 0.6, aspect, near_m: 0.1, far_m: f32::INFINITY };
    let camera = runtime::Camera::look_at(EYE, Vec3::ZERO, projection);
    let params = FrameParams::new(camera, SIZE).with(|p| {
        p.light = runtime::Light::Directional { towards_light: SUN, color: Vec3::ONE };
        p.ambient = Vec3::ZERO;
        p.style = pelage.style.clone();
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = renderer.prepare(&mut encoder, &params, [Instance::new(0, &model)]).unwrap();
    let mut pass = canvas.pass(&mut encoder, "runtime alone", Some(runtime::wgpu::Color::BLACK));
    frame.draw(&mut pass);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    Picture { size: SIZE, rgba: canvas.texels(&gpu).unwrap() }
}

#[test]
fn bevy_frame_equals_that_of_the_runtime_alone() {
    let Some(mut test_app) = gpu("bevy_frame_equals_that_of_the_runtime_alone") else { return };
    let packages = [ball_package(), painted_ball_package()];
    let [model, painted] = [0, 1].map(|k| test_app.add_model(["ball", "painted"][k], &packages[k]));
    // The runtime draws the ball's shadow on itself: a sun with shadow maps enables `soft_shadow`.
    test_app.spawn_sun(SUN, true);
    let camera = test_app.spawn_camera(SIZE, Msaa::Off, front_view());
    // Without strokes, ink is drawn with lines found in pixels.
    for (pelage, package) in [(Pelage::fur(model.clone()), 0), (Pelage::ink(model), 0), (Pelage::ink(painted), 1)] {
        let alone = runtime_picture(&pelage, &packages[package]);
        let ball = test_app.world().spawn(pelage.clone()).id();
        let picture = test_app.picture(&camera);
        // Tolerance: Bevy blends in half floats and encodes at the end, while the canvas blends in bytes.
        let (mean, most) = picture.differences(&alone);
        assert!(mean < 0.4 && most <= 12, "{:?}: mean difference {mean}, maximum {most}", pelage.style.kind());
        // Negative control: a moved ball gives a different picture.
        *test_app.world().get_mut::<Transform>(ball).unwrap() = Transform::from_xyz(0.01, 0.0, 0.0);
        let (mean, _) = test_app.picture(&camera).differences(&alone);
        assert!(mean > 1.0, "{:?}: after a move of 1 cm, the mean difference is only {mean}", pelage.style.kind());
        test_app.world().despawn(ball);
    }
}

/// Returns an animal in ink on paper without relief. Relief would be fixed to the whole picture instead of the view.
fn ink_without_relief(model: Handle<PelageModel>) -> Pelage {
    let mut pelage = Pelage::ink(model);
    if let Style::Ink(ink) = &mut pelage.style {
        (ink.paper_grain, ink.roughness_px, ink.dryness, ink.pressure) = (0.0, 0.0, 0.0, 0.0);
    }
    pelage
}

/// Spawns a camera that draws to the rectangle `part` of the picture of the camera `whole`.
fn spawn_viewport_camera(test_app: &mut TestApp, whole: &TestCamera, part: (UVec2, UVec2)) -> TestCamera {
    let camera = test_app.spawn_camera([part.1.x, part.1.y], Msaa::Off, front_view());
    let viewport = Viewport { physical_position: part.0, physical_size: part.1, ..Default::default() };
    let entity = camera.entity;
    let mut entity = test_app.world().entity_mut(entity);
    entity.insert(bevy_camera::RenderTarget::from(whole.image.clone()));
    entity.insert(Camera { viewport: Some(viewport), order: 1, ..Default::default() });
    TestCamera { image: whole.image.clone(), size: whole.size, ..camera }
}

#[test]
fn several_cameras_draw_the_animal_in_their_viewports() {
    let Some(mut test_app) = gpu("several_cameras_draw_the_animal_in_their_viewports") else { return };
    let model = test_app.add_model("ball", &ball_package());
    test_app.spawn_sun(SUN, false);
    for pelage in [Pelage::fur(model.clone()), ink_without_relief(model)] {
        let ball = test_app.world().spawn(pelage.clone()).id();
        let whole = test_app.spawn_camera(SIZE, Msaa::Off, front_view());
        let alone = test_app.picture(&whole);
        // Draws the same view twice: as a whole picture, and as the right half of a picture twice as wide.
        let wide = test_app.spawn_camera([2 * SIZE[0], SIZE[1]], Msaa::Off, Transform::from_xyz(0.0, 9.0, 0.0));
        let half = spawn_viewport_camera(&mut test_app, &wide, (UVec2::new(SIZE[0], 0), UVec2::from(SIZE)));
        let picture = test_app.picture(&half);
        let right = picture.crop([SIZE[0], 0], SIZE);
        let (mean, most) = right.differences(&alone);
        let kind = pelage.style.kind();
        assert!(mean < 0.5, "{kind:?}: mean difference of the right half {mean}, maximum {most}");
        let left = picture.crop([0, 0], SIZE);
        assert!(left.pixels().all(|p| p[..3] == [0; 3]), "{kind:?}: nothing is drawn outside the viewport");
        assert_eq!(test_app.picture(&whole), alone, "{kind:?}: the picture does not depend on other cameras");

        // A camera with other render layers must not see the animal.
        test_app.world().entity_mut(whole.entity).insert(RenderLayers::layer(3));
        assert!(
            test_app.picture(&whole).pixels().all(|p| p[..3] == [0; 3]),
            "{kind:?}: other render layers are not drawn"
        );
        test_app.remove([ball, whole.entity, wide.entity, half.entity]);
    }
}

#[test]
fn despawned_animals_are_freed() {
    let Some(mut test_app) = gpu("despawned_animals_are_freed") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = test_app.spawn_camera(SIZE, Msaa::Off, front_view());
    test_app.spawn_sun(SUN, true);
    let balls: Vec<Entity> = [-0.1, 0.1]
        .map(|x| test_app.world().spawn((Pelage::fur(model.clone()), Transform::from_xyz(x, 0.0, 0.0))).id())
        .into();
    test_app.picture(&camera);
    let (models, both) = (test_app.renderers().models_gpu_bytes(), test_app.renderers().animals_gpu_bytes());
    assert!(models > 100_000 && both > 10_000, "{models} bytes of models, {both} of animals");
    test_app.world().despawn(balls[0]);
    test_app.app.update();
    assert_eq!(test_app.renderers().animals_gpu_bytes(), both / 2, "one of two animals is freed");
    assert_eq!(test_app.renderers().models_gpu_bytes(), models, "the other animal keeps the model");
    test_app.world().despawn(balls[1]);
    drop(model);
    // Bevy drops the asset a frame after its last handle.
    (0..3).for_each(|_| test_app.app.update());
    assert_eq!(test_app.renderers().animals_gpu_bytes(), 0);
    assert_eq!(test_app.renderers().models_gpu_bytes(), 0);
}
