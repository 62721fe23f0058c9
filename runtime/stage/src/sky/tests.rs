#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;
use glam::{DVec3, Vec3};

fn painted(size: (u32, u32), radiance: impl Fn(DVec3) -> DVec3) -> Panorama {
    Panorama::from_fn(size, radiance).unwrap()
}

fn lobe(towards: [f32; 3], width_deg: f32, radiance: [f32; 3]) -> LightLobe {
    LightLobe { towards, width_deg, radiance }
}

#[test]
fn panorama_orientation_matches_other_programs() {
    let sky = painted((8, 4), |_| DVec3::ONE);
    assert!(sky.towards(0, 0).y > 0.9 && sky.towards(0, 3).y < -0.9, "rows must go downwards");
    // The centre of the picture is +x; +z is to the right of it.
    assert_eq!([DVec3::X, DVec3::Z, DVec3::NEG_Z].map(|way| sky.pixel(way).0), [4, 6, 2]);
    for (x, y) in [(0, 0), (7, 3), (3, 1)] {
        assert_eq!(sky.pixel(sky.towards(x, y)), (x, y));
    }
    // Equal fractions of a pixel's area are equal fractions of its solid angle.
    let within = sky.towards_within(5, 1, [0.5, 0.5]);
    assert_eq!(sky.pixel(within), (5, 1));
    assert!((within.y - 0.5 * libm::cos(std::f64::consts::FRAC_PI_4)).abs() < 1e-12, "{within}");
    assert!((sky.total() / (4.0 * std::f64::consts::PI) - 1.0).abs().max_element() < 1e-12);
}

#[test]
fn downscaling_a_panorama_keeps_its_total_light() {
    let sky = painted((37, 19), |way| DVec3::new(1.0 + way.x, 2.0 + way.y, 1.0 + way.z * way.x));
    for size in [(64, 32), (16, 8), (5, 3), (1, 1)] {
        let less = sky.reduced(size);
        assert!((less.total() / sky.total() - 1.0).abs().max_element() < 1e-6, "{size:?}");
    }
    assert_eq!(sky.reduced((64, 32)).size(), (37, 19));
}

#[test]
fn invalid_panorama_pixels_are_repaired() {
    let mut pixels = vec![[1.0, 2.0, 0.5]; 8];
    (pixels[1], pixels[3], pixels[6]) = ([f32::NAN, 1.0, 1.0], [f32::INFINITY; 3], [-1.0, 0.0, 1.0]);
    let sky = Panorama::new(4, 2, pixels).unwrap();
    assert_eq!(sky.mended(), 3);
    assert_eq!([1, 3, 6].map(|i| sky.pixels()[i]), [[0.0, 1.0, 1.0], [2.0; 3], [0.0, 0.0, 1.0]]);
    for (size, count) in [((0, 4), 0), ((2, 2), 3), ((1 << 16, 1 << 16), 4)] {
        let error = Panorama::new(size.0, size.1, vec![[0.0; 3]; count]).unwrap_err().to_string();
        assert!(error.contains("pixels") && error.contains("expected"), "{error}");
    }
}

/// Checks that the fit of a sky made of lobes and uniform light recovers them.
#[test]
fn lobe_environments_are_recovered_by_the_fit() {
    let lobes = vec![lobe([0.0, 1.0, 0.0], 30.0, [1.0, 2.0, 4.0]), lobe([1.0, 0.2, -0.4], 12.0, [8.0, 4.0, 1.0])];
    let made = Environment { even: [0.2, 0.3, 0.1], sun: None, lobes };
    let found = painted((128, 64), |way| made.radiance(way)).fit(FitParams { lobes: 8, sun: 2.0 });
    assert!(found.error < 0.02 && found.energy < 1e-3, "{} {}", found.error, found.energy);
    for way in [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::new(1.0, 0.2, -0.4).normalize()] {
        let off = (found.environment.radiance(way) - made.radiance(way)).abs().max_element();
        assert!(off < 0.15, "{way}: {} for {}", found.environment.radiance(way), made.radiance(way));
    }
    assert_eq!(found.environment.sun, None);
}

#[test]
fn dominant_sun_becomes_a_separate_light() {
    let towards = DVec3::new(0.5, 0.6, -0.3).normalize();
    let sky = |bright: f64| {
        painted((256, 128), |way| {
            let sun = if way.dot(towards) > libm::cos(1.5_f64.to_radians()) { bright } else { 0.0 };
            DVec3::new(0.5, 0.7, 1.0) + DVec3::splat(sun)
        })
    };
    let found = sky(2_000.0).fit(FitParams::default());
    let sun = found.environment.sun.unwrap();
    assert!(Vec3::from(sun.towards).as_dvec3().dot(towards) > libm::cos(0.7_f64.to_radians()), "{sun:?}");
    assert!(found.sun_share > 0.2 && found.sun_share < 0.9, "{}", found.sun_share);
    let whole = found.environment.total() / sky(2_000.0).total();
    assert!((whole - 1.0).abs().max_element() < 1e-3, "{whole}");
    // Without the sun the sky is uniform.
    assert!(found.environment.lobes.is_empty() || found.error < 0.01, "{found:?}");
    let dim = sky(20.0).fit(FitParams::default());
    assert_eq!(dim.environment.sun, None);
    assert!(!dim.environment.lobes.is_empty());
}

