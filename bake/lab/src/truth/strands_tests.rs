use super::*;
use crate::stability::{grow, slice};
use crate::truth::SampledVolume;
use glam::{Vec3, vec3};
use pelage_bake::recipe::natural;

/// Returns straight strands of constant radius between pairs of points.
fn strands(lines: &[[Vec3; 2]], radius: f32, height: f32) -> Strands {
    let points: Vec<Vec3> = lines.iter().flatten().copied().collect();
    Strands {
        radii: vec![radius; points.len()],
        colors: vec![Vec3::ONE; points.len()],
        offsets: (0..=lines.len() as u32).map(|i| 2 * i).collect(),
        points,
        height,
        root_color: Vec3::ONE,
    }
}

fn field(lines: &[[Vec3; 2]], radius: f32) -> StrandField {
    StrandField::new(&strands(lines, radius, 0.5)).unwrap_or_else(|e| panic!("{e}"))
}

fn towards(angle_deg: f64, azimuth_deg: f64) -> DVec3 {
    let (a, b) = (angle_deg.to_radians(), azimuth_deg.to_radians());
    DVec3::new(a.sin() * b.cos(), a.sin() * b.sin(), a.cos())
}

/// Returns the mean transmittance over the tile, sampled at points that do not depend on the hairs.
fn mean(field: &StrandField, z: f64, light: DVec3) -> f64 {
    field.transmittance(0.5, 0.5, z, 1.0, light, 90_000)
}

/// Checks a layer of parallel hairs at height 0.25, four per tile, that run along v from tile to tile. Seen from the
/// mesh surface, they cover four diameters of the tile's width. Light slanted across the hairs sees narrower gaps; a
/// slant along them has no effect.
#[test]
fn parallel_hairs_cover_the_sum_of_their_diameters() {
    let line = |i: u8| {
        let u = 0.25 * f32::from(i) + 0.1;
        [vec3(u, -0.1, 0.25), vec3(u, 0.95, 0.25)]
    };
    let radius = 0.02;
    let wall = field(&[line(0), line(1), line(2), line(3)], radius);
    let share = 8.0 * f64::from(radius);
    for (angle, azimuth) in [(0.0, 0.0f64), (40.0, 0.0), (40.0, 90.0), (60.0, 30.0), (-60.0, 10.0)] {
        let light = towards(angle, azimuth);
        // Along the ray, the spacing of the hairs shrinks by the cosine of the slant across them.
        let across = light.z / (light.x * light.x + light.z * light.z).sqrt();
        let truth = 1.0 - share / across;
        let found = mean(&wall, 0.0, light);
        assert!((found - truth).abs() < 2e-3, "{angle}° {azimuth}°: {found}, not {truth}");
        assert_eq!(mean(&wall, 0.3, light), 1.0, "no hair is above this point");
    }
    // From the height of the hairs' axes, only rays that start in a hair are blocked.
    assert!((mean(&wall, 0.25, DVec3::Z) - (1.0 - share)).abs() < 2e-3);
    // Single points: light is visible between hairs and blocked under a hair, in any tile.
    for tile in [-3.0, 0.0, 11.0] {
        assert_eq!(wall.transmittance(0.1 + tile, 0.4, 0.0, 0.01, DVec3::Z, 9), 0.0);
        assert_eq!(wall.transmittance(0.225 + tile, 0.4 + tile, 0.0, 0.01, DVec3::Z, 9), 1.0);
    }
    // At a hair's edge, half of a small square is under the hair.
    let edge = wall.transmittance(0.12, 0.4, 0.0, 0.004, DVec3::Z, 10_000);
    assert!((edge - 0.5).abs() < 0.01, "{edge}");
}

