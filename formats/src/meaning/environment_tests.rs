use super::*;
use core::f64::consts::PI;

fn lobe(towards: [f32; 3], width_deg: f32, radiance: [f32; 3]) -> LightLobe {
    LightLobe { towards, width_deg, radiance }
}

/// Directions distributed evenly over the sphere, and the solid angle of each.
fn sphere(count: usize) -> impl Iterator<Item = (DVec3, f64)> {
    (0..count).map(move |i| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, cos) = libm::sincos(2.399_963_229_728_653 * i as f64);
        let radius = (1.0 - y * y).sqrt();
        (DVec3::new(radius * cos, y, radius * sin), 4.0 * PI / count as f64)
    })
}

fn all_light(environment: &Environment) -> DVec3 {
    sphere(40_000).map(|(way, angle)| environment.radiance(way) * angle).sum()
}

#[test]
fn total_light_is_the_integral_over_directions() {
    let lobes = vec![lobe([0.3, 1.0, -0.5], 8.0, [9.0, 4.0, 1.0]), lobe([-1.0, 0.0, 0.0], 70.0, [0.1, 0.2, 0.4])];
    let sky = Environment { even: [0.5, 0.25, 0.125], lobes, sun: None };
    let off = (all_light(&sky) / sky.total() - 1.0).abs().max_element();
    assert!(off < 1e-3, "{off}");
    let sun = Sun { towards: [0.0, 2.0, 0.0], color: [1.0, 0.5, 0.0] };
    let more = Environment { sun: Some(sun), ..sky.clone() }.total() - sky.total();
    assert!((more - PI * DVec3::new(1.0, 0.5, 0.0)).length() < 1e-12, "{more}");
}

#[test]
fn ground_receives_light_from_the_upper_hemisphere() {
    let sun = Sun { towards: [0.6, 0.8, 0.0], color: [1.0, 2.0, 0.0] };
    let lobes = vec![lobe([0.3, 1.0, -0.5], 20.0, [9.0, 4.0, 1.0]), lobe([0.0, -1.0, 0.0], 20.0, [9.0, 9.0, 9.0])];
    let sky = Environment { even: [0.5, 0.25, 0.125], lobes, sun: Some(sun) };
    let sum = sphere(40_000).map(|(way, angle)| sky.radiance(way) * (way.y.max(0.0) * angle / PI)).sum::<DVec3>();
    let expected = sum + 0.8 * DVec3::new(1.0, 2.0, 0.0);
    assert!(
        (sky.ground_irradiance() / expected - 1.0).abs().max_element() < 2e-3,
        "{} {expected}",
        sky.ground_irradiance()
    );
    let low = Environment { sun: Some(Sun { towards: [1.0, -0.2, 0.0], ..sun }), ..Environment::default() };
    assert_eq!(low.ground_irradiance(), DVec3::ZERO);
}

#[test]
fn gradient_environment_varies_from_bottom_to_top() {
    let sky = Environment::gradient([1.0, 0.2, 0.5], [0.25, 0.4, 0.5]);
    assert_eq!((sky.lobes.len(), sky.fault()), (2, None));
    let [below, side, above] = [DVec3::NEG_Y, DVec3::X, DVec3::Y].map(|way| sky.radiance(way));
    let near = |found: DVec3, expected: [f64; 3]| (found - DVec3::from(expected)).abs().max_element() < 0.1;
    assert!(near(above, [1.0, 0.2, 0.5]) && near(below, [0.25, 0.4, 0.5]), "{above} {below}");
    assert!(below.x < side.x && side.x < above.x && below.y > side.y && side.y > above.y, "{side}");
    assert_eq!(Environment::gradient([2.0; 3], [2.0; 3]), Environment::constant([2.0; 3]));
}

#[test]
fn quarter_turn_rotates_lobes_and_sun_about_y() {
    let sky = Environment {
        lobes: vec![lobe([1.0, 0.5, 0.0], 20.0, [1.0; 3])],
        sun: Some(Sun { towards: [0.0, 0.0, 1.0], color: [1.0; 3] }),
        ..Environment::default()
    };
    let middle = sky.mean_direction();
    assert!(middle.x > 0.0 && middle.z > middle.x && Environment::default().mean_direction() == DVec3::Y, "{middle}");
    let turned = sky.turned(90.0);
    assert!(Vec3::from(turned.lobes[0].towards).distance(Vec3::new(0.0, 0.5, -1.0)) < 1e-6);
    assert!(Vec3::from(turned.sun.unwrap().towards).distance(Vec3::X) < 1e-6);
    assert!((turned.turned(-90.0).radiance(DVec3::X) - sky.radiance(DVec3::X)).length() < 1e-6);
}

