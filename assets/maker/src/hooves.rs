//! Legs of hoofed animals: bones and steps.

use glam::DVec3;

use super::{
    body::on_side,
    gait::{Leg, Pose, Step, cycle},
    rig::Bone,
};

/// Returns a leg of four consecutive bones, the first with index `first`.
pub const fn leg(first: u8) -> Leg {
    Leg { upper: first, lower: first + 1, cannon: Some(first + 2), foot: first + 3 }
}

/// Pair of legs.
pub struct Pair<'a> {
    /// Index of the parent bone.
    pub parent: u8,
    /// Joints of the left leg from top to bottom, then the front end of the hoof, metres.
    pub joints: &'a [DVec3; 5],
    /// Radius of the flesh around each bone, metres.
    pub thickness: [f64; 4],
}

/// Adds the bones of the forelegs, left and right, then those of the hind legs.
pub fn add_legs(bones: &mut Vec<Bone>, fore: &Pair<'_>, hind: &Pair<'_>) {
    let arms = [["arm_l", "forearm_l", "cannon_l", "hoof_l"], ["arm_r", "forearm_r", "cannon_r", "hoof_r"]];
    let thighs = [
        ["thigh_l", "shank_l", "hind_cannon_l", "hind_hoof_l"],
        ["thigh_r", "shank_r", "hind_cannon_r", "hind_hoof_r"],
    ];
    for (names, Pair { parent, joints: places, thickness }) in [(arms, fore), (thighs, hind)] {
        for (names, side) in names.into_iter().zip([1.0, -1.0]) {
            let first = bones.len() as u8;
            for (k, name) in names.into_iter().enumerate() {
                let parent = if k == 0 { *parent } else { first + k as u8 - 1 };
                let (from, to) = (on_side(side, places[k]), on_side(side, places[k + 1]));
                bones.push(Bone::new(name, Some(parent), from, to, thickness[k]));
            }
        }
    }
}

/// Touchdown phases of the hooves: first index fore or hind, second index left or right.
pub type Touches = [[f64; 2]; 2];

/// Touchdowns of a walk, whose four beats overlap: left hind, left fore, right hind, right fore.
pub const WALK: Touches = [[0.25, 0.75], [0.0, 0.5]];
/// Touchdowns of a gallop: the hind legs one after the other, then the forelegs, then all four hooves are in the air.
pub const GALLOP: Touches = [[0.34, 0.49], [0.0, 0.13]];

/// Duty factor to which the keys of tilt and bend refer. Phases of gaits with another duty factor are rescaled to it.
const KEYED_DUTY: f64 = 0.62;

/// Gait of an animal.
pub struct Gait {
    /// Touchdown phases of the hooves.
    pub touches: Touches,
    /// Fraction of the cycle during which each hoof is on the ground.
    pub duty: f64,
    /// Distance covered in a cycle, metres.
    pub stride: f64,
    /// Forward offset of a hoof from rest at touchdown, metres.
    pub front: f64,
    /// Greatest height of a hoof while it is in the air, metres.
    pub lift: f64,
    /// Tilt of a hoof just after it leaves the ground and later in the air, degrees.
    pub tilt: [f64; 2],
    /// Bend of the cannon while the hoof is in the air, of a foreleg and of a hind leg, degrees.
    pub bend: [f64; 2],
}

/// Moves the forelegs and hind legs of a pose according to a gait.
pub fn apply_gait(phase: f64, pose: &mut Pose<'_>, [fore, hind]: [[Leg; 2]; 2], gait: &Gait) {
    let ([fore_bend, hind_bend], [fore_touches, hind_touches]) = (gait.bend, gait.touches);
    for (legs, bend, touches) in [
        (hind, [(0.0, 4.0), (0.3, 0.0), (0.58, 10.0), (0.78, hind_bend), (0.94, -4.0)], hind_touches),
        (fore, [(0.0, 0.0), (0.3, 0.0), (0.6, 0.0), (0.78, fore_bend), (0.95, 2.0)], fore_touches),
    ] {
        for (leg, touch) in legs.into_iter().zip(touches) {
            let step = Step { touch, duty: gait.duty, front: gait.front, stride: gait.stride, lift: gait.lift };
            let since = step.phase_since_touch(phase);
            let key = if since < gait.duty {
                since / gait.duty * KEYED_DUTY
            } else {
                1.0 - (1.0 - since) / (1.0 - gait.duty) * (1.0 - KEYED_DUTY)
            };
            let mut foot = step.foot(phase);
            let tilt = [
                (0.0, -6.0),
                (0.05, 0.0),
                (0.25, 0.0),
                (0.45, 2.0),
                (0.56, 22.0),
                (0.64, gait.tilt[0]),
                (0.76, gait.tilt[1]),
                (0.92, 2.0),
            ];
            foot.pitch_deg = cycle(&tilt, key);
            foot.cannon_deg = cycle(&bend, key);
            pose.solve_leg(&leg, foot);
        }
    }
}
