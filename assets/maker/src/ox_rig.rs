//! The ox's skeleton, its skin weights and its walk.

use glam::DVec3;

use super::{
    body::on_side,
    gait::{self, Leg, Pose, wave},
    glb::{Clip, Joint, Weights},
    hooves::{self, Gait, Pair, WALK, add_legs, leg},
    rig::{self, Bone, bound_to},
    trimesh::TriMesh,
};

const HIPS: u8 = 0;
const SPINE: u8 = 1;
const CHEST: u8 = 2;
const NECK: u8 = 3;
const HEAD: u8 = 4;
const EARS: [u8; 2] = [5, 6];
const TAILS: [u8; 3] = [7, 8, 9];
const FORELEGS: [Leg; 2] = [leg(10), leg(14)];
const HIND_LEGS: [Leg; 2] = [leg(18), leg(22)];

/// Weights bound only to the head: eyes and horns.
pub const HEAD_ONLY: Weights = bound_to(HEAD);

/// Joints of the left foreleg: shoulder, elbow, knee, fetlock and the front end of the hoof.
pub const FORELEG: [DVec3; 5] = [
    DVec3::new(0.23, 1.02, 0.56),
    DVec3::new(0.235, 0.72, 0.43),
    DVec3::new(0.215, 0.42, 0.48),
    DVec3::new(0.205, 0.135, 0.465),
    DVec3::new(0.205, 0.0, 0.57),
];

/// Joints of the left hind leg: hip, stifle, hock, fetlock and the front end of the hoof.
pub const HIND_LEG: [DVec3; 5] = [
    DVec3::new(0.17, 1.02, -0.6),
    DVec3::new(0.235, 0.72, -0.42),
    DVec3::new(0.21, 0.47, -0.74),
    DVec3::new(0.205, 0.135, -0.66),
    DVec3::new(0.205, 0.0, -0.555),
];

/// Root, two bends and end of the tail's bones, metres. The tuft continues below the end.
pub const TAIL: [DVec3; 4] = [
    DVec3::new(0.0, 1.2, -0.93),
    DVec3::new(0.0, 1.0, -1.06),
    DVec3::new(0.0, 0.76, -1.08),
    DVec3::new(0.0, 0.54, -1.06),
];

/// Duration of one cycle of `Walk`, seconds.
pub const CYCLE_S: f64 = 1.6;
/// Distance covered by one cycle of `Walk`, metres. The clip itself stays in place.
pub const CYCLE_M: f64 = 1.1;

fn bones() -> Vec<Bone> {
    let v = DVec3::new;
    let mut bones = vec![
        Bone::new("hips", None, v(0.0, 1.1, -0.55), v(0.0, 1.05, -0.8), 0.28),
        Bone::new("spine", Some(HIPS), v(0.0, 1.1, -0.25), v(0.0, 1.05, 0.1), 0.36),
        Bone::new("chest", Some(SPINE), v(0.0, 1.1, 0.22), v(0.0, 1.05, 0.6), 0.3),
        Bone::new("neck", Some(CHEST), v(0.0, 1.08, 0.7), v(0.0, 1.02, 1.06), 0.16),
        Bone::new("head", Some(NECK), v(0.0, 1.04, 1.15), v(0.0, 0.74, 1.62), 0.1),
    ];
    for (name, side) in [("ear_l", 1.0), ("ear_r", -1.0)] {
        let m = |p| on_side(side, p);
        bones.push(Bone::new(name, Some(HEAD), m(v(0.17, 0.955, 1.155)), m(v(0.42, 0.9, 1.08)), 0.03));
    }
    let end = TAIL[3] + v(0.0, -0.22, 0.0);
    for (k, (name, to)) in [("tail", TAIL[1]), ("tail_middle", TAIL[2]), ("tail_tip", end)].into_iter().enumerate() {
        let parent = if k == 0 { HIPS } else { TAILS[k - 1] };
        bones.push(Bone::new(name, Some(parent), TAIL[k], to, 0.02));
    }
    let fore = Pair { parent: CHEST, joints: &FORELEG, thickness: [0.12, 0.08, 0.05, 0.05] };
    let hind = Pair { parent: HIPS, joints: &HIND_LEG, thickness: [0.14, 0.09, 0.05, 0.05] };
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

/// Returns the skin weights for the vertices of `mesh`. Vertices for which `is_horn` is true are bound to the head.
pub fn weights(mesh: &TriMesh, is_horn: &dyn Fn(DVec3) -> bool) -> Vec<Weights> {
    let mut weights = rig::weights(mesh, &bones(), 0.02, 5);
    for (own, &p) in weights.iter_mut().zip(&mesh.positions) {
        if is_horn(p) {
            *own = HEAD_ONLY;
        }
    }
    weights
}

/// Returns a walk of four beats that loops in place: left hind, left fore, right hind, right fore. One cycle covers
/// [`CYCLE_M`] metres in [`CYCLE_S`] seconds.
pub fn walk() -> Clip {
    gait::clip("Walk", &bones(), CYCLE_S, 32, &stride)
}

fn stride(phase: f64, pose: &mut Pose<'_>) {
    // Twice a cycle, the weight sinks onto a pair of legs. The back follows slightly; the heavy head follows more, and
    // later.
    let beat = |start: f64| wave(2.0 * phase, start);
    pose.shift(DVec3::new(0.0, -0.035 + 0.012 * beat(0.1), 0.01 * beat(0.3)));
    pose.pitch(HIPS, 0.8 * beat(0.2));
    pose.pitch(CHEST, -0.8 * beat(0.3));
    pose.pitch(NECK, 2.0 + 4.0 * beat(0.35));
    pose.pitch(HEAD, -2.0 - 2.5 * beat(0.5));
    pose.turn(NECK, DVec3::Y, 2.5 * wave(phase, 0.1));
    for (ear, side) in EARS.into_iter().zip([1.0, -1.0]) {
        pose.turn(ear, DVec3::Z, side * (3.0 + 7.0 * beat(0.6)));
    }
    for (k, joint) in TAILS.into_iter().enumerate() {
        pose.turn(joint, DVec3::Z, [7.0, 9.0, 12.0][k] * wave(phase, 0.1 + 0.09 * k as f64));
        pose.pitch(joint, [4.0, -2.0, -4.0][k]);
    }

    let (tilt, bend) = ([50.0, 52.0], [58.0, -34.0]);
    let walk = Gait { touches: WALK, duty: 0.62, stride: CYCLE_M, front: 0.36, lift: 0.085, tilt, bend };
    hooves::apply_gait(phase, pose, [FORELEGS, HIND_LEGS], &walk);
}
