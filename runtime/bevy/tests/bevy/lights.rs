//! Tests of shadows from fur on meshes and from meshes on fur, of exposure, and of clips that move the casters.

use crate::support::{Picture, TestApp, TestCamera, ball_package, gpu};
use bevy_camera::{Exposure, Hdr};
use bevy_color::Color;
use bevy_light::{NotShadowCaster, PointLight, RectLight, SpotLight};
use bevy_math::{Mat4, Vec3};
use bevy_pelage::runtime::{Environment, FurParams, LightLobe};
use bevy_pelage::{
    Pelage, PelageClip, PelageEnvironment, PelageHair, PelageJoints, PelageShadowCaster, runtime::Style,
};
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;
use std::f32::consts::PI;

const SIZE: [u32; 2] = [96, 72];

fn view_from_above() -> Transform {
    Transform::from_xyz(0.0, 0.9, 0.5).looking_at(Vec3::ZERO, Vec3::Y)
}

fn green_sum(picture: &Picture) -> u64 {
    picture.pixels().map(|p| u64::from(p[1])).sum()
}

fn camera(test_app: &mut TestApp) -> TestCamera {
    test_app.spawn_camera(SIZE, Msaa::Off, view_from_above())
}

#[test]
fn animal_casts_its_shadow_on_a_bevy_ground() {
    let Some(mut test_app) = gpu("animal_casts_its_shadow_on_a_bevy_ground") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 0.0), true);
    test_app.spawn_cuboid(Vec3::new(4.0, 0.1, 4.0), Vec3::Y * -0.2, Color::srgb(0.0, 1.0, 0.0));
    let ball = test_app.world().spawn(Pelage::fur(model)).id();
    let with = test_app.picture(&camera);
    test_app.world().entity_mut(ball).insert(NotShadowCaster);
    let without = test_app.picture(&camera);
    let darker = |(a, b): (&[u8; 4], &[u8; 4])| b[1] > 40 && a[1] < b[1] / 4;
    let (a, b): (Vec<_>, Vec<_>) = (with.pixels().collect(), without.pixels().collect());
    let shadow: Vec<usize> = a.iter().zip(&b).enumerate().filter(|(_, pair)| darker(*pair)).map(|(i, _)| i).collect();
    assert!(shadow.len() > 60, "{} pixels of shadow", shadow.len());
    // The sun is on the left, so the shadow is on the right.
    let mean_x = shadow.iter().map(|i| (i % SIZE[0] as usize) as f64).sum::<f64>() / shadow.len() as f64;
    assert!(mean_x > f64::from(SIZE[0]) * 0.55, "the shadow's middle is at {mean_x}");

    // The ball is outside the camera's view, and nearer to the sun than the first plane of the cascades. It must still
    // cast a shadow.
    test_app.world().entity_mut(ball).remove::<NotShadowCaster>().insert(Transform::from_xyz(-6.0, 6.0, 0.0));
    let far = test_app.picture(&camera);
    test_app.world().despawn(ball);
    let bare = test_app.picture(&camera);
    assert!(green_sum(&far) + 3000 < green_sum(&bare), "{} is not darker than {}", green_sum(&far), green_sum(&bare));
}

#[test]
fn bevy_cube_casts_its_shadow_on_fur() {
    let Some(mut test_app) = gpu("bevy_cube_casts_its_shadow_on_fur") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 0.0), true);
    test_app.world().spawn(Pelage::fur(model));
    let cube = test_app.spawn_cuboid(Vec3::splat(0.3), Vec3::new(-0.5, 0.5, 0.0), Color::BLACK);
    let lit = test_app.picture(&camera);
    test_app.world().entity_mut(cube).insert(PelageShadowCaster);
    let shaded = test_app.picture(&camera);
    assert!(
        green_sum(&shaded) * 3 < green_sum(&lit) * 2,
        "{} is not darker than {}",
        green_sum(&shaded),
        green_sum(&lit)
    );
    // The cube moves aside, and the shadow maps must follow.
    *test_app.world().get_mut::<Transform>(cube).unwrap() = Transform::from_xyz(-0.5, 0.5, 0.8);
    let aside = test_app.picture(&camera);
    assert!(
        green_sum(&aside) * 10 > green_sum(&lit) * 9,
        "{} is not as bright as {}",
        green_sum(&aside),
        green_sum(&lit)
    );
}

