//! The hare's skeleton, its skin weights and its clips.

use glam::DVec3;

use super::{
    gait::{self, Leg, Pose, Step, cycle},
    glb::{Channel, Clip, Interpolation, Joint, Target, Weights},
    rig::{self, Bone, bound_to, rotations, turn},
    trimesh::TriMesh,
};

/// Returns the root, tip and unit facing direction of an ear; `side` is +1 for the hare's left ear (towards +X).
pub fn ear(side: f64) -> [DVec3; 3] {
    // The left ear is slightly higher and further forward than the right one: a listening hare.
    let (tip_height, lean) = if side > 0.0 { (0.482, 0.033) } else { (0.475, 0.010) };
    [
        DVec3::new(side * 0.0165, 0.341, 0.05),
        DVec3::new(side * 0.05, tip_height, lean),
        DVec3::new(side * 0.5, 0.12, 0.86).normalize(),
    ]
}

const HIPS: u8 = 0;
const SPINE: u8 = 1;
const CHEST: u8 = 2;
const RIBS: u8 = 3;
const NECK: u8 = 4;
const HEAD: u8 = 5;
const EAR_L: u8 = 6;
const EAR_L_TIP: u8 = 7;
const EAR_R: u8 = 8;
const EAR_R_TIP: u8 = 9;
const TAIL: u8 = 10;
const FORELEGS: [Leg; 2] =
    [Leg { upper: 11, lower: 13, cannon: None, foot: 14 }, Leg { upper: 12, lower: 15, cannon: None, foot: 16 }];
const HIND_LEGS: [Leg; 2] =
    [Leg { upper: 17, lower: 18, cannon: None, foot: 19 }, Leg { upper: 20, lower: 21, cannon: None, foot: 22 }];

/// Weights bound only to the head: eyes and nose.
pub const HEAD_ONLY: Weights = bound_to(HEAD);

/// Duration of one hop of `Walk`, seconds.
pub const HOP_S: f64 = 0.8;
/// Distance covered by one hop of `Walk`, metres. The clip itself stays in place.
pub const HOP_M: f64 = 0.48;

fn bones() -> Vec<Bone> {
    let v = DVec3::new;
    let [root_l, tip_l, _] = ear(1.0);
    let [root_r, tip_r, _] = ear(-1.0);
    let (mid_l, mid_r) = (root_l.lerp(tip_l, 0.5), root_r.lerp(tip_r, 0.5));
    let bone = |name, parent, from, to| Bone::new(name, parent, from, to, 0.0);
    let mut bones = vec![
        bone("hips", None, v(0.0, 0.075, -0.075), v(0.0, 0.09, -0.07)),
        bone("spine", Some(HIPS), v(0.0, 0.125, -0.055), v(0.0, 0.17, -0.03)),
        bone("chest", Some(SPINE), v(0.0, 0.175, 0.0), v(0.0, 0.215, 0.02)),
        // No joint is a child of the ribs. Their scale, which animates breathing, therefore affects neither neck nor
        // legs.
        bone("ribs", Some(CHEST), v(0.0, 0.165, 0.02), v(0.0, 0.185, 0.055)),
        bone("neck", Some(CHEST), v(0.0, 0.235, 0.035), v(0.0, 0.275, 0.05)),
        bone("head", Some(NECK), v(0.0, 0.295, 0.06), v(0.0, 0.3, 0.12)),
        bone("ear_l", Some(HEAD), root_l, mid_l),
        bone("ear_l_tip", Some(EAR_L), mid_l, tip_l),
        bone("ear_r", Some(HEAD), root_r, mid_r),
        bone("ear_r_tip", Some(EAR_R), mid_r, tip_r),
        bone("tail", Some(HIPS), v(0.0, 0.075, -0.138), v(0.0, 0.1, -0.165)),
    ];
    let side = |x: f64, p: DVec3| v(x * p.x, p.y, p.z);
    let (shoulder, elbow, wrist, paw) =
        (v(0.033, 0.145, 0.05), v(0.0285, 0.082, 0.0645), v(0.0275, 0.022, 0.073), v(0.028, 0.008, 0.095));
    for (name, x) in [("leg_l", 1.0), ("leg_r", -1.0)] {
        bones.push(Bone::new(name, Some(CHEST), side(x, shoulder), side(x, elbow), 0.008));
    }
    for (names, x, leg) in [(["forearm_l", "paw_l"], 1.0, 0), (["forearm_r", "paw_r"], -1.0, 1)] {
        let Leg { upper, lower, .. } = FORELEGS[leg];
        bones.push(Bone::new(names[0], Some(upper), side(x, elbow), side(x, wrist), 0.008));
        bones.push(Bone::new(names[1], Some(lower), side(x, wrist), side(x, paw), 0.008));
    }
    let (hip, knee, hock, toe) =
        (v(0.06, 0.112, -0.082), v(0.073, 0.062, 0.008), v(0.073, 0.022, -0.072), v(0.078, 0.008, 0.066));
    let names = [["thigh_l", "shank_l", "foot_l"], ["thigh_r", "shank_r", "foot_r"]];
    for ((names, x), Leg { upper, lower, .. }) in names.into_iter().zip([1.0, -1.0]).zip(HIND_LEGS) {
        bones.push(Bone::new(names[0], Some(HIPS), side(x, hip), side(x, knee), 0.03));
        bones.push(Bone::new(names[1], Some(upper), side(x, knee), side(x, hock), 0.012));
        bones.push(Bone::new(names[2], Some(lower), side(x, hock), side(x, toe), 0.012));
    }
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
    rig::weights(mesh, &bones(), 0.0032, 4)
}

