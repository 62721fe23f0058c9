use super::*;
use pelage_formats::{BodyCollider, GeometryVertex, Joint, SkinVertex};

/// Makes a rod along x from -1 to 1 of radius 0.2. The left half follows joint 0, the right half joint 1.
fn rod() -> (MeshData, Pose) {
    let mut mesh = MeshData::default();
    for ring in 0..=40u16 {
        for side in 0..16u8 {
            let (x, turn) = (f32::from(ring) / 20.0 - 1.0, std::f32::consts::TAU * f32::from(side) / 16.0);
            let position = [x, 0.2 * turn.cos(), 0.2 * turn.sin()];
            mesh.geometry.push(GeometryVertex { position, ..GeometryVertex::default() });
            let joint = u16::from(x > 0.0);
            mesh.skin.push(SkinVertex { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] });
        }
    }
    // The right half's stored positions differ from its rest positions.
    let away = Mat4::from_translation(Vec3::Z * 5.0);
    mesh.geometry.iter_mut().filter(|v| v.position[0] > 0.0).for_each(|v| v.position[2] -= 5.0);
    (mesh, Pose { joints: vec![Mat4::IDENTITY, away], ..Pose::default() })
}

#[test]
fn a_rod_has_a_capsule_for_each_joint() {
    let (mesh, pose) = rod();
    let hair = vec![(0..8u8).map(|k| Vec3::new(0.0, 0.25, 0.1 * f32::from(k))).collect()];
    let fitted = fit(&mesh, &pose, &hair);
    assert_eq!(fitted.colliders.len(), 2);
    for collider in &fitted.colliders {
        assert!((collider.radius - 0.2).abs() < 0.005, "{collider:?}");
        let ends =
            [collider.from, collider.to].map(|end| pose.joints[collider.joint as usize].transform_point3(end.into()));
        assert!(ends.iter().all(|end| end.y.abs() < 0.01 && end.z.abs() < 0.01), "{ends:?}");
        assert!(ends[0].distance(ends[1]) > 0.4, "{ends:?}");
    }
    assert!(fitted.gap_m > 0.0 && fitted.gap_m < 0.2, "corners of the ends stick out: {}", fitted.gap_m);
    // Closer hair makes the capsules thinner, and hair that grows through a capsule removes it.
    let near = vec![vec![Vec3::new(0.5, 0.15, 0.0), Vec3::new(0.5, 0.15, 0.5)]];
    let thinner = fit(&mesh, &pose, &near);
    assert!(thinner.colliders.iter().any(|collider| collider.joint == 1 && collider.radius < 0.15));
    let through = vec![vec![Vec3::new(0.5, 0.01, 0.0), Vec3::new(0.5, 0.01, 0.5)]];
    assert!(fit(&mesh, &pose, &through).colliders.iter().all(|collider| collider.joint == 0));
    // A capsule far from all hair is omitted.
    let far = vec![vec![Vec3::Y * 50.0, Vec3::Y * 50.1]];
    assert_eq!(fit(&mesh, &pose, &far), FittedColliders::default());
    assert_eq!(fit(&MeshData::default(), &pose, &hair), FittedColliders::default());
}

#[test]
fn tufts_are_stiff_and_groups_move() {
    let (mut mesh, pose) = rod();
    mesh.indices = vec![0, 1, 16];
    let group = HairGroup { guide_roots: vec![(0, [0, 0])], guide_points: 2, points: 2, ..HairGroup::default() };
    let group = HairGroup { guide_offsets: vec![[0, 0, 32767]], reach_m: 0.1, ..group };
    let named =
        HairGroupParams { name: "mane".into(), swing_hz: Some(2.0), held: Some(0.5), ..HairGroupParams::default() };
    let params = StrandParams { group: vec![named], ..StrandParams::default() };
    let hair = |groups: &[HairGroup], freedom: &[&[u8]]| GuidedHair {
        groups: groups.to_vec(),
        freedom: freedom.iter().map(|of_group| of_group.to_vec()).collect(),
        warnings: Vec::new(),
    };
    let two = hair(&[group.clone(), group.clone()], &[&[51], &[]]);
    let (found, _) = group_motion(&params, &two, &mesh, None).unwrap();
    assert_eq!(found.freedom, two.freedom);
    assert!((found.guide_freedom(0, 0) - 0.2).abs() < 1e-6 && found.guide_freedom(1, 0) == 1.0);
    assert_eq!(found.groups[1], GroupMotion::STIFF);
    assert_eq!((found.groups[0].shape_hz, found.groups[0].held, found.groups[0].free), (2.0, 0.5, 0.5));
    assert_eq!(group_motion(&StrandParams::default(), &hair(&[group], &[&[]]), &mesh, None), None);
    assert!(pose.joints.len() == 2);
}

#[test]
fn recipe_capsules_replace_fitted_ones() {
    use crate::recipe::HairColliderParams;
    let node = |name| crate::stages::fixtures::node(name, None);
    let animation = Animation {
        nodes: ["hip", "head"].map(node).into(),
        joints: [0, 1].map(|node| Joint { node, inverse_bind: Mat4::IDENTITY.to_cols_array() }).into(),
        ..Animation::default()
    };
    let pose = Pose {
        joints: vec![Mat4::IDENTITY, Mat4::from_translation(Vec3::X) * Mat4::from_scale(Vec3::splat(2.0))],
        ..Pose::default()
    };
    let of = |joint: u32| BodyCollider { joint, from: [0.0; 3], to: [0.0; 3], radius: 0.1 };
    let fitted = FittedColliders { colliders: vec![of(0), of(1)], gap_m: 0.5, ..FittedColliders::default() };
    let ball = |name: &str, joint: &str| HairColliderParams {
        name: name.into(),
        joint: Some(joint.into()),
        from: Some([1.0, 2.0, 0.0]),
        radius_m: Some(0.4),
        ..HairColliderParams::default()
    };
    let found = recipe_colliders::merge(
        fitted.clone(),
        &[ball("skull", "head"), ball("lost", "tail")],
        Some(&animation),
        &pose,
    );
    let skull = BodyCollider { joint: 1, from: [0.0, 1.0, 0.0], to: [0.0, 1.0, 0.0], radius: 0.2 };
    assert_eq!(found.colliders, [skull, of(0)]);
    assert_eq!(found.warnings.len(), 1);
    assert!(
        ["\"lost\"", "\"tail\"", "\"hip\""].iter().all(|word| found.warnings[0].contains(word)),
        "{:?}",
        found.warnings
    );
    // A recipe can fill a package with capsules up to the maximum.
    let many = vec![ball("skull", "head"); 70];
    let found = recipe_colliders::merge(fitted, &many, Some(&animation), &pose);
    assert!(found.colliders.len() == HairMotion::MOST_COLLIDERS && found.warnings[0].contains("70"));
}
