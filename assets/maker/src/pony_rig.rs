//! The pony's skeleton, its skin weights, its walk and its gallop.

use glam::DVec3;

use super::{
    body::on_side,
    gait::{self, Leg, Pose, wave},
    glb::{Clip, Joint, Weights},
    hooves::{self, GALLOP, Gait, Pair, WALK, add_legs, leg},
    rig::{self, Bone, bound_to},
    trimesh::TriMesh,
};

const HIPS: u8 = 0;
const SPINE: u8 = 1;
const CHEST: u8 = 2;
const NECK: u8 = 3;
const NECK_UPPER: u8 = 4;
const HEAD: u8 = 5;
const EARS: [u8; 2] = [6, 7];
const TAILS: [u8; 2] = [8, 9];
const FORELEGS: [Leg; 2] = [leg(10), leg(14)];
const HIND_LEGS: [Leg; 2] = [leg(18), leg(22)];

/// Weights bound only to the head: eyes.
pub const HEAD_ONLY: Weights = bound_to(HEAD);

/// Joints of the left foreleg: shoulder, elbow, knee, fetlock and the front end of the hoof.
pub const FORELEG: [DVec3; 5] = [
    DVec3::new(0.122, 0.69, 0.4),
    DVec3::new(0.12, 0.575, 0.27),
    DVec3::new(0.106, 0.315, 0.298),
    DVec3::new(0.104, 0.132, 0.292),
    DVec3::new(0.104, 0.0, 0.395),
];

/// Joints of the left hind leg: hip, stifle, hock, fetlock and the front end of the hoof.
pub const HIND_LEG: [DVec3; 5] = [
    DVec3::new(0.095, 0.75, -0.33),
    DVec3::new(0.118, 0.59, -0.22),
    DVec3::new(0.1, 0.385, -0.5),
    DVec3::new(0.1, 0.132, -0.485),
    DVec3::new(0.1, 0.0, -0.385),
];

/// Root, bend and end of the dock, with the radius at each, metres.
pub const TAIL: [(DVec3, f64); 3] = [
    (DVec3::new(0.0, 0.905, -0.485), 0.033),
    (DVec3::new(0.0, 0.868, -0.57), 0.025),
    (DVec3::new(0.0, 0.725, -0.608), 0.013),
];

/// Root and tip of the left ear.
pub const EAR: [DVec3; 2] = [DVec3::new(0.05, 1.242, 0.632), DVec3::new(0.078, 1.335, 0.652)];

/// Duration of one cycle of `Walk`, seconds.
pub const CYCLE_S: f64 = 1.1;
/// Distance covered by one cycle of `Walk`, metres. The clip itself stays in place.
pub const CYCLE_M: f64 = 0.9;
/// Duration of one cycle of `Gallop`, seconds.
pub const GALLOP_S: f64 = 0.48;
/// Distance covered by one cycle of `Gallop`, metres. The clip itself stays in place.
pub const GALLOP_M: f64 = 2.5;

fn bones() -> Vec<Bone> {
    let v = DVec3::new;
    let mut bones = vec![
        Bone::new("hips", None, v(0.0, 0.82, -0.3), v(0.0, 0.78, -0.42), 0.16),
        Bone::new("spine", Some(HIPS), v(0.0, 0.82, -0.16), v(0.0, 0.78, 0.04), 0.2),
        Bone::new("chest", Some(SPINE), v(0.0, 0.82, 0.1), v(0.0, 0.76, 0.3), 0.17),
        Bone::new("neck", Some(CHEST), v(0.0, 0.86, 0.3), v(0.0, 0.98, 0.42), 0.1),
        Bone::new("neck_upper", Some(NECK), v(0.0, 0.99, 0.43), v(0.0, 1.12, 0.53), 0.08),
        Bone::new("head", Some(NECK_UPPER), v(0.0, 1.15, 0.57), v(0.0, 0.94, 0.83), 0.06),
    ];
    for (name, side) in [("ear_l", 1.0), ("ear_r", -1.0)] {
        let [root, tip] = EAR.map(|p| on_side(side, p));
        bones.push(Bone::new(name, Some(HEAD), root + (tip - root) * 0.15, tip, 0.012));
    }
    for (k, name) in ["tail", "tail_tip"].into_iter().enumerate() {
        let parent = if k == 0 { HIPS } else { TAILS[0] };
        bones.push(Bone::new(name, Some(parent), TAIL[k].0, TAIL[k + 1].0, 0.015));
    }
    let fore = Pair { parent: CHEST, joints: &FORELEG, thickness: [0.07, 0.05, 0.03, 0.03] };
    let hind = Pair { parent: HIPS, joints: &HIND_LEG, thickness: [0.09, 0.06, 0.03, 0.03] };
    add_legs(&mut bones, &fore, &hind);
    bones
}