/// Checks that a single upright hair casts a shadow of its own width. The shadow is as long as the hair's height times
/// the tangent of the light's angle, and continues through the next tiles.
#[test]
fn upright_hair_casts_a_shadow_of_its_length() {
    let (radius, height) = (0.01, 0.5);
    let hair = field(&[[vec3(0.2, 0.7, 0.0), vec3(0.2, 0.7, height)]], radius);
    for (angle, azimuth) in [(30.0f64, 0.0), (60.0, 40.0), (75.0, 250.0)] {
        let light = towards(angle, azimuth);
        // The shadow is a rectangle plus the projected ends: a disc at the root, within the hair itself, and the half
        // sphere at the tip.
        let (r, length) = (f64::from(radius), f64::from(height) * angle.to_radians().tan());
        let shadow = 2.0 * r * length + 0.5 * std::f64::consts::PI * r * r * (1.0 + 1.0 / light.z);
        let found = 1.0 - mean(&hair, 0.0, light);
        assert!((found / shadow - 1.0).abs() < 0.06, "{angle}°: {found}, not {shadow}");
        // Tests points in the shadow of three quarters of the hair's height, several tiles away. The last point is
        // beside the shadow.
        let t = |side: f64| {
            let away = -0.75 * length;
            let (u, v) = (0.2 + away * azimuth.to_radians().cos(), 0.7 + away * azimuth.to_radians().sin());
            let (su, sv) = (-azimuth.to_radians().sin() * side, azimuth.to_radians().cos() * side);
            hair.transmittance(u + su + 4.0, v + sv - 1.0, 0.0, 1e-4, light, 4)
        };
        assert_eq!([t(0.0), t(0.9 * r), t(1.1 * r)], [0.0, 0.0, 1.0], "{angle}°");
    }
}

/// Checks a strand that leans from one tile into the next, across the light's direction. It must not block its own
/// light, but its copies must, wherever the tile's borders are. A second strand always blocks the light.
#[test]
fn strand_is_shadowed_by_its_copies_and_not_by_itself() {
    let (radius, root) = (0.02f32, vec3(0.9, 0.5, 0.0));
    let tip = root + vec3(0.5, 0.0, 0.25);
    for shift in [Vec3::ZERO, vec3(-3.0, 7.0, 0.0), vec3(0.4, 0.3, 0.0)] {
        let leaning = [root + shift, tip + shift];
        let alone = field(&[leaning], radius);
        let place = leaning[0].lerp(leaning[1], 0.3).as_dvec3();
        // With light along the strand, the rest of the strand is in the way. It does not block the strand's own light,
        // but blocks that of another strand.
        let along = (tip - root).as_dvec3();
        assert!(alone.lights_strand(place, 0, along) && !alone.lights_strand(place, 1, along));
        assert!(alone.lights_strand(place, 0, DVec3::new(1.0, 0.0, 0.6)), "the ray must pass above the copy");
        assert!(
            !alone.lights_strand(place, 0, DVec3::new(1.0, 0.0, 0.05)),
            "the copy in the next tile must block the ray"
        );
        assert!(
            !alone.lights_strand(place, 0, DVec3::new(-1.0, 0.0, 0.05)),
            "the copy in the previous tile must block the ray"
        );
        assert!(alone.lights_strand(place, 0, DVec3::new(0.0, 1.0, 2.0)));
        assert!(!alone.lights_strand(place, 0, -DVec3::Z) && !alone.lights_strand(place, 0, DVec3::ZERO));
        let above = place.as_vec3() + vec3(0.0, 0.0, 0.1);
        let roof = [above - vec3(0.0, 0.2, 0.0), above + vec3(0.0, 0.2, 0.0)];
        let both = field(&[leaning, roof], radius);
        assert!(!both.lights_strand(place, 0, DVec3::Z) && both.lights_strand(place, 0, DVec3::new(1.0, 0.0, 1.0)));
    }
}