/// Creates rotation keys about one axis. `keys` are pairs of seconds and degrees.
fn rotation_keys(joint: u8, axis: DVec3, keys: &[(f64, f64)]) -> Channel {
    rotations(joint, keys.iter().map(|&(t, degrees)| (t, turn(axis, degrees))))
}

/// Returns a looping clip of two seconds: one ear flicks, the other sways, the head nods slightly, the ribs breathe
/// twice.
pub fn ear_breath() -> Clip {
    let twitch = [(0.0, 0.0), (0.3, 0.0), (0.42, 16.0), (0.54, -5.0), (0.68, 9.0), (0.9, 0.0), (2.0, 0.0)];
    let flick = [(0.0, 0.0), (0.36, 0.0), (0.48, 14.0), (0.62, -8.0), (0.78, 5.0), (1.0, 0.0), (2.0, 0.0)];
    let sway = [(0.0, 0.0), (0.5, 5.0), (1.0, 0.0), (1.5, -6.0), (2.0, 0.0)];
    let bend = [(0.0, 0.0), (0.6, 4.0), (1.1, 0.0), (1.6, -7.0), (2.0, 0.0)];
    let nod = [(0.0, 0.0), (0.7, 1.5), (1.4, -1.0), (2.0, 0.0)];
    let wag = [(0.0, 0.0), (1.1, 0.0), (1.2, 10.0), (1.32, -8.0), (1.45, 0.0), (2.0, 0.0)];
    // A cubic-spline key holds in-tangent, value and out-tangent. Tangents of zero at the turning points give even
    // breathing.
    let breath = |x: f64| [[0.0; 3], [1.0 + x, 1.0 + 0.5 * x, 1.0 + x], [0.0; 3]];
    let ribs = [0.0, 0.045, 0.0, 0.045, 0.0];
    Clip {
        name: "EarBreath".into(),
        channels: vec![
            rotation_keys(EAR_L, DVec3::Z, &twitch),
            rotation_keys(EAR_L_TIP, DVec3::Z, &flick),
            rotation_keys(EAR_R, DVec3::X, &sway),
            rotation_keys(EAR_R_TIP, DVec3::X, &bend),
            rotation_keys(HEAD, DVec3::X, &nod),
            rotation_keys(TAIL, DVec3::X, &wag),
            Channel {
                joint: RIBS.into(),
                target: Target::Scale,
                interpolation: Interpolation::CubicSpline,
                times: (0..5).map(|k| f64::from(k) * 0.5).collect(),
                values: ribs.iter().flat_map(|&x| breath(x)).flatten().collect(),
            },
        ],
    }
}