#[test]
fn sharpness_and_mean_cosine_are_inverse_functions() {
    for k in [0.0, 1e-4, 0.02, 0.5, 3.0, 40.0, 900.0] {
        let found = sharpness_of(mean_cosine(k));
        assert!((found - k).abs() < 1e-4 * (1.0 + k), "{k}: {found}");
    }
    assert!(sharpness_of(1.0).is_finite() && sharpness_of(-1.0) == 0.0);
}

/// At one half, the blend is the mean of both environments in every direction. At 0 and 1, it equals one of them.
#[test]
fn blended_skies_interpolate_every_direction() {
    let many = |seed: f32| Environment {
        even: [seed; 3],
        lobes: (0..24)
            .map(|i| {
                let (sin, cos) = libm::sincosf(seed + i as f32);
                lobe([cos, 0.2 * sin + 0.01 * i as f32, sin], 10.0 + i as f32, [seed, 1.0, 0.1 * i as f32])
            })
            .collect(),
        sun: None,
    };
    let (day, dusk) = (many(0.2), many(0.7));
    let half = day.blended(&dusk, 0.5);
    assert_eq!((half.lobes.len(), half.fault()), (Environment::MOST_LOBES, None));
    let expected = 0.5 * (day.total() + dusk.total());
    assert!((half.total() / expected - 1.0).abs().max_element() < 1e-5, "light is neither lost nor made");
    let off = |way: DVec3| (half.radiance(way) - 0.5 * (day.radiance(way) + dusk.radiance(way))).length();
    let size = |way: DVec3| day.radiance(way).length();
    let (worst, most) =
        sphere(500).fold((0.0, 0.0), |(a, b): (f64, f64), (way, _)| (a.max(off(way)), b.max(size(way))));
    assert!(worst < 0.15 * most, "{worst} of {most}");
    assert_eq!((day.blended(&dusk, 0.0), day.blended(&dusk, 1.0)), (day.clone(), dusk.clone()));
    let fewer = day.with_fewer(4);
    assert_eq!(fewer.lobes.len(), 4);
    assert!((fewer.total() / day.total() - 1.0).abs().max_element() < 1e-5);
    assert_eq!(day.with_fewer(0).lobes.len(), 1);
}

#[test]
fn blended_sun_moves_and_keeps_its_light() {
    let with = |towards: [f32; 3], color| Environment { sun: Some(Sun { towards, color }), ..Environment::default() };
    let (noon, dusk) = (with([0.0, 1.0, 0.0], [4.0; 3]), with([1.0, 0.0, 0.0], [2.0, 1.0, 0.0]));
    let between = noon.blended(&dusk, 0.5).sun.unwrap();
    assert_eq!(between.color, [3.0, 2.5, 2.0]);
    assert!(Vec3::from(between.towards).distance(Vec3::new(1.0, 1.0, 0.0).normalize()) < 1e-6);
    let gone = noon.blended(&Environment::default(), 0.75).sun.unwrap();
    assert_eq!((gone.towards, gone.color), ([0.0, 1.0, 0.0], [1.0; 3]));
}

#[test]
fn environment_errors_name_the_field() {
    let with = |bad: LightLobe| Environment {
        lobes: vec![lobe([0.0, 1.0, 0.0], 9.0, [1.0; 3]), bad],
        ..Environment::default()
    };
    let crowd = Environment { lobes: vec![lobe([1.0; 3], 9.0, [1.0; 3]); 33], ..Environment::default() };
    for (sky, key, expected) in [
        (Environment::constant([-1.0, 0.0, 0.0]), "even", "found [-1.0, 0.0, 0.0], expected 0 to 1e9 each"),
        (with(lobe([0.0; 3], 9.0, [1.0; 3])), "lobe[1].towards", "found [0.0, 0.0, 0.0], expected a direction"),
        (with(lobe([1.0; 3], 2.0, [1.0; 3])), "lobe[1].width_deg", "found 2, expected 4 to 120 degrees"),
        (with(lobe([1.0; 3], 9.0, [f32::NAN; 3])), "lobe[1].radiance", "found [NaN, NaN, NaN]"),
        (crowd, "lobe", "found 33 lobes, expected at most 32"),
    ] {
        let (found, reason) = sky.fault().unwrap();
        assert!(found == key && reason.contains(expected), "{found}: {reason}");
    }
}