#[test]
fn tile_without_hair_transmits_all_light() {
    for strands in [Strands { height: 0.5, ..Strands::default() }, strands(&[[Vec3::ZERO, Vec3::Z]], 0.0, 1.0)] {
        let field = StrandField::new(&strands).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(field.transmittance(0.3, 0.3, 0.0, 0.1, towards(85.0, 3.0), 16), 1.0);
        assert_eq!(field.transmittance(0.3, 0.3, 0.0, 0.1, -DVec3::Z, 16), 0.0);
    }
    let mut broken = strands(&[[Vec3::ZERO, Vec3::Z]], 0.1, 1.0);
    broken.points[1].x = f32::NAN;
    assert!(StrandField::new(&broken).is_err());
}

#[test]
fn transmittance_is_periodic_and_zero_for_light_from_below() {
    let hair = pelage_bake::recipe::HairParams { density: 60, lean: 0.7, ..natural().hair };
    let field = grow(&hair, 0.4).and_then(|s| StrandField::new(&s)).unwrap_or_else(|e| panic!("{e}"));
    let mut shares = Vec::new();
    for i in 0..100 {
        let f = f64::from(i);
        let (u, v, z) = ((f * 0.618).fract(), (f * 0.381).fract(), 0.4 * (f * 0.271).fract());
        let light = towards(80.0 * (f * 0.137).fract(), 360.0 * (f * 0.911).fract());
        let t = |du: f64, dv: f64| field.is_free(DVec3::new(u + du, v + dv, z), light, None);
        assert_eq!(t(0.0, 0.0), t(5.0, -7.0), "{u} {v} {z} {light}");
        shares.push(t(0.0, 0.0));
    }
    let free = shares.iter().filter(|free| **free).count();
    assert!((10..=90).contains(&free), "{free} of 100 rays are free, expected both free and blocked rays");
    for light in [DVec3::X, -DVec3::Z, DVec3::ZERO, DVec3::NAN] {
        assert_eq!(field.transmittance(0.5, 0.5, 0.1, 0.1, light, 4), 0.0);
    }
    // A horizontal ray above all hair leaves at once; one within the hair is blocked somewhere.
    assert_eq!(field.transmittance(0.5, 0.5, 0.5, 0.0, DVec3::new(1.0, 0.7, 1e-9), 1), 1.0);
    assert_eq!(field.transmittance(0.5, 0.5, 0.1, 0.0, DVec3::new(1.0, 0.7, 1e-9), 1), 0.0);
}

/// Checks hairs many texels wide, for which layers and rays must agree except for the volume's blur and density.
#[test]
fn layers_of_wide_hairs_agree_with_ray_casting() {
    let hair = pelage_bake::recipe::HairParams {
        density: 12,
        root_radius: 0.05,
        tip_radius: 0.04,
        lean: 0.2,
        frizz: 0.0,
        length_variation: 0.2,
        ..natural().hair
    };
    let strands = grow(&hair, 0.4).unwrap_or_else(|e| panic!("{e}"));
    let field = StrandField::new(&strands).unwrap_or_else(|e| panic!("{e}"));
    let set = slice(&strands, 32, 128).unwrap_or_else(|e| panic!("{e}"));
    let volume = SampledVolume::new(&set, strands.height.into()).unwrap_or_else(|e| panic!("{e}"));
    let mut shares = Vec::new();
    for angle in [0.0, 30.0, 60.0] {
        let light = towards(angle, 70.0);
        for layer in [4usize, 16] {
            let t = volume.layer_transmittances(layer, light);
            let volume_mean = t.iter().sum::<f64>() / t.len() as f64;
            let rays = mean(&field, layer as f64 * volume.spacing(), light);
            // Along the hairs, the tails of their Gaussians add up to more than the hairs' width, so the volume is
            // darker.
            let tolerance = if angle < 45.0 { 0.1 } else { 0.045 };
            assert!(
                (volume_mean - rays).abs() < tolerance,
                "{angle}°, layer {layer}: {volume_mean} in the volume, {rays} by rays"
            );
            shares.push(rays);
        }
    }
    // The differences between layers and between angles exceed the tolerance, so agreement is meaningful.
    assert!(shares[0] - shares[4] > 0.3 && shares[5] - shares[4] > 0.15, "{shares:?}");
}