/// Returns one hop that loops in place. The hind feet push off into the stretched leap, the forefeet land, and the hind
/// feet swing past them on the outside. One hop covers [`HOP_M`] metres in [`HOP_S`] seconds.
pub fn walk() -> Clip {
    gait::clip("Walk", &bones(), HOP_S, 24, &hop)
}

fn hop(phase: f64, pose: &mut Pose<'_>) {
    // The back is round and gathered at hind touchdown (phase 0) and stretched in the leap (0.45). The nose is down
    // while the forefeet land.
    let pitch = cycle(&[(0.0, 36.0), (0.2, 31.0), (0.36, 27.0), (0.5, 34.0), (0.66, 44.0), (0.84, 42.0)], phase);
    let bend = cycle(&[(0.0, 14.0), (0.2, 6.0), (0.4, -6.0), (0.6, 0.0), (0.8, 12.0)], phase);
    let height =
        cycle(&[(0.0, 0.045), (0.18, 0.035), (0.38, 0.075), (0.52, 0.085), (0.68, 0.07), (0.86, 0.075)], phase);
    let forwards = cycle(&[(0.0, -0.03), (0.25, -0.04), (0.5, -0.02), (0.75, -0.02)], phase);
    pose.shift(DVec3::new(0.0, height, forwards));
    pose.pitch(HIPS, pitch);
    pose.pitch(SPINE, bend);
    pose.pitch(CHEST, bend + 6.0);
    let carried = pitch + 2.0 * bend + 6.0;
    // The neck compensates part of the back's pitch, so that the head keeps its height and looks ahead. The ears trail
    // behind the motion of the back.
    pose.pitch(NECK, 0.25 * (30.0 - carried));
    pose.pitch(HEAD, 0.75 * (14.0 - carried));
    let ears = cycle(&[(0.0, -52.0), (0.25, -40.0), (0.5, -62.0), (0.75, -48.0)], phase);
    let tips = cycle(&[(0.1, -8.0), (0.35, 4.0), (0.6, -22.0), (0.85, -10.0)], phase);
    for (ear, tip, more) in [(EAR_L, EAR_L_TIP, 0.0), (EAR_R, EAR_R_TIP, -6.0)] {
        pose.pitch(ear, ears + more);
        pose.pitch(tip, tips);
    }
    pose.pitch(TAIL, cycle(&[(0.0, -10.0), (0.4, 22.0), (0.7, 5.0)], phase));

    for (leg, touch) in HIND_LEGS.into_iter().zip([0.0, 0.02]) {
        let step = Step { touch, duty: 0.36, front: 0.03, stride: HOP_M, lift: 0.05 };
        let mut foot = step.foot(phase);
        foot.pitch_deg = cycle(
            &[
                (0.0, -4.0),
                (0.08, 0.0),
                (0.16, 4.0),
                (0.3, 36.0),
                (0.39, 58.0),
                (0.5, 34.0),
                (0.62, 12.0),
                (0.78, 4.0),
                (0.9, -6.0),
            ],
            step.phase_since_touch(phase),
        );
        pose.solve_leg(&leg, foot);
    }
    for (leg, touch) in FORELEGS.into_iter().zip([0.6, 0.55]) {
        let step = Step { touch, duty: 0.27, front: 0.1, stride: HOP_M, lift: 0.035 };
        let mut foot = step.foot(phase);
        foot.pitch_deg = cycle(
            &[(0.0, -6.0), (0.06, 0.0), (0.2, 8.0), (0.32, 60.0), (0.6, 70.0), (0.85, 10.0)],
            step.phase_since_touch(phase),
        );
        pose.solve_leg(&leg, foot);
    }
}
