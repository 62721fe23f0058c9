use super::*;

/// Square of 1 m in the plane y = 0 with normal +y.
const POSITIONS: [Vec3; 4] = [Vec3::ZERO, Vec3::Z, Vec3::new(1.0, 0.0, 1.0), Vec3::X];
const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

fn corners(triangle: u32) -> [Vec3; 3] {
    TRIANGLES[triangle as usize].map(|v| POSITIONS[v as usize])
}

/// Hairs of 0.5 m that stand up and bend towards +x.
fn group(hairs: u32) -> HairGroup {
    let mut group = HairGroup {
        hairs,
        points: 9,
        root_radius_m: 1e-3,
        lock_hairs: 16,
        scalp: vec![(0, 1), (1, 3)],
        ..HairGroup::default()
    };
    let guides: Vec<(TrianglePoint, Vec<Vec3>)> = (0..8)
        .map(|i| {
            let root = TrianglePoint { triangle: i % 2, weights: [0.2 + 0.05 * i as f32, 0.3, 0.5 - 0.05 * i as f32] };
            let frame = triangle_frame(corners(i % 2)).transpose();
            let points = [Vec3::new(0.05, 0.25, 0.0), Vec3::new(0.2, 0.45, 0.0)];
            (root, points.map(|p| frame * p).to_vec())
        })
        .collect();
    group.set_guides(&guides);
    group
}

#[test]
fn hairs_follow_the_density_of_the_scalp() {
    let planted = GrownGroup::new(&group(4000), &POSITIONS, &TRIANGLES, u32::MAX);
    assert_eq!(planted.hairs.len(), 4000);
    let posed = planted.posed_guides(corners);
    for hairs in [&planted.hairs[..400], &planted.hairs] {
        // The second triangle must have three times as many hairs as the first, both among the first 400 and among all.
        let second = hairs.iter().filter(|hair| hair.root.triangle == 1).count();
        assert!((second as f32 / hairs.len() as f32 - 0.75).abs() < 0.01, "{second} of {}", hairs.len());
        // Hairs are distributed evenly over the triangle: equally many are near each corner.
        for corner in 0..3 {
            let near = hairs.iter().filter(|h| h.root.triangle == 1 && h.root.weights[corner] > 0.5).count();
            assert!((near as f32 / second as f32 - 0.25).abs() < 0.04, "{near} of {second} near corner {corner}");
        }
    }
    for hair in &planted.hairs {
        let points: Vec<Vec3> = hair.points(corners(hair.root.triangle), &posed).collect();
        assert!(points[0].y.abs() < 1e-6 && (points[8] - points[0]).distance(Vec3::new(0.2, 0.45, 0.0)) < 1e-3);
    }
    // With a smaller maximum, the hairs are a prefix of all hairs.
    let few = GrownGroup::new(&group(4000), &POSITIONS, &TRIANGLES, 100);
    assert_eq!(few.hairs, planted.hairs[..100]);
}

#[test]
fn hair_moves_with_its_triangle() {
    let planted = GrownGroup::new(&group(50), &POSITIONS, &TRIANGLES, u32::MAX);
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.7);
    let moved = |triangle: u32| corners(triangle).map(|c| turn * c + Vec3::new(3.0, 1.0, 2.0));
    let (rest, posed) = (planted.posed_guides(corners), planted.posed_guides(moved));
    for hair in &planted.hairs {
        let t = hair.root.triangle;
        for (p, q) in hair.points(corners(t), &rest).zip(hair.points(moved(t), &posed)) {
            assert!(q.distance(turn * p + Vec3::new(3.0, 1.0, 2.0)) < 1e-5);
        }
    }
}

#[test]
fn locks_clump_and_stray_hairs_deviate() {
    let spread = |group: &HairGroup| {
        let planted = GrownGroup::new(group, &POSITIONS, &TRIANGLES, u32::MAX);
        let posed = planted.posed_guides(corners);
        let tips: Vec<Vec3> =
            planted.hairs.iter().map(|h| h.points(corners(h.root.triangle), &posed).last().unwrap()).collect();
        // Mean distance of each tip to its nearest neighbour.
        let nearest = PointGrid::new(tips.clone());
        tips.iter().map(|tip| nearest.nearest::<2>(*tip)[1].0.sqrt()).sum::<f32>() / tips.len() as f32
    };
    let plain = spread(&group(1000));
    assert!(spread(&HairGroup { clump: 0.9, ..group(1000) }) < 0.4 * plain);
    let planted = GrownGroup::new(&HairGroup { stray: 0.3, ..group(1000) }, &POSITIONS, &TRIANGLES, u32::MAX);
    let far = planted.hairs.iter().filter(|hair| hair.tip_offset.length() > 0.04).count();
    assert!((40..120).contains(&far), "{far} of 1000 stray");
}

#[test]
fn length_and_colour_variation_stay_within_their_ranges() {
    let group = HairGroup {
        length_variation: 0.4,
        color_variation: 0.5,
        root_color: [128; 3],
        tip_color: [128; 3],
        ..group(500)
    };
    let planted = GrownGroup::new(&group, &POSITIONS, &TRIANGLES, u32::MAX);
    let lengths = || planted.hairs.iter().map(|hair| hair.length);
    let (least, most) = lengths().fold((1.0f32, 0.0f32), |(l, m), x| (l.min(x), m.max(x)));
    assert!((0.6..0.61).contains(&least) && (0.99..=1.0).contains(&most), "{least} to {most}");
    let middle = srgb_to_linear(128);
    let bright: Vec<f32> = (0..HAIR_COLORS).map(|c| hair_color(&group, c, 0.5).x / middle).collect();
    assert!(bright.iter().all(|b| (0.5..=1.5).contains(b)));
    assert!((bright.iter().sum::<f32>() / HAIR_COLORS as f32 - 1.0).abs() < 1e-3, "{bright:?}");
    assert!(hair_radius(&group, 0.0) == 1e-3 && hair_radius(&group, 0.5) == 1e-3 && hair_radius(&group, 1.0) == 0.0);
}

/// If a group's guides are its hairs, it has no others.
#[test]
fn groups_without_hairs_use_their_guides_as_hairs() {
    let planted = GrownGroup::new(&group(0), &POSITIONS, &TRIANGLES, u32::MAX);
    assert_eq!(planted.hairs.len(), 8);
    let posed = planted.posed_guides(corners);
    for (hair, root) in planted.hairs.iter().zip(group(0).roots()) {
        assert_eq!(hair.root, root);
        let tip = hair.points(corners(root.triangle), &posed).last().unwrap();
        assert!((tip - root.position(corners(root.triangle))).distance(Vec3::new(0.2, 0.45, 0.0)) < 1e-3);
    }
}
