//! Tests of posing: exact values of the three interpolations, and the row "animation" of the stability table.

use pelage_formats::*;
use std::f32::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

const IDENTITY: [f32; 16] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

fn node(parent: Option<u32>) -> Node {
    Node { name: String::new(), parent, translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
}

fn one_channel(property: Property, interpolation: Interpolation, times: &[f32], values: &[f32]) -> Animation {
    let channel = Channel { node: 0, property, interpolation, times: times.to_vec(), values: values.to_vec() };
    Animation {
        nodes: vec![node(None)],
        joints: vec![Joint { node: 0, inverse_bind: IDENTITY }],
        clips: vec![Clip { name: "c".into(), duration_s: *times.last().unwrap_or(&0.0), channels: vec![channel] }],
        ..Animation::default()
    }
}

fn joint(animation: &Animation, clip: Option<usize>, time_s: f32) -> glam::Mat4 {
    let mut pose = Pose::default();
    pose.sample(animation, clip, time_s);
    assert!(pose.nodes.iter().chain(&pose.joints).all(glam::Mat4::is_finite), "at {time_s} s: {pose:?}");
    pose.joints[0]
}

fn translation_x(animation: &Animation, time_s: f32) -> f32 {
    joint(animation, Some(0), time_s).w_axis.x
}

#[test]
fn step_and_linear_channels_hold_outside_their_keys() {
    let keys = (&[1.0, 2.0, 4.0][..], &[10.0, 0.0, 0.0, 20.0, 0.0, 0.0, -20.0, 0.0, 0.0][..]);
    let step = one_channel(Property::Translation, Interpolation::Step, keys.0, keys.1);
    let linear = one_channel(Property::Translation, Interpolation::Linear, keys.0, keys.1);
    let table = [
        (f32::NEG_INFINITY, 10.0, 10.0),
        (-1.0, 10.0, 10.0),
        (1.0, 10.0, 10.0),
        (1.25, 10.0, 12.5),
        (2.0, 20.0, 20.0),
        (3.0, 20.0, 0.0),
        (3.999, 20.0, -19.98),
        (4.0, -20.0, -20.0),
        (f32::INFINITY, -20.0, -20.0),
        (f32::NAN, 10.0, 10.0),
    ];
    for (time, expected_step, expected_linear) in table {
        assert_eq!(translation_x(&step, time), expected_step, "step at {time}");
        let found = translation_x(&linear, time);
        assert!((found - expected_linear).abs() < 1e-4, "linear at {time}: {found}, expected {expected_linear}");
    }
}

/// A Hermite curve through a cubic's values and slopes is the cubic itself.
#[test]
fn cubic_keys_reproduce_a_cubic() {
    let f = |t: f64| 0.5 * t * t * t - 2.0 * t * t + t + 3.0;
    let slope = |t: f64| 1.5 * t * t - 4.0 * t + 1.0;
    let times = [0.0, 0.5, 3.0];
    let mut values = Vec::new();
    for t in times.map(f64::from) {
        for number in [slope(t), f(t), slope(t)] {
            values.extend_from_slice(&[number as f32, 0.0, 0.0]);
        }
    }
    let animation = one_channel(Property::Translation, Interpolation::Cubic, &times, &values);
    for i in 0..=300 {
        let t = f64::from(i) * 0.01;
        let found = f64::from(translation_x(&animation, t as f32));
        assert!((found - f(t)).abs() < 2e-5, "at {t}: {found}, expected {}", f(t));
    }
}

/// Linear rotation follows the shorter arc at constant speed, even if the second key is stored as −q.
#[test]
fn linear_rotation_keys_are_interpolated_spherically() {
    for sign in [1.0, -1.0] {
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * FRAC_1_SQRT_2, sign * FRAC_1_SQRT_2];
        let animation = one_channel(Property::Rotation, Interpolation::Linear, &[0.0, 2.0], &values);
        for i in 0..=20 {
            let t = i as f32 * 0.1;
            let angle = t / 2.0 * FRAC_PI_2;
            let x_axis = joint(&animation, Some(0), t).x_axis;
            // glam's slerp uses an approximate arc cosine: 1e-4 rad is far below a visible difference.
            assert!((x_axis.x - angle.cos()).abs() < 1e-4 && (x_axis.y - angle.sin()).abs() < 1e-4, "{t}: {x_axis}");
        }
    }
}

