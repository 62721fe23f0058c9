//! The `HAIR` section: round trip and rejected contents.

use crate::common::sample_with;
use glam::Vec3;
use pelage_formats::*;

fn package(groups: &[HairGroup]) -> Result<Vec<u8>, FormatError> {
    sample_with(|writer| writer.hair_groups(groups))
}

fn group() -> HairGroup {
    let mut group = HairGroup {
        name: "mane".into(),
        hairs: 100,
        points: 17,
        seed: 7,
        root_radius_m: 1e-4,
        tip_radius_m: 5e-5,
        root_color: [10, 20, 30],
        tip_color: [40, 50, 60],
        lock_hairs: 12,
        scalp: vec![(0, 65535)],
        ..HairGroup::default()
    };
    let root = TrianglePoint { triangle: 0, weights: [0.5, 0.25, 0.25] };
    let points = [Vec3::new(0.0, 0.01, 0.1), Vec3::new(0.02, -0.1, 0.2)];
    group.set_guides(&[0; 3].map(|_| (root, points.to_vec())));
    group
}

#[test]
fn hair_groups_survive_a_round_trip() {
    let groups = [group(), HairGroup { name: "tail".into(), hairs: 0, ..group() }];
    let bytes = package(&groups).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let opened = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(opened.hair_groups().unwrap().as_ref(), groups);
    assert_eq!((groups[0].hair_count(), groups[1].hair_count()), (100, 3));
    let points = groups[0].guide(2);
    assert_eq!((points.len(), points[0]), (3, Vec3::ZERO));
    assert!(points[2].distance(Vec3::new(0.02, -0.1, 0.2)) < 1e-5 && (groups[0].reach() - 0.2245).abs() < 1e-3);
    let root = groups[0].roots().next().unwrap();
    assert!(root.triangle == 0 && (root.weights[0] - 0.5).abs() < 1e-4);
}

#[test]
fn invalid_hair_groups_are_refused_with_the_reason() {
    type Change = fn(&mut HairGroup);
    let cases: [(Change, &str); 14] = [
        (|g| g.points = 1, "points is 1, expected 2 to 65"),
        (|g| g.points = 1 << 30, "points is 1073741824"),
        (|g| g.guide_points = 0, "guide_points is 0"),
        (|g| g.lock_hairs = 0, "lock_hairs is 0"),
        (|g| g.root_radius_m = f32::NAN, "root_radius_m is NaN"),
        (|g| g.tip_radius_m = 2e-4, "tip_radius_m is 0.0002, expected 0 to 0.0001"),
        (|g| g.clump = -0.1, "clump is -0.1"),
        (|g| g.stray = f32::INFINITY, "stray is inf"),
        (|g| g.length_variation = 1.0, "length_variation is 1"),
        (|g| g.reach_m = 0.0, "reach_m is 0"),
        (|g| g.scalp[0].0 = 1 << 20, "triangle 1048576, expected less than"),
        (|g| g.scalp.clear(), "found hairs but no triangle"),
        (|g| g.guide_roots[1].1 = [40000, 40000], "guide 1: weights sum to more than 1"),
        (|g| g.guide_offsets.truncate(5), "guide_offsets has 5 entries, expected 6"),
    ];
    for (change, expected) in cases {
        let mut group = group();
        change(&mut group);
        let bytes = package(&[group]);
        let found = bytes.unwrap_err().to_string();
        assert!(found.contains(expected) && found.contains("group 0 \"mane\""), "{found}, expected {expected}");
    }
    assert!(package(&[]).unwrap_err().to_string().contains("0 groups, expected 1 to 256"));
    let many = HairGroup { hairs: u32::MAX, ..group() };
    let error = package(&[many.clone(), many]).unwrap_err().to_string();
    assert!(error.contains("hair count"), "{error}");
}
