use super::*;
use crate::stages::fixtures::part;

/// Builds a furred strip of 1 m along x from 0, and bare triangles. The strip has a vertex every centimetre and
/// separate vertices for each triangle.
fn strip(bare: &[[Vec3; 3]]) -> (Mesh, RestPose) {
    let mut mesh = Mesh::default();
    let mut add = |corners: [Vec3; 3]| {
        let base = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.triangles.push([base, base + 1, base + 2]);
    };
    for i in 0..100 {
        let [a, b] = [i, i + 1].map(|i| Vec3::X * i as f32 * 0.01);
        add([a, b, b + Vec3::Z * 0.01]);
        add([a, b + Vec3::Z * 0.01, a + Vec3::Z * 0.01]);
    }
    bare.iter().for_each(|corners| add(*corners));
    mesh.parts = vec![part(0, 0, 200), part(1, 200, bare.len())];
    let rest = RestPose { normals: vec![Vec3::Y; mesh.positions.len()], positions: mesh.positions.clone() };
    (mesh, rest)
}

/// Shortens hair of full length on the strip. Returns the x coordinate of each vertex, metres, and the resulting hair
/// length there.
fn shortened_lengths(bare: &[[Vec3; 3]], margin_m: f32) -> Vec<(f32, f32)> {
    let (mesh, rest) = strip(bare);
    let mut length = vec![1.0; mesh.positions.len()];
    BareDistances::new(&mesh, &rest, &[true, false], margin_m).shorten(&mut length);
    assert!(length[600..].iter().all(|length| *length == 1.0), "bare vertices are left as they are");
    mesh.positions.iter().map(|p| p.x).zip(length).take(600).collect()
}

/// Bare triangle to the left of x = 0, where it touches the strip along z.
const JOINED: [Vec3; 3] = [Vec3::ZERO, Vec3::new(0.0, 0.0, 0.01), Vec3::new(-0.1, 0.0, 0.0)];

#[test]
fn length_grows_smoothly_over_the_margin() {
    for (x, length) in shortened_lengths(&[JOINED], 0.2) {
        let t = (x / 0.2).min(1.0);
        let expected = t * t * (3.0 - 2.0 * t);
        assert!((length - expected).abs() < 0.01, "{length} at {x} m, expected {expected}");
        assert!(x < 0.21 || length == 1.0, "{length} at {x} m");
    }
    for (_, length) in shortened_lengths(&[], 0.2) {
        assert_eq!(length, 1.0);
    }
}

#[test]
fn margin_applies_to_disconnected_bare_parts() {
    // The bare part is separated from the strip by a gap of 2 cm, and is slightly higher.
    let apart = JOINED.map(|p| p + Vec3::new(-0.02, 0.005, 0.0));
    let at_rim = shortened_lengths(&[apart], 0.2)[0];
    assert!(at_rim.1 > 0.0 && at_rim.1 < 0.05, "{at_rim:?}");
}

#[test]
fn bare_parts_below_the_surface_do_not_shorten_hair() {
    // The teeth are 1.5 cm behind a cheek.
    let teeth = [Vec3::new(0.4, -0.015, 0.0), Vec3::new(0.4, -0.015, 0.01), Vec3::new(0.41, -0.015, 0.0)];
    let near = |all: Vec<(f32, f32)>| all.into_iter().filter(|(x, _)| (*x - 0.4).abs() < 0.012).collect::<Vec<_>>();
    assert!(shortened_lengths(&[teeth], 0.05).iter().all(|(_, length)| *length == 1.0));
    let above = teeth.map(|p| Vec3::new(p.x, 0.01, p.z));
    assert!(near(shortened_lengths(&[above], 0.05)).iter().all(|(_, length)| *length < 0.3));
}

#[test]
fn margin_distance_is_geodesic_where_the_line_is_blocked() {
    // If all bare parts are below the surface, paths start only at the seam and lead along edges from there.
    let (mesh, mut rest) = strip(&[JOINED]);
    rest.normals.fill(Vec3::X);
    let mut length = vec![1.0; mesh.positions.len()];
    BareDistances::new(&mesh, &rest, &[true, false], 0.2).shorten(&mut length);
    for (p, length) in mesh.positions.iter().zip(&length).take(600) {
        let t = (p.x / 0.2).min(1.0);
        // The tolerance is needed because paths along edges are slightly longer than straight ones.
        assert!((length - t * t * (3.0 - 2.0 * t)).abs() < 0.1, "{length} at {p}");
    }
}

#[test]
fn chosen_margin_keeps_hair_clear_of_bare_parts() {
    let (mesh, rest) = strip(&[JOINED]);
    let full = vec![1.0; mesh.positions.len()];
    let chosen_m = |length: &[f32], length_m: f32, radius_m: f32| {
        chosen_margin_m((&mesh, &rest), &[true, false], length, length_m, radius_m)
    };
    for length_m in [0.01, 0.05, 0.1] {
        let margin_m = chosen_m(&full, length_m, 100.0).unwrap_or_default();
        let mut length = full.clone();
        BareDistances::new(&mesh, &rest, &[true, false], margin_m).shorten(&mut length);
        for (p, share) in mesh.positions.iter().zip(&length).take(600).filter(|(p, _)| p.z == 0.0) {
            assert!(share * length_m <= STEEPEST * p.x * 1.001 + 1e-6, "{share} of {length_m} m at {p}");
        }
    }
    // If hair near bare parts is half as long, it needs half the margin, even if hair elsewhere is longer.
    let short: Vec<f32> = mesh.positions.iter().map(|p| if p.x < 0.5 { 0.5 } else { 1.0 }).collect();
    assert_eq!(chosen_m(&short, 0.1, 100.0), chosen_m(&full, 0.05, 100.0));
    assert_eq!(chosen_m(&full, 0.1, 1.0), Some(WIDEST));
    assert_eq!(chosen_m(&vec![0.0; full.len()], 0.1, 1.0), None, "no hair, no margin");
    let nowhere = strip(&[]);
    assert_eq!(chosen_margin_m((&nowhere.0, &nowhere.1), &[true, false], &full, 0.1, 1.0), None);
}