#[test]
fn zero_quaternions_are_the_identity() {
    let zero = [0.0; 4];
    for (first, second) in [(zero, zero), (zero, [0.0, 0.0, 1.0, 0.0]), ([0.0, 0.0, 1.0, 0.0], zero)] {
        for interpolation in [Interpolation::Step, Interpolation::Linear] {
            let animation = one_channel(Property::Rotation, interpolation, &[0.0, 1.0], &[first, second].concat());
            for t in [0.0, 0.25, 0.5, 1.0] {
                assert!((joint(&animation, Some(0), t).determinant() - 1.0).abs() < 1e-5);
            }
        }
    }
    // q and −q with zero tangents: the curve passes through the origin at half time.
    let key = |w: f32| [[0.0; 4], [0.0, 0.0, 0.0, w], [0.0; 4]].concat();
    let values = [key(1.0), key(-1.0)].concat();
    let animation = one_channel(Property::Rotation, Interpolation::Cubic, &[0.0, 1.0], &values);
    assert_eq!(joint(&animation, Some(0), 0.5), glam::Mat4::IDENTITY);
    // Check the rest pose with quaternions of length 0, and of lengths whose squares are out of range for f32.
    for size in [0.0, 1e-30, 1e-25, 1e20, 3e38] {
        let mut animation = animation.clone();
        animation.nodes[0].rotation = [0.0, 0.0, size, 0.0];
        let expected = if size == 0.0 { 1.0 } else { -1.0 };
        assert!((joint(&animation, None, 0.0).x_axis.x - expected).abs() < 1e-6, "quaternion of length {size}");
    }
}

#[test]
fn mirrored_and_zero_scale_stay_exact() {
    let mut animation = Animation {
        nodes: vec![node(None), node(Some(0))],
        joints: vec![Joint { node: 1, inverse_bind: IDENTITY }],
        ..Animation::default()
    };
    animation.nodes[0].scale = [-2.0, 1.0, 1.0];
    animation.nodes[0].translation = [1.0, 0.0, 0.0];
    animation.nodes[1].translation = [3.0, 4.0, 0.0];
    let matrix = joint(&animation, None, 0.0);
    assert_eq!(matrix.w_axis.truncate().to_array(), [-5.0, 4.0, 0.0]);
    assert_eq!(matrix.determinant(), -2.0);
    animation.nodes[0].scale = [0.0; 3];
    let matrix = joint(&animation, None, 0.0);
    assert_eq!(matrix.w_axis.truncate().to_array(), [1.0, 0.0, 0.0]);
    assert_eq!(matrix.determinant(), 0.0);
}

/// These animations, which no reader would accept, and numbers at the limits of f32 must not cause a panic or NaN.
#[test]
fn nothing_panics_or_gives_nan() {
    let huge = f32::MAX;
    for (times, values) in [
        (vec![], vec![]),
        (vec![0.0], vec![]),
        (vec![0.0, 1.0], vec![1.0; 5]),
        (vec![0.0, 1.0], vec![1.0; 1000]),
        (vec![-huge, huge], vec![huge; 24]),
        (vec![-huge, huge], vec![-huge, huge, -huge, huge, -huge, huge]),
        (vec![-huge, huge], [vec![-huge; 12], vec![huge; 12]].concat()),
        (vec![0.0, f32::MIN_POSITIVE], vec![huge; 18]),
        (vec![f32::NAN, 1.0], vec![f32::NAN; 6]),
        (vec![1.0, 0.0], vec![f32::INFINITY; 8]),
    ] {
        for property in [Property::Translation, Property::Rotation, Property::Scale] {
            for interpolation in [Interpolation::Step, Interpolation::Linear, Interpolation::Cubic] {
                let mut animation = one_channel(property, interpolation, &times, &values);
                animation.nodes.push(node(Some(0)));
                animation.nodes[1].scale = [huge; 3];
                animation.nodes.push(node(Some(99)));
                let stray = Channel { node: 99, ..animation.clips[0].channels[0].clone() };
                animation.clips[0].channels.push(stray);
                animation.joints.push(Joint { node: 77, inverse_bind: [huge; 16] });
                for time in [-huge, -1.0, 0.0, 0.5, 1.0, huge, f32::NAN, f32::INFINITY] {
                    joint(&animation, Some(0), time);
                }
            }
        }
    }
    joint(&one_channel(Property::Scale, Interpolation::Step, &[0.0], &[1.0; 3]), Some(12), 0.0);
}

