//! Gaits: clips from footfalls. Feet are led along their paths, and the legs' joints follow by inverse kinematics, so that a foot on the
//! ground moves backwards exactly as fast as the animal would go forwards.
//!
//! Everything that carries a foot turns about x alone: a leg is solved in its plane of y and z, where a turn is a product of
//! complex numbers `y + i z`. Necks, ears and tails may turn about any axis.

use core::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};

use super::{
    glb::{Channel, Clip, Interpolation, Target},
    rig::{Bone, rotations, turn},
};

/// A pose of a skeleton, changed from rest step by step: parents before children.
pub struct Pose<'a> {
    bones: &'a [Bone],
    /// Turn about x against the parent, degrees; positive lowers what points forwards.
    pitch_deg: Vec<f64>,
    /// Further turns, before the one about x.
    turns: Vec<DQuat>,
    /// How far the root is from its rest, metres.
    shift: DVec3,
}

/// A leg: the joints that are solved, from the body down.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Joint of the thigh or the upper arm.
    pub upper: u8,
    /// Joint of the shank or the forearm.
    pub lower: u8,
    /// Joint of a third bone, bent by hand.
    pub cannon: Option<u8>,
    /// Joint of the foot; the end of its bone is what touches the ground.
    pub foot: u8,
}

/// Where a foot is: offset of its tip from rest, metres, and its turn about x in the world, degrees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Foot {
    /// Up.
    pub up: f64,
    /// Forwards.
    pub forwards: f64,
    /// Heel up is positive.
    pub pitch_deg: f64,
    /// Bend of the third bone against rest, degrees.
    pub cannon_deg: f64,
}

/// Footfalls of one leg. Phases are shares of the cycle.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Phase at which the foot comes down.
    pub touch: f64,
    /// Share of the cycle that it stays down.
    pub duty: f64,
    /// Where it comes down, forwards of its rest, metres.
    pub front: f64,
    /// How far the animal goes in a cycle, metres.
    pub stride: f64,
    /// How high the tip is lifted, metres.
    pub lift: f64,
}

impl Step {
    /// Phase since the foot came down, 0..1; below [`Step::duty`] it is on the ground.
    pub fn since(&self, phase: f64) -> f64 {
        let since = phase - self.touch;
        since - libm::floor(since)
    }

    /// The foot's place at `phase`, without its turns.
    pub fn foot(&self, phase: f64) -> Foot {
        let since = self.since(phase);
        if since <= self.duty {
            return Foot { forwards: self.front - self.stride * since, ..Foot::default() };
        }
        // It leaves and comes down with the speed of the ground, so that it neither jerks nor scuffs.
        let air = 1.0 - self.duty;
        let s = (since - self.duty) / air;
        let (back, slope) = (self.front - self.stride * self.duty, -self.stride * air);
        let (s2, s3) = (s * s, s * s * s);
        let forwards = back * (2.0 * s3 - 3.0 * s2 + 1.0)
            + self.front * (3.0 * s2 - 2.0 * s3)
            + slope * ((s3 - 2.0 * s2 + s) + (s3 - s2));
        Foot { forwards, up: self.lift * 16.0 * s2 * (1.0 - s) * (1.0 - s), ..Foot::default() }
    }
}

/// The feet of `legs`: joint, and where in the model the foot's tip rests.
pub fn feet<'a>(bones: &[Bone], legs: impl IntoIterator<Item = &'a Leg>) -> Vec<(usize, DVec3)> {
    legs.into_iter().map(|leg| (usize::from(leg.foot), bones[leg.foot as usize].to)).collect()
}

/// A smooth periodic curve through `keys` (phase in 0..1, ascending, and value) at `phase`: cubic pieces whose slope at a key is that of
/// the line between its neighbours.
pub fn cycle(keys: &[(f64, f64)], phase: f64) -> f64 {
    let n = keys.len() as i64;
    let key = |k: i64| {
        let (at, value) = keys[k.rem_euclid(n) as usize];
        (at + k.div_euclid(n) as f64, value)
    };
    let phase = phase - libm::floor(phase);
    let next = keys.partition_point(|k| k.0 <= phase) as i64;
    let [before, from, to, after] = [next - 2, next - 1, next, next + 1].map(key);
    let gap = to.0 - from.0;
    let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0) * gap;
    let s = (phase - from.0) / gap;
    let (s2, s3) = (s * s, s * s * s);
    from.1 * (2.0 * s3 - 3.0 * s2 + 1.0)
        + slope(before, to) * (s3 - 2.0 * s2 + s)
        + to.1 * (3.0 * s2 - 2.0 * s3)
        + slope(from, after) * (s3 - s2)
}

/// A sine of one period in a cycle, from 0 at `start`.
pub fn wave(phase: f64, start: f64) -> f64 {
    libm::sin(2.0 * PI * (phase - start))
}

/// `y + i z` of a vector.
fn plane(v: DVec3) -> DVec2 {
    DVec2::new(v.y, v.z)
}

fn turned(v: DVec2, angle: f64) -> DVec2 {
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    DVec2::new(v.x * c - v.y * s, v.x * s + v.y * c)
}

fn angle(v: DVec2) -> f64 {
    libm::atan2(v.y, v.x)
}

