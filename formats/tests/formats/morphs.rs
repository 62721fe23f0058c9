//! Morph targets: round trip, weights sampled from clips, and displaced vertices.

use crate::common::{Refusal, assert_refused, morphed_package as packed, sample_animation, sample_morphs as sample};
use pelage_formats::meaning::{morphed, posed_vertices};
use pelage_formats::*;

fn delta(target: u32, position: [f32; 3], normal: [f32; 3]) -> MorphDelta {
    MorphDelta { target, position, normal, tangent: [0.0, 0.25, 0.0] }
}

#[test]
fn morph_targets_survive_a_round_trip_and_join_the_animation() {
    let bytes = packed(&sample()).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    assert_eq!(*package.morphs().unwrap().unwrap(), sample());
    let animation = package.animation().unwrap().unwrap();
    assert_eq!(animation.morphs, sample().motion);
    assert_eq!(Animation { morphs: MorphMotion::default(), ..(*animation).clone() }, sample_animation());
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    assert_eq!(sample().of_vertex(0).len(), 2);
    assert!(sample().of_vertex(1).is_empty() && sample().of_vertex(4).is_empty() && sample().of_vertex(5).is_empty());
    let small = Limits { animation_bytes: 16, ..Limits::default() };
    assert!(Package::open(&bytes, &small).unwrap().morphs().is_err());
}

#[test]
fn invalid_morphs_are_refused_with_the_reason() {
    let cases: [Refusal<Morphs>; 12] = [
        (|m| m.motion.targets.clear(), "0 targets, expected 1 to 4096"),
        (|m| m.motion.targets[1].node = 2, "targets[1].node is 2, expected less than 2"),
        (|m| m.motion.targets[0].weight = f32::NAN, "targets[0].weight is NaN"),
        (|m| m.motion.channels[1].clip = 1, "channels[1].clip is 1, expected less than 1"),
        (|m| m.motion.channels[1].target = 2, "channels[1] animates 1 targets from 2 on"),
        (|m| m.motion.channels[0].count = 0, "channels[0] animates 0 targets"),
        (|m| m.motion.channels[0].count = 1, "channels[0] has 2 keys and 4 numbers, expected at least one key and 2"),
        (|m| m.motion.channels[0].times[1] = 1.0, "channels[0].times[1] is 1, expected more than"),
        (|m| m.first.truncate(5), "first has 5 entries, expected one for each of 5 vertices, plus one"),
        (|m| m.first[1] = 4, "expected it to ascend from 0 to 3"),
        (|m| m.deltas[2].target = 2, "deltas[2].target is 2, expected less than 2"),
        (|m| m.deltas[1].tangent[2] = f32::INFINITY, "deltas[1] is"),
    ];
    assert_refused(Tag::MORPHS, sample, &cases, packed);
    let rigid = PackageWriter::new(Manifest { parts: Vec::new(), ..Manifest::default() }).morphs(&sample());
    assert!(rigid.finish().is_err_and(|error| error.to_string().contains("without a skeleton")));
}

#[test]
fn weights_follow_their_curves() {
    let animation = Animation { morphs: sample().motion, ..sample_animation() };
    let mut pose = Pose::default();
    let mut at = |clip, time_s| {
        pose.sample(&animation, clip, time_s);
        pose.shifts.clone()
    };
    assert_eq!(at(None, 0.0), [0.0, 0.0]);
    // If several curves drive a target, the last one applies.
    assert_eq!(at(Some(0), 0.0), [0.0, 0.25]);
    assert_eq!(at(Some(0), 1.25), [0.25, 0.25]);
    assert_eq!(at(Some(0), 9.0), [1.0, 0.75]);
    assert_eq!(at(Some(7), 1.5), [0.0, 0.0], "no such clip");
    let layer = |clip, share| ClipLayer { clip, time_s: 9.0, share };
    pose.blend(&animation, &[layer(Some(0), 1.0), layer(None, 0.25)]);
    assert_eq!(pose.shifts, [0.75, 0.5625]);

    // A Hermite curve, given by the values and slopes at two keys, drives two targets at once.
    let mut motion = sample().motion;
    let values = vec![9.0, 9.0, 0.0, 1.0, 1.0, 0.0, /* the next key */ 1.0, 0.0, 1.0, 1.0, 9.0, 9.0];
    motion.channels = vec![MorphChannel { interpolation: Interpolation::Cubic, values, ..motion.channels[0].clone() }];
    let animation = Animation { morphs: motion, ..sample_animation() };
    for t in [0.0f32, 0.25, 0.5, 0.875] {
        pose.sample(&animation, Some(0), 1.0 + t);
        assert!((pose.shifts[0] + 0.5 - t).abs() < 1e-6, "a straight line: {t} {:?}", pose.shifts);
        assert!((pose.shifts[1] - 1.0).abs() < 1e-6, "a level: {t} {:?}", pose.shifts);
    }
}

#[test]
fn morph_targets_apply_before_joints() {
    let bytes = packed(&sample()).unwrap();
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let (mesh, morphs) = (package.mesh().unwrap().unwrap(), package.morphs().unwrap().unwrap());
    let stored: Vec<GeometryVertex> = mesh.geometry().collect();
    let moved = morphed(&stored[0], morphs.of_vertex(0), &[0.5, 1.0]);
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}, expected {expected:?}");
    };
    let [x, y, z] = stored[0].position;
    near(moved.position, [x + 0.5, y + 2.0, z]);
    let length: f32 = moved.normal.iter().map(|n| n * n).sum();
    assert!((length - 1.0).abs() < 1e-6 && moved.normal[0] > 0.5, "{:?}", moved.normal);
    let [tx, ty, tz, w] = stored[0].tangent;
    assert_eq!(moved.tangent, [tx, ty + 0.375, tz, w]);
    assert_eq!((moved.fur_height, moved.lean), (stored[0].fur_height, stored[0].lean));
    // At rest, or with too few weights, vertices are unchanged, bit for bit.
    assert_eq!(morphed(&stored[0], morphs.of_vertex(0), &[0.0, 0.0]), stored[0]);
    assert_eq!(morphed(&stored[0], morphs.of_vertex(0), &[]), stored[0]);
    // If two targets cancel the whole normal, the old normal is kept.
    let away = MorphDelta { normal: stored[0].normal.map(|n| -n), ..delta(0, [0.0; 3], [0.0; 3]) };
    assert_eq!(morphed(&stored[0], &[away], &[1.0]).normal, stored[0].normal);

    let mut pose = Pose::default();
    pose.sample(&package.animation().unwrap().unwrap(), Some(0), 9.0);
    let posed: Vec<_> = posed_vertices(&mesh, Some(&morphs), &pose).map(|v| v.position).collect();
    let plain: Vec<_> = posed_vertices(&mesh, None, &pose).map(|v| v.position).collect();
    assert_eq!(posed[1], plain[1]);
    assert_ne!(posed[0], plain[0]);
}