/// Halfway between two poses, a node has moved half the distance and turned half the angle. An arm attached to it keeps
/// its length.
#[test]
fn blended_clips_rotate_nodes_about_their_parents() {
    let quarter = [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2];
    let turn = Channel {
        node: 0,
        property: Property::Rotation,
        interpolation: Interpolation::Step,
        times: vec![0.0],
        values: quarter.to_vec(),
    };
    let go = Channel {
        node: 0,
        property: Property::Translation,
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        values: vec![0.0, 0.0, 0.0, 4.0, 0.0, 0.0],
    };
    let clip = |channel: Channel| Clip { name: "c".into(), duration_s: 1.0, channels: vec![channel] };
    let hand = Node { translation: [1.0, 0.0, 0.0], ..node(Some(0)) };
    let animation = Animation {
        nodes: vec![node(None), hand],
        joints: vec![Joint { node: 1, inverse_bind: IDENTITY }],
        clips: vec![clip(turn), clip(go)],
        ..Animation::default()
    };
    let layer = |clip, time_s, share| ClipLayer { clip, time_s, share };
    let hand = |layers: &[ClipLayer]| {
        let mut pose = Pose::default();
        pose.blend(&animation, layers);
        assert!(pose.nodes.iter().chain(&pose.joints).all(glam::Mat4::is_finite), "{layers:?}");
        pose.joints[0].w_axis.truncate()
    };
    let near = |found: glam::Vec3, expected: [f32; 3]| assert!(found.distance(expected.into()) < 1e-5, "{found}");
    let (half, turned, gone) = (FRAC_1_SQRT_2, layer(Some(0), 0.0, 1.0), layer(Some(1), 1.0, 1.0));
    near(hand(&[]), [1.0, 0.0, 0.0]);
    near(hand(&[layer(Some(0), 0.0, 0.5)]), [half, half, 0.0]);
    near(hand(&[turned, layer(None, 0.0, 0.5)]), [half, half, 0.0]);
    near(hand(&[layer(Some(1), 1.0, 0.25)]), [2.0, 0.0, 0.0]);
    near(hand(&[turned, ClipLayer { share: 0.5, ..gone }]), [2.0 + half, half, 0.0]);
    // A third layer is blended in while the second still has share 0.5.
    near(hand(&[turned, ClipLayer { share: 0.5, ..gone }, layer(None, 0.0, 0.5)]), {
        let (eighth, y) = (std::f32::consts::FRAC_PI_8.cos(), std::f32::consts::FRAC_PI_8.sin());
        [1.0 + eighth, y, 0.0]
    });
    for (share, expected) in [(-1.0, [1.0, 0.0, 0.0]), (f32::NAN, [1.0, 0.0, 0.0]), (7.0, [0.0, 1.0, 0.0])] {
        near(hand(&[ClipLayer { share, ..turned }]), expected);
    }
    // A layer with share 1 gives exactly the pose of its clip, to the bit.
    let mut pose = Pose::default();
    pose.sample(&animation, Some(1), 0.3);
    assert_eq!(hand(&[turned, layer(Some(1), 0.3, 1.0)]), pose.joints[0].w_axis.truncate());
    // A clip that does not exist gives the pose at rest.
    near(hand(&[turned, layer(Some(9), 0.0, 1.0)]), [1.0, 0.0, 0.0]);
}