#[test]
fn exposure_suns_and_ambient_light_come_from_bevy() {
    let Some(mut test_app) = gpu("exposure_suns_and_ambient_light_come_from_bevy") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    let sun = test_app.spawn_sun(Vec3::Y, false);
    test_app.world().spawn(Pelage::fur(model));
    let full = test_app.picture(&camera);
    let default = Exposure::default().ev100;
    test_app.world().entity_mut(camera.entity).insert(Exposure { ev100: default + 2.0 });
    let darker = test_app.picture(&camera);
    assert!(
        green_sum(&darker) * 3 < green_sum(&full) * 2,
        "two stops: {} beside {}",
        green_sum(&darker),
        green_sum(&full)
    );
    test_app.world().despawn(sun);
    assert_eq!(green_sum(&test_app.picture(&camera)), 0, "without a sun there is no light");
    let ambient = bevy_light::AmbientLight { brightness: 1000.0, ..Default::default() };
    test_app.world().entity_mut(camera.entity).insert(ambient);
    assert!(green_sum(&test_app.picture(&camera)) > 10_000, "a camera's own ambient light");
    assert_eq!(test_app.renderers().logged_messages().count(), 0);

    test_app.world().entity_mut(camera.entity).remove::<Hdr>();
    (0..3).for_each(|_| drop(test_app.picture(&camera)));
    let logged: Vec<_> = test_app.renderers().logged_messages().collect();
    assert!(matches!(logged[..], [words] if words.contains("has no Hdr")), "{logged:?}");
}

#[test]
fn point_and_spot_lights_light_fur_like_suns() {
    let Some(mut test_app) = gpu("point_and_spot_lights_light_fur_like_suns") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.world().spawn(Pelage::fur(model.clone()));
    // A rectangular light does not light fur, and a warning says so.
    let unused = test_app.world().spawn(RectLight::default()).id();
    assert_eq!(green_sum(&test_app.picture(&camera)), 0);
    let warned: Vec<_> = test_app.renderers().logged_messages().map(str::to_owned).collect();
    assert!(matches!(&warned[..], [words] if words.contains("found 1 rectangular")), "{warned:?}");
    let sun = test_app.spawn_sun(Vec3::new(-1.0, 1.0, 0.0), true);
    let sunny = test_app.picture(&camera);
    test_app.remove([unused, sun]);

    // A lamp 20 m away has nearly parallel rays.
    let far = Vec3::new(-1.0, 1.0, 0.0).normalize() * 20.0;
    let power = 4.0 * PI * 400.0 * PI / Exposure::default().exposure();
    let lamp = PointLight { intensity: power, range: 1e4, shadow_maps_enabled: true, ..Default::default() };
    let at_far = Transform::from_translation(far).looking_at(Vec3::ZERO, Vec3::Y);
    let point = test_app.world().spawn((lamp, at_far)).id();
    let lit = test_app.picture(&camera);
    assert!(lit.differences(&sunny).0 < 0.5, "{:?}", lit.differences(&sunny));
    // A cube between lamp and ball shades the ball, and one beyond the lamp does not.
    let cube = test_app.spawn_cuboid(Vec3::splat(0.3), Vec3::new(-0.5, 0.5, 0.0), Color::BLACK);
    let beside = green_sum(&test_app.picture(&camera));
    test_app.world().entity_mut(cube).insert(PelageShadowCaster);
    let shaded = green_sum(&test_app.picture(&camera));
    assert!(shaded * 3 < beside * 2, "{shaded} is not darker than {beside}");
    test_app.world().entity_mut(cube).insert(Transform::from_translation(1.1 * far));
    let beyond = green_sum(&test_app.picture(&camera));
    assert!(beyond * 50 > green_sum(&lit) * 49, "{beyond} is darker than {}", green_sum(&lit));
    test_app.remove([point, cube]);

    // A spot light lights what is in its cone; an animal in reach of it has a light of its own.
    let spot = SpotLight { intensity: power, range: 1e4, ..Default::default() };
    let spot = test_app.world().spawn((spot, at_far)).id();
    let inside = test_app.picture(&camera);
    assert!(inside.differences(&sunny).0 < 2.0, "{:?}", inside.differences(&sunny));
    let other = test_app.world().spawn((Pelage::fur(model), Transform::from_xyz(0.3, 0.0, 0.0))).id();
    let both = green_sum(&test_app.picture(&camera));
    assert!(both * 2 > green_sum(&inside) * 3, "both are lit: {both}");
    test_app.world().despawn(other);
    test_app.world().entity_mut(spot).insert(at_far.looking_to(far, Vec3::Y));
    assert_eq!(green_sum(&test_app.picture(&camera)), 0, "outside the cone");
    assert_eq!(test_app.renderers().logged_messages().count(), 1);
}

