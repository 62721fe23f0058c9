//! The crane's skeleton, its skin weights and its walk.

use glam::DVec3;

use super::{
    body::on_side,
    gait::{self, Leg, Pose, Step, cycle, wave},
    glb::{Clip, Joint, Weights},
    rig::{self, Bone, bound_to},
    trimesh::TriMesh,
};

const BODY: u8 = 0;
const TAIL: u8 = 1;
const NECK: u8 = 2;
const UPPER_NECK: u8 = 3;
const HEAD: u8 = 4;
const LEGS: [Leg; 2] =
    [Leg { upper: 5, lower: 6, cannon: None, foot: 7 }, Leg { upper: 8, lower: 9, cannon: None, foot: 10 }];

/// Weights bound only to the head: the eyes.
pub const HEAD_ONLY: Weights = bound_to(HEAD);

/// Joints of the left leg: knee (hidden by the feathers), hock, ankle and the end of the middle toe.
pub const LEG: [DVec3; 4] = [
    DVec3::new(0.068, 0.78, 0.04),
    DVec3::new(0.068, 0.425, -0.075),
    DVec3::new(0.068, 0.026, -0.015),
    DVec3::new(0.07, 0.0, 0.115),
];

/// Duration of one cycle of `Walk` (two steps), seconds.
pub const CYCLE_S: f64 = 1.2;
/// Distance covered by one cycle of `Walk`, metres. The clip itself stays in place.
pub const CYCLE_M: f64 = 0.66;

fn bones() -> Vec<Bone> {
    let v = DVec3::new;
    let mut bones = vec![
        Bone::new("body", None, v(0.0, 0.87, -0.12), v(0.0, 0.88, 0.1), 0.13),
        Bone::new("tail", Some(BODY), v(0.0, 0.88, -0.27), v(0.0, 0.66, -0.55), 0.05),
        Bone::new("neck", Some(BODY), v(0.0, 0.96, 0.24), v(0.0, 1.13, 0.36), 0.045),
        Bone::new("upper_neck", Some(NECK), v(0.0, 1.15, 0.357), v(0.0, 1.38, 0.265), 0.03),
        Bone::new("head", Some(UPPER_NECK), v(0.0, 1.44, 0.28), v(0.0, 1.465, 0.5), 0.03),
    ];
    for (names, side) in [(["shank_l", "tarsus_l", "foot_l"], 1.0), (["shank_r", "tarsus_r", "foot_r"], -1.0)] {
        let first = bones.len() as u8;
        for (k, name) in names.into_iter().enumerate() {
            let parent = if k == 0 { BODY } else { first + k as u8 - 1 };
            let (from, to) = (on_side(side, LEG[k]), on_side(side, LEG[k + 1]));
            bones.push(Bone::new(name, Some(parent), from, to, [0.03, 0.012, 0.012][k]));
        }
    }
    bones
}

/// Returns each foot's joint, and the rest position of its tip in model space.
pub fn feet() -> Vec<(usize, DVec3)> {
    gait::feet(&bones(), &LEGS)
}

/// Returns the joints in rest pose.
pub fn skeleton() -> Vec<Joint> {
    rig::skeleton(&bones())
}

/// Returns the skin weights for the vertices of `mesh`.
pub fn weights(mesh: &TriMesh) -> Vec<Weights> {
    rig::weights(mesh, &bones(), 0.012, 4)
}

/// Returns a walk that loops in place. Once a step, the head rests while the body moves on, and is then thrust
/// forwards. One cycle covers [`CYCLE_M`] metres in [`CYCLE_S`] seconds.
pub fn walk() -> Clip {
    gait::clip("Walk", &bones(), CYCLE_S, 24, &stride)
}

fn stride(phase: f64, pose: &mut Pose<'_>) {
    let beat = |start: f64| wave(2.0 * phase, start);
    pose.shift(DVec3::new(0.0, -0.028 + 0.012 * beat(0.15), 0.012 * beat(0.4)));
    pose.pitch(BODY, 2.5 * beat(0.3));
    pose.pitch(TAIL, 4.0 * beat(0.5));
    // The head moves slowly back and quickly forwards, twice a cycle.
    let thrust = cycle(&[(0.0, 1.0), (0.36, -0.2), (0.7, -1.0), (0.88, 0.6)], 2.0 * phase);
    let (lower, upper) = (9.0 * thrust, 7.0 * thrust);
    pose.pitch(NECK, lower);
    pose.pitch(UPPER_NECK, upper);
    pose.pitch(HEAD, -lower - upper - 2.5 * beat(0.3) + 3.0);

    for (leg, touch) in LEGS.into_iter().zip([0.0, 0.5]) {
        let step = Step { touch, duty: 0.58, front: 0.2, stride: CYCLE_M, lift: 0.13 };
        let since = step.phase_since_touch(phase);
        let mut foot = step.foot(phase);
        foot.pitch_deg = cycle(
            &[(0.0, -4.0), (0.06, 0.0), (0.25, 0.0), (0.42, 8.0), (0.52, 32.0), (0.6, 58.0), (0.75, 75.0), (0.9, 12.0)],
            since,
        );
        pose.solve_leg(&leg, foot);
    }
}
