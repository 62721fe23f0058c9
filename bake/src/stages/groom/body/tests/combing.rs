//! Tests of the comb direction of heads, on bodies of revolution that look along +z.

use super::*;

/// Default comb direction of a recipe.
const BACK: Vec3 = Vec3::new(0.0, -0.330_350_42, -0.943_858_3);

/// Rings (z, radius) of an animal: trunk, neck, and a head whose brow is steep above a thin snout.
fn animal() -> Vec<(f32, f32)> {
    let trunk = (0..=20).map(|i| (-2.0 + 0.1 * i as f32, 0.5 - 0.004 * (i as f32 - 10.0).powi(2) / 2.0));
    let neck = [(0.1, 0.22), (0.2, 0.2), (0.3, 0.2), (0.4, 0.22)];
    let head = [(0.5, 0.33), (0.6, 0.38), (0.7, 0.38), (0.72, 0.3), (0.74, 0.22), (0.76, 0.15), (0.9, 0.13)];
    let snout = [(1.0, 0.11), (1.1, 0.09), (1.2, 0.07), (1.25, 0.04)];
    trunk.chain(neck).chain(head).chain(snout).collect()
}

/// Returns the wanted directions of a mesh without bare parts.
fn combed(mesh: &Mesh, animation: Option<&Animation>, smoothing_m: f32) -> Option<Vec<Vec3>> {
    let rest = RestPose { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let bounds = bounds(&rest);
    let body = Body { mesh, rest: &rest, animation, furred: &[true], bounds: &bounds };
    BodyHead::find(&body).map(|head| head.comb(BACK, smoothing_m).0)
}

/// Returns the animal with a joint for its trunk, and one with the given name at the given height for its head.
fn with_joint(name: &str, joint: Vec3) -> (Mesh, Animation) {
    let mut mesh = surface_of_revolution(&animal());
    let follows = |joint| SkinVertex { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    mesh.skin = mesh.positions.iter().map(|p| follows(u16::from(p.z > 0.35))).collect();
    let mut animation = rig(&[("Spine", None), (name, Some(0))]);
    animation.nodes[1].translation = joint.into();
    (mesh, animation)
}

#[test]
fn hair_on_heads_is_combed_away_from_the_tip_of_the_nose() {
    let rings = animal();
    let (mesh, animation) = with_joint("Head", Vec3::new(0.0, 0.0, 0.4));
    let wishes = combed(&mesh, Some(&animation), 0.01).unwrap();
    let (mut worst, mut by_default) = (1.0_f32, 1.0_f32);
    for ring in 1..rings.len() - 1 {
        let (z, _) = rings[ring];
        for (p, wish) in (ring * 24..ring * 24 + 24).map(|v| (mesh.positions[v], wishes[v])) {
            let radial = Vec3::new(p.x, p.y, 0.0).normalize();
            // Direction along the surface away from the tip.
            let (front, back) = (rings[ring + 1], rings[ring - 1]);
            let away = (radial * (back.1 - front.1) + Vec3::Z * (back.0 - front.0)).normalize();
            let on_skin = |v: Vec3| v.reject_from_normalized(away.cross(radial.cross(Vec3::Z)).normalize());
            if z > 0.6 {
                worst = worst.min(on_skin(wish).normalize().dot(away));
                by_default = by_default.min(on_skin(BACK).normalize().dot(away));
            }
            assert!(z > -0.7 || wish.distance(BACK) < 0.02, "{wish} at {p}");
            assert!(wish.length() < 1.001, "{wish} at {p}");
        }
    }
    assert!(worst > 0.9, "{worst}");
    assert!(by_default < -0.9, "one direction reverses on the brow: {by_default}");
    // The head is 0.85 m long. With a weight of 138, directions are smoothed over 85 mm instead of 1 m.
    let heaviest = combed(&mesh, Some(&animation), 1.0).unwrap().into_iter().map(Vec3::length).fold(0.0, f32::max);
    assert!((80.0..160.0).contains(&heaviest), "{heaviest}");
}

/// Pulls blocks of 2 x 2 vertices of the animal out into ears: first ring, first position around it in 24ths, height.
fn with_ears(ears: &[(usize, usize, f32)]) -> Mesh {
    let mut mesh = surface_of_revolution(&animal());
    for (ring, around, height) in ears {
        for vertex in [0, 1, 24, 25].map(|step| ring * 24 + around + step) {
            let p = &mut mesh.positions[vertex];
            *p += Vec3::new(p.x, p.y, 0.0).normalize() * *height;
        }
    }
    mesh
}

/// Ears above the animal's cheeks.
const EARS: [(usize, usize, f32); 2] = [(25, 3, 0.5), (25, 8, 0.5)];

#[test]
fn heads_without_joints_are_found_by_ears_and_nose_whichever_way_they_look() {
    for quarter in 0..4 {
        let turn = glam::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * quarter as f32 + 0.2);
        let mut mesh = with_ears(&EARS);
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
        let wishes = combed(&mesh, None, 0.01).unwrap();
        let at = |ring: usize, around: usize| turn.inverse() * wishes[ring * 24 + around];
        // Brow, nape and snout: up, back along the body, and back.
        assert!(at(29, 6).y > 0.7, "{quarter}: {}", at(29, 6));
        assert!(at(32, 6).z < -0.7 && at(32, 18).z < -0.7, "{quarter}: {} {}", at(32, 6), at(32, 18));
        assert!(at(2, 6).distance(BACK) < 0.3, "{quarter}: {}", at(2, 6));
    }
}

#[test]
fn heads_without_joints_need_all_cues() {
    let bent = |mut mesh: Mesh| {
        mesh.positions.iter_mut().for_each(|p| p.x += (p.z - 0.7).max(0.0));
        mesh
    };
    let [left, right] = EARS;
    for (what, mesh) in [
        ("one ear", with_ears(&[left])),
        ("below", with_ears(&[(25, 15, 0.5), (25, 20, 0.5)])),
        ("unequal", with_ears(&[left, (25, 8, 1.2)])),
        ("one above the other", with_ears(&[left, (25, 0, 0.5)])),
        ("far from the nose", with_ears(&[(4, 3, 0.5), (4, 8, 0.5)])),
        ("bent snout", bent(with_ears(&[left, right]))),
    ] {
        assert_eq!(combed(&mesh, None, 0.01), None, "{what}");
    }
}

#[test]
fn bodies_without_a_named_snout_are_combed_as_a_whole() {
    for (what, mesh) in
        [("ball", ball()), ("animal without joints", surface_of_revolution(&animal())), ("empty", Mesh::default())]
    {
        assert_eq!(combed(&mesh, None, 0.01), None, "{what}");
    }
    let (mesh, animation) = with_joint("Bone", Vec3::ZERO);
    assert_eq!(combed(&mesh, Some(&animation), 0.01), None, "unknown names");
    // The joint of a human head is below its middle.
    let (mesh, animation) = with_joint("Head", Vec3::new(0.0, -1.0, 0.7));
    assert_eq!(combed(&mesh, Some(&animation), 0.01), None, "upright on its joint");
}