impl Pose<'_> {
    fn rest(bones: &[Bone]) -> Pose<'_> {
        Pose { bones, pitch_deg: vec![0.0; bones.len()], turns: vec![DQuat::IDENTITY; bones.len()], shift: DVec3::ZERO }
    }

    /// Moves the root, metres.
    pub fn shift(&mut self, by: DVec3) {
        self.shift += by;
    }

    /// Turns a joint about x, degrees; positive lowers what points forwards.
    pub fn pitch(&mut self, joint: u8, degrees: f64) {
        self.pitch_deg[joint as usize] += degrees;
    }

    /// Turns a joint about another axis, degrees; not for joints that carry a leg.
    pub fn turn(&mut self, joint: u8, axis: DVec3, degrees: f64) {
        let own = &mut self.turns[joint as usize];
        *own = turn(axis, degrees) * *own;
    }

    /// Place of a joint in the plane, metres, and its turn in the world, radians.
    fn world(&self, joint: u8) -> (DVec2, f64) {
        let bone = &self.bones[joint as usize];
        let own = self.pitch_deg[joint as usize] * PI / 180.0;
        match bone.parent {
            None => (plane(bone.from + self.shift), own),
            Some(parent) => {
                let (at, pitch) = self.world(parent);
                (at + turned(plane(bone.from - self.bones[parent as usize].from), pitch), pitch + own)
            }
        }
    }

    /// Bends a leg so that its foot is where `foot` says, or as near as the leg is long; returns by how much it falls short, metres.
    pub fn lead(&mut self, leg: &Leg, foot: Foot) -> f64 {
        let radians = PI / 180.0;
        let bone = |joint: u8| self.bones[joint as usize];
        let (upper, lower, end) = (bone(leg.upper), bone(leg.lower), bone(leg.foot));
        let tip = plane(end.to) + DVec2::new(foot.up, foot.forwards);
        let heel = tip - turned(plane(end.to - end.from), foot.pitch_deg * radians);

        // With its third bone bent, the lower leg is a straight line from the middle joint to the foot's.
        let bent = foot.cannon_deg * radians;
        let below = match leg.cannon.map(bone) {
            Some(cannon) => plane(cannon.from - lower.from) + turned(plane(end.from - cannon.from), bent),
            None => plane(end.from - lower.from),
        };
        let above = plane(lower.from - upper.from);
        let (carrier, carried) = upper.parent.map_or((DVec2::ZERO, 0.0), |parent| {
            let (at, pitch) = self.world(parent);
            (at + turned(plane(upper.from - bone(parent).from), pitch), pitch)
        });
        let way = heel - carrier;
        let (a, b, wanted) = (above.length(), below.length(), way.length());
        let distance = wanted.clamp((a - b).abs() * 1.001, (a + b) * 0.9999);
        // The middle joint bends to the side to which it is bent at rest.
        let side = above.perp_dot(plane(end.from - lower.from)).signum();
        let corner = libm::acos(((a * a + distance * distance - b * b) / (2.0 * a * distance)).clamp(-1.0, 1.0));
        let upper_turn = angle(way) - side * corner - angle(above);
        let knee = carrier + turned(above, upper_turn);
        let lower_turn = angle(carrier + way * (distance / wanted) - knee) - angle(below);

        let mut set = |joint: u8, radians: f64| {
            let turns = radians / (2.0 * PI);
            self.pitch_deg[joint as usize] = (turns - libm::floor(turns + 0.5)) * 360.0;
        };
        set(leg.upper, upper_turn - carried);
        set(leg.lower, lower_turn - upper_turn);
        let mut last = lower_turn;
        if let Some(cannon) = leg.cannon {
            set(cannon, bent);
            last += bent;
        }
        set(leg.foot, foot.pitch_deg * radians - last);
        wanted - distance
    }
}

/// A clip of one cycle in `frames` even steps: `pose` bends the resting skeleton for a phase in 0..1. The last key is the first again.
pub fn clip(name: &str, bones: &[Bone], seconds: f64, frames: usize, pose: &dyn Fn(f64, &mut Pose<'_>)) -> Clip {
    let poses: Vec<Pose<'_>> = (0..=frames)
        .map(|k| {
            let mut own = Pose::rest(bones);
            pose((k % frames) as f64 / frames as f64, &mut own);
            own
        })
        .collect();
    let times: Vec<f64> = (0..=frames).map(|k| seconds * k as f64 / frames as f64).collect();
    let mut channels = Vec::new();
    if poses.iter().any(|p| p.shift != DVec3::ZERO) {
        channels.push(Channel {
            joint: 0,
            target: Target::Translation,
            interpolation: Interpolation::Linear,
            times: times.clone(),
            values: poses.iter().flat_map(|p| (bones[0].from + p.shift).to_array()).collect(),
        });
    }
    for joint in 0..bones.len() {
        let local = |p: &Pose<'_>| turn(DVec3::X, p.pitch_deg[joint]) * p.turns[joint];
        if poses.iter().any(|p| local(p) != DQuat::IDENTITY) {
            channels.push(rotations(joint as u8, times.iter().copied().zip(poses.iter().map(local))));
        }
    }
    Clip { name: name.into(), channels }
}