fn green_sums_of_halves(picture: &Picture) -> [u64; 2] {
    let mut sums = [0; 2];
    for (i, pixel) in picture.pixels().enumerate() {
        sums[usize::from(i % SIZE[0] as usize >= SIZE[0] as usize / 2)] += u64::from(pixel[1]);
    }
    sums
}

#[test]
fn environment_map_lights_from_its_direction_and_rotates() {
    let Some(mut test_app) = gpu("environment_map_lights_from_its_direction_and_rotates") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.world().spawn(Pelage::fur(model));
    assert_eq!(green_sum(&test_app.picture(&camera)), 0, "no light");
    let lobe = |x: f32| LightLobe { towards: [x, 0.2, 0.0], width_deg: 20.0, radiance: [1.0, 6.0, 1.0] };
    let lights = Environment { lobes: vec![lobe(-1.0)], ..Environment::default() };
    let shine = |test_app: &mut TestApp, lights: Environment, intensity: f32| {
        test_app.world().insert_resource(PelageEnvironment { lights: Some(lights), intensity });
        test_app.picture(&camera)
    };
    let lit = shine(&mut test_app, lights.clone(), 60.0);
    let [left, right] = green_sums_of_halves(&lit);
    // Most of what is visible from above faces up, and is lit by the lights on both sides.
    assert!(100 * left > 108 * right && left > 3_000, "{left} {right}");
    let turned = green_sums_of_halves(&shine(&mut test_app, lights.turned(180.0), 60.0));
    assert!(100 * turned[1] > 108 * turned[0], "{turned:?}");
    let dimmer = green_sum(&shine(&mut test_app, lights, 15.0));
    assert!(dimmer * 3 < green_sum(&lit) * 2, "two stops: {dimmer} beside {}", green_sum(&lit));
    test_app.world().insert_resource(PelageEnvironment::default());
    assert_eq!(green_sum(&test_app.picture(&camera)), 0, "no light after the environment is removed");
    assert_eq!(test_app.renderers().logged_messages().count(), 0);
}