/// Returns each foot's joint, and the rest position of its tip in model space.
pub fn feet() -> Vec<(usize, DVec3)> {
    gait::feet(&bones(), FORELEGS.iter().chain(&HIND_LEGS))
}

/// Returns the joints in rest pose.
pub fn skeleton() -> Vec<Joint> {
    rig::skeleton(&bones())
}

/// Returns the skin weights for the vertices of `mesh`.
pub fn weights(mesh: &TriMesh) -> Vec<Weights> {
    rig::weights(mesh, &bones(), 0.012, 6)
}

/// Returns a walk of four beats that loops in place: left hind, left fore, right hind, right fore. One cycle covers
/// [`CYCLE_M`] metres in [`CYCLE_S`] seconds.
pub fn walk() -> Clip {
    gait::clip("Walk", &bones(), CYCLE_S, 32, &stride)
}

fn stride(phase: f64, pose: &mut Pose<'_>) {
    // Twice a cycle, the weight sinks onto a pair of legs, and neck and head nod with it.
    let beat = |start: f64| wave(2.0 * phase, start);
    pose.shift(DVec3::new(0.0, -0.024 + 0.009 * beat(0.1), 0.006 * beat(0.3)));
    pose.pitch(HIPS, 0.7 * beat(0.2));
    pose.pitch(CHEST, -0.7 * beat(0.3));
    pose.pitch(NECK, 3.0 + 2.6 * beat(0.35));
    pose.pitch(NECK_UPPER, 1.0 + 1.6 * beat(0.42));
    pose.pitch(HEAD, -3.0 - 2.4 * beat(0.5));
    pose.turn(NECK, DVec3::Y, 2.0 * wave(phase, 0.1));
    for (ear, side) in EARS.into_iter().zip([1.0, -1.0]) {
        pose.turn(ear, DVec3::Z, side * (1.0 + 2.5 * beat(0.6)));
    }
    for (k, joint) in TAILS.into_iter().enumerate() {
        pose.turn(joint, DVec3::Z, [5.0, 7.0][k] * wave(phase, 0.1 + 0.09 * k as f64));
    }

    let (tilt, bend) = ([48.0, 50.0], [55.0, -30.0]);
    let walk = Gait { touches: WALK, duty: 0.62, stride: CYCLE_M, front: 0.29, lift: 0.07, tilt, bend };
    hooves::apply_gait(phase, pose, [FORELEGS, HIND_LEGS], &walk);
}

/// Returns a gallop that loops in place. One cycle covers [`GALLOP_M`] metres in [`GALLOP_S`] seconds.
pub fn gallop() -> Clip {
    gait::clip("Gallop", &bones(), GALLOP_S, 32, &bound)
}

fn bound(phase: f64, pose: &mut Pose<'_>) {
    // Once a cycle, the animal is in the air with its legs gathered, and is highest then. Its nose is up while the hind
    // legs push, and down while the forelegs carry it.
    pose.shift(DVec3::new(0.0, -0.055 + 0.04 * wave(phase, 0.62), 0.0));
    pose.pitch(HIPS, 5.0 * wave(phase, 0.3));
    pose.pitch(SPINE, -4.0 * wave(phase, 0.62));
    pose.pitch(CHEST, -2.0 * wave(phase, 0.4));
    pose.pitch(NECK, 10.0 + 6.0 * wave(phase, 0.9));
    pose.pitch(NECK_UPPER, 6.0 + 3.0 * wave(phase, 0.95));
    pose.pitch(HEAD, -12.0 - 6.0 * wave(phase, 0.9));
    for (ear, side) in EARS.into_iter().zip([1.0, -1.0]) {
        pose.pitch(ear, -24.0);
        pose.turn(ear, DVec3::Z, side * (2.0 + 3.0 * wave(phase, 0.3)));
    }
    // Raises the dock.
    for (k, joint) in TAILS.into_iter().enumerate() {
        pose.pitch(joint, [34.0, 14.0][k] + 5.0 * wave(phase, 0.2 + 0.1 * k as f64));
    }
    let (tilt, bend) = ([55.0, 70.0], [80.0, -45.0]);
    let gallop = Gait { touches: GALLOP, duty: 0.26, stride: GALLOP_M, front: 0.33, lift: 0.2, tilt, bend };
    hooves::apply_gait(phase, pose, [FORELEGS, HIND_LEGS], &gallop);
}
