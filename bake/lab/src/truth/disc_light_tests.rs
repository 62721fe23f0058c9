use super::*;
use crate::stability::surface::sphere;
use glam::vec3;

/// Returns a floor 20 m wide at y = 0, and at `height` above it a half plane that covers x < 0.
fn floor_and_half_plane(height: f32) -> Occluder {
    let corners = |y: f32, to: f32| [vec3(-10., y, -10.), vec3(to, y, -10.), vec3(to, y, 10.), vec3(-10., y, 10.)];
    let positions = [corners(0.0, 10.0), corners(height, 0.0)].concat();
    let triangles = [[0, 2, 1], [0, 3, 2], [4, 6, 5], [4, 7, 6]];
    Occluder::new(&positions, &triangles).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns the fraction of a disc on one side of a line at `x` radii from the disc's centre.
fn cut_disc(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI
}

#[test]
fn penumbra_of_a_half_plane_matches_the_formula() {
    let (height, penumbra) = (0.5, 0.3);
    let scene = floor_and_half_plane(height);
    let width = penumbra * f64::from(height);
    for step in -12..=12i32 {
        let x = width * f64::from(step) / 16.0;
        // The light is straight above. Seen from x, the edge cuts the light's disc 2x / `width` radii from the disc's
        // centre.
        let truth = cut_disc(2.0 * x / width);
        let distant = DiscLight::Directional { towards_light_ws: DVec3::Y * 3.0, penumbra };
        let share = scene.visible_share(DVec3::new(x, 0.0, 0.1), DVec3::Y, &distant, 4096);
        assert!((share - truth).abs() < 0.01, "at {x}: found {share}, expected {truth}");
        if step.abs() > 8 {
            assert_eq!(share, truth.round(), "at {x}, outside of the penumbra");
        }
        // Charts use 256 rays, so their error is tested as well.
        let rough = scene.visible_share(DVec3::new(x, 0.0, 0.1), DVec3::Y, &distant, 256);
        assert!((rough - truth).abs() < 0.04, "at {x}: found {rough}, expected {truth}");
        // A point light straight above each point gives the same visible fraction; the half plane is halfway to it.
        let near = DiscLight::Point { position_ws: DVec3::new(x, 5.0, 0.1), penumbra };
        let share = scene.visible_share(DVec3::new(x, 0.0, 0.1), DVec3::Y, &near, 4096);
        assert!((share - truth).abs() < 0.01, "point light at {x}: found {share}, expected {truth}");
    }
    // A slanted light shifts the shadow of the edge and widens its penumbra.
    let towards_light_ws = DVec3::new(1.0, 1.0, 0.0);
    let sharp = DiscLight::Directional { towards_light_ws, penumbra: 0.0 };
    let share = |x: f64, light: &DiscLight| scene.visible_share(DVec3::new(x, 0.0, 0.1), DVec3::Y, light, 4096);
    assert_eq!([share(-0.51, &sharp), share(-0.49, &sharp)], [0.0, 1.0]);
    let soft = DiscLight::Directional { towards_light_ws, penumbra: 0.05 };
    assert!((share(-0.5, &soft) - 0.5).abs() < 0.02);
    // The distance along the ray is √2 times the height, and the slant of the floor widens the penumbra by another √2.
    assert!((share(-0.5 + 0.5 * 0.025, &soft) - cut_disc(0.5)).abs() < 0.03);
}

#[test]
fn point_light_below_the_occluder_is_visible() {
    let scene = floor_and_half_plane(0.5);
    let share = |height: f64| {
        let light = DiscLight::Point { position_ws: DVec3::new(-1.0, height, 0.0), penumbra: 0.1 };
        scene.visible_share(DVec3::new(-1.0, 0.0, 0.1), DVec3::Y, &light, 64)
    };
    assert_eq!([share(0.45), share(0.55)], [1.0, 0.0]);
}

/// Checks that a convex surface does not shadow itself, except where it faces away from the light.
#[test]
fn a_sphere_is_lit_on_one_side() {
    for scale in [1e-3, 1.0, 1e3] {
        let mesh = sphere(24, 48).mesh;
        let offset = vec3(5.0, -3.0, 2.0) * scale;
        let positions: Vec<Vec3> = mesh.positions.iter().map(|p| *p * scale + offset).collect();
        let scene = Occluder::new(&positions, &mesh.triangles).unwrap_or_else(|e| panic!("{e}"));
        let light = DiscLight::Directional { towards_light_ws: DVec3::new(0.3, 0.8, -0.2), penumbra: 0.1 };
        let DiscLight::Directional { towards_light_ws, .. } = light else {
            unreachable!("the light was created as a directional one")
        };
        let mut lit = 0;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| positions[i as usize].as_dvec3());
            let normal = (b - a).cross(c - a).normalize();
            let middle = (a + b + c) / 3.0;
            // Tests points beside corners and edges, where rounding matters. A point exactly on an edge may be lit as
            // part of the next triangle.
            for point in [a, (a + b) / 2.0, middle].map(|p| p.lerp(middle, 0.1)) {
                let share = scene.visible_share(point, normal, &light, 64);
                let facing = normal.dot(towards_light_ws.normalize());
                // A flat triangle sees all of the light or none of it, except where the light's rim is near the
                // horizon.
                if facing > 0.07 {
                    assert_eq!(share, 1.0, "scale {scale}, N·L {facing}");
                    lit += 1;
                } else if facing < -0.07 {
                    assert_eq!(share, 0.0, "scale {scale}, N·L {facing}");
                }
            }
        }
        assert!(lit > mesh.triangles.len(), "{lit} points in the light");
    }
}

#[test]
fn rays_cover_the_light_disc_evenly() {
    let points: Vec<glam::DVec2> = stratified(3, 10_000).map(disc).collect();
    assert!(points.iter().all(|p| p.length() <= 1.0));
    for radius in [0.25, 0.5, 0.75] {
        let inside = points.iter().filter(|p| p.length() < radius).count() as f64 / 1e4;
        assert!((inside - radius * radius).abs() < 0.01, "{inside} within {radius}");
    }
    let right = points.iter().filter(|p| p.x > 0.0).count();
    let upper = points.iter().filter(|p| p.y > 0.5).count() as f64 / 1e4;
    assert!((4900..=5100).contains(&right) && (upper - cut_disc(-0.5)).abs() < 0.01, "{right}, {upper}");
}

#[test]
fn degenerate_meshes_and_lights_are_handled() {
    let light = DiscLight::Directional { towards_light_ws: DVec3::Y, penumbra: 0.1 };
    for (positions, triangles) in [
        (vec![], vec![]),
        (vec![Vec3::ONE], vec![]),
        (vec![Vec3::Y; 3], vec![[0, 1, 2]]),
        (vec![Vec3::Y, Vec3::X, Vec3::Y], vec![[0, 1, 2]]),
    ] {
        let scene = Occluder::new(&positions, &triangles).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.visible_share(DVec3::ZERO, DVec3::Y, &light, 16), 1.0);
    }
    assert!(Occluder::new(&[Vec3::ZERO], &[[0, 0, 1]]).is_err());
    assert!(Occluder::new(&[Vec3::NAN], &[]).is_err());
    let scene = floor_and_half_plane(1.0);
    let nowhere = DiscLight::Directional { towards_light_ws: DVec3::ZERO, penumbra: 0.1 };
    assert_eq!(scene.visible_share(DVec3::ZERO, DVec3::Y, &nowhere, 16), 1.0);
}