#[test]
fn fur_leans_as_time_passes_and_comes_to_rest() {
    let Some(mut test_app) = gpu("fur_leans_as_time_passes_and_comes_to_rest") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 0.0), true);
    test_app.world().spawn(Pelage::fur(model));
    let blow = |test_app: &mut TestApp, velocity: Vec3| {
        test_app.world().resource_mut::<PelageHair>().0.as_mut().unwrap().wind.velocity = velocity;
    };
    let still = test_app.picture(&camera);
    blow(&mut test_app, Vec3::new(8.0, 0.0, 0.0));
    (0..5).for_each(|_| test_app.advance(0.1));
    let blown = test_app.picture(&camera);
    assert!(blown.differences(&still).0 > 0.5, "{:?}", blown.differences(&still));
    assert_eq!(test_app.picture(&camera), blown, "nothing moves while no time passes");
    blow(&mut test_app, Vec3::ZERO);
    (0..80).for_each(|_| test_app.advance(0.1));
    let calm = test_app.picture(&camera);
    assert!(calm.differences(&still).0 < 0.05, "{:?}", calm.differences(&still));
    test_app.world().insert_resource(PelageHair(None));
    let groomed = test_app.picture(&camera);
    assert!(groomed.differences(&still).0 < 0.05, "{:?}", groomed.differences(&still));
    assert_eq!(test_app.renderers().logged_messages().count(), 0);
}

#[test]
fn clips_move_the_animal_and_faults_are_reported_once() {
    let Some(mut test_app) = gpu("clips_move_the_animal_and_faults_are_reported_once") else { return };
    let model = test_app.add_model("ball", &ball_package());
    let camera = camera(&mut test_app);
    test_app.spawn_sun(Vec3::new(-1.0, 1.0, 0.0), true);
    // Disables hair motion, which would continue while a clip is paused.
    test_app.world().insert_resource(PelageHair(None));
    let ball = test_app.world().spawn((Pelage::fur(model), PelageClip::new("bend"))).id();
    let first = test_app.picture(&camera);
    let clip = |test_app: &mut TestApp| test_app.world().get::<PelageClip>(ball).unwrap().clone();
    test_app.advance(0.25);
    assert!((clip(&mut test_app).time_s - 0.25).abs() < 1e-6, "{:?}", clip(&mut test_app));
    let bent = test_app.picture(&camera);
    assert!(bent.differences(&first).0 > 0.5, "{:?}", bent.differences(&first));
    test_app.world().get_mut::<PelageClip>(ball).unwrap().paused = true;
    test_app.advance(0.25);
    assert_eq!(test_app.picture(&camera), bent, "a paused clip does not move the animal");
    test_app.world().get_mut::<PelageClip>(ball).unwrap().time_s = 0.0;
    assert_eq!(test_app.picture(&camera), first, "seeking moves the animal back");
    test_app.world().get_mut::<PelageClip>(ball).unwrap().name = "fly".into();
    let rest = test_app.picture(&camera);
    test_app.world().entity_mut(ball).remove::<PelageClip>();
    assert_eq!(test_app.picture(&camera), rest, "an animal with an unknown clip is at rest");

    // An animal scaled to zero, and one with the pose of a different skeleton, must not affect the others.
    let model = test_app.world().get::<Pelage>(ball).unwrap().model.clone();
    let nothing = test_app.world().spawn((Pelage::fur(model.clone()), Transform::from_scale(Vec3::ZERO))).id();
    let strange = test_app.world().spawn((Pelage::fur(model), PelageJoints(vec![Mat4::IDENTITY; 5]))).id();
    assert_eq!(test_app.picture(&camera), rest);
    let logged: Vec<_> = test_app.renderers().logged_messages().collect();
    assert!(
        matches!(logged[..], [words] if words.contains("ball: PelageJoints has 5 matrices, expected 2")),
        "{logged:?}"
    );
    test_app.remove([nothing, strange]);

    let wrong = FurParams::default().with(|fur| fur.layers = Some(0));
    test_app.world().get_mut::<Pelage>(ball).unwrap().style = Style::Fur(wrong);
    (0..5).for_each(|_| test_app.app.update());
    let logged: Vec<_> = test_app.renderers().logged_messages().collect();
    let names_layers = |words: &&str| words.contains("FurParams::layers is 0, expected 1..=1024");
    assert!(logged.len() == 2 && logged.iter().any(names_layers), "{logged:?}");
    test_app.world().get_mut::<Pelage>(ball).unwrap().style = Style::default();
    assert_eq!(test_app.picture(&camera), rest, "the app continues after the error");
}