#[test]
fn panorama_lookups_interpolate_and_wrap() {
    let sky = painted((64, 32), |way| DVec3::new(2.0 + way.x, 2.0 + way.y, 2.0 + way.z));
    for way in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::new(-0.9, 0.3, 0.01), DVec3::new(0.2, -0.9, -0.3), DVec3::Y] {
        let way = way.normalize();
        assert!((sky.sample(way) - 2.0 - way).abs().max_element() < 0.06, "{way}: {}", sky.sample(way));
    }
    // There must be no seam where the columns wrap around.
    let [one, other] = [1e-6, -1e-6].map(|z| sky.sample(DVec3::new(-1.0, 0.0, z).normalize()));
    assert!((one - other).length() < 1e-4, "{one} {other}");
}

/// Checks that the whole ground reflects its albedo times the light that falls on it. The picture above the horizon
/// must be unchanged.
#[test]
fn ground_reflects_its_albedo() {
    let sky = painted((256, 128), |way| if way.y > 0.0 { DVec3::new(1.0, 2.0, 4.0) } else { DVec3::splat(50.0) });
    let over = sky.over_ground([0.5, 0.25, 0.0], DVec3::new(0.0, 2.0, 0.0));
    assert_eq!(over.sample(DVec3::Y), sky.sample(DVec3::Y));
    let below = over.sample(DVec3::new(0.3, -0.6, 0.2).normalize());
    assert!((below - DVec3::new(0.5, 1.0, 0.0)).abs().max_element() < 1e-3, "{below}");
    let black = sky.over_ground([0.0; 3], DVec3::ZERO);
    assert!((black.total() / sky.total()).max_element() < 0.5 && black.sample(DVec3::NEG_Y) == DVec3::ZERO);
}

#[test]
fn black_and_single_pixel_skies_fit_valid_lights() {
    let black = painted((64, 32), |_| DVec3::ZERO).fit(FitParams::default());
    assert_eq!(black.environment, Environment::default());
    assert_eq!((black.error, black.energy, black.sun_share), (0.0, 0.0, 0.0));
    let even = painted((1, 1), |_| DVec3::new(0.5, 1.0, 2.0)).fit(FitParams { sun: 2.0, ..FitParams::default() });
    assert!((DVec3::from(even.environment.even.map(f64::from)) - DVec3::new(0.5, 1.0, 2.0)).length() < 1e-6);
    let lone = painted((512, 256), |way| if way.y > 0.999_9 { DVec3::splat(1e30) } else { DVec3::ZERO });
    let lone = lone.fit(FitParams::default());
    assert!(lone.environment.sun.is_some() && lone.sun_share > 0.99 && lone.environment.lobes.is_empty(), "{lone:?}");
}

/// Checks that a floor replaces all light from below by its albedo times the light that falls on it.
#[test]
fn studio_has_valid_lights_and_any_floor() {
    let own = studio(None);
    assert_eq!(own.fault(), None);
    assert_eq!(environment_from_toml("studio.toml", &environment_to_toml(&own)).unwrap(), own);
    let floor = [0.5, 0.25, 0.0];
    let over = studio(Some(floor));
    assert_eq!((over.fault(), over.sun), (None, own.sun));
    let light = own.ground_irradiance();
    let lobes = |lights: &Environment| Environment { even: [0.0; 3], ..lights.clone() }.radiance(DVec3::NEG_Y);
    let expected = DVec3::from(floor.map(f64::from)) * light;
    assert!((lobes(&over) - expected).abs().max_element() < 0.01, "{}, expected {expected}", lobes(&over));
}

#[test]
fn environment_survives_a_toml_round_trip() {
    let sky = Environment {
        even: [0.25, 0.5, 0.125],
        sun: Some(Sun { towards: [0.1, 0.9, -0.3], color: [3.5, 3.0, 2.5] }),
        lobes: vec![lobe([0.0, 1.0, 0.0], 30.0, [1.0, 2.0, 4.0]), lobe([1.0, 0.2, -0.4], 12.1, [1e-7, 4.0, 1e6])],
    };
    let text = environment_to_toml(&sky);
    assert_eq!(environment_from_toml("sky.toml", &text).unwrap(), sky);
    assert_eq!(environment_from_toml("sky.toml", "").unwrap(), Environment::default());
    for (text, expected) in [
        ("even = [1, 1, -1]", "sky.toml: line 1, even: found [1.0, 1.0, -1.0], expected 0 to 1e9 each"),
        ("[[lobe]]\ntowards = [0, 1, 0]\nwidth_deg = 1\nradiance = [1, 1, 1]", "line 3, lobe[0].width_deg: found 1"),
        ("evn = [1, 1, 1]", "line 1, evn: unknown field `evn`"),
        ("[sun]\ntowards = [0, 1, 0]", "missing field `color`"),
        ("even = ", "line 1"),
    ] {
        let error = environment_from_toml("sky.toml", text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}
