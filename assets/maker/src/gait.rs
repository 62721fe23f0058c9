//! Gaits: clips generated from footfalls. Feet follow prescribed paths, and inverse kinematics gives the rotations of
//! the leg joints. A foot on the ground therefore moves backwards exactly as fast as the animal advances.
//!
//! Joints between the root and a foot turn about x only. A leg is solved in its yz-plane, where a rotation is a product
//! of complex numbers `y + i z`. Necks, ears and tails may turn about any axis.

use core::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};

use super::{
    glb::{Channel, Clip, Interpolation, Target},
    rig::{Bone, rotations, turn},
};

/// Pose of a skeleton, built up by changes to the rest pose; parents must be changed before children.
pub struct Pose<'a> {
    bones: &'a [Bone],
    /// Rotation of each joint about x relative to its parent, degrees. Positive angles lower a bone that points
    /// forwards.
    pitch_deg: Vec<f64>,
    /// Further rotations, applied before the one about x.
    turns: Vec<DQuat>,
    /// Offset of the root from rest, metres.
    shift: DVec3,
}

/// Joints of a leg for inverse kinematics, from the body down.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Joint of the thigh or the upper arm.
    pub upper: u8,
    /// Joint of the lower leg or the forearm.
    pub lower: u8,
    /// Joint of a third bone, whose bend [`Foot::cannon_deg`] prescribes.
    pub cannon: Option<u8>,
    /// Joint of the foot; the end of its bone touches the ground.
    pub foot: u8,
}

/// Target of a foot: offset of its tip from rest, metres, and rotation about x in the world, degrees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Foot {
    /// Upward offset, metres.
    pub up: f64,
    /// Forward offset, metres.
    pub forwards: f64,
    /// Rotation about x, degrees; positive raises the heel.
    pub pitch_deg: f64,
    /// Bend of the third bone relative to rest, degrees.
    pub cannon_deg: f64,
}

/// Footfalls of one leg. Phases are fractions of the cycle.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Phase at which the foot touches down.
    pub touch: f64,
    /// Fraction of the cycle during which the foot is on the ground.
    pub duty: f64,
    /// Forward offset from rest at touchdown, metres.
    pub front: f64,
    /// Distance the animal covers in a cycle, metres.
    pub stride: f64,
    /// Greatest height of the tip while the foot is in the air, metres.
    pub lift: f64,
}

impl Step {
    /// Returns the phase since touchdown, 0..1. The foot is on the ground while the result is below [`Step::duty`].
    pub fn phase_since_touch(&self, phase: f64) -> f64 {
        let since = phase - self.touch;
        since - libm::floor(since)
    }

    /// Returns the foot's offset at `phase`, without its rotations.
    pub fn foot(&self, phase: f64) -> Foot {
        let since = self.phase_since_touch(phase);
        if since <= self.duty {
            return Foot { forwards: self.front - self.stride * since, ..Foot::default() };
        }
        // The foot leaves the ground and lands at ground speed, so that it neither jerks nor slides.
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

/// Returns the foot joint of each of `legs`, and the rest position of the foot's tip in model space.
pub fn feet<'a>(bones: &[Bone], legs: impl IntoIterator<Item = &'a Leg>) -> Vec<(usize, DVec3)> {
    legs.into_iter().map(|leg| (usize::from(leg.foot), bones[leg.foot as usize].to)).collect()
}

/// Evaluates a smooth periodic curve at `phase`. `keys` are pairs of phase (0..1, ascending) and value. The curve is
/// piecewise cubic; the slope at a key is that of the line between its two neighbours.
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

/// Returns a sine with one period per cycle, 0 at `start`.
pub fn wave(phase: f64, start: f64) -> f64 {
    libm::sin(2.0 * PI * (phase - start))
}

/// Returns a vector's projection onto the yz-plane, as the complex number `y + i z`.
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

    /// Moves the root by `by`, metres.
    pub fn shift(&mut self, by: DVec3) {
        self.shift += by;
    }

    /// Rotates a joint about x, degrees. Positive angles lower a bone that points forwards.
    pub fn pitch(&mut self, joint: u8, degrees: f64) {
        self.pitch_deg[joint as usize] += degrees;
    }

    /// Rotates a joint about any axis, degrees. Not allowed for joints between the root and a foot.
    pub fn turn(&mut self, joint: u8, axis: DVec3, degrees: f64) {
        let own = &mut self.turns[joint as usize];
        *own = turn(axis, degrees) * *own;
    }

    /// Returns the position of a joint in the yz-plane, metres, and its rotation in the world, radians.
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

    /// Bends a leg so that its foot reaches `foot`, or comes as near as the leg's length allows. Returns the remaining
    /// distance, metres.
    pub fn solve_leg(&mut self, leg: &Leg, foot: Foot) -> f64 {
        let radians = PI / 180.0;
        let bone = |joint: u8| self.bones[joint as usize];
        let (upper, lower, end) = (bone(leg.upper), bone(leg.lower), bone(leg.foot));
        let tip = plane(end.to) + DVec2::new(foot.up, foot.forwards);
        let heel = tip - turned(plane(end.to - end.from), foot.pitch_deg * radians);

        // The lower leg with its bent third bone is treated as one straight bone from the middle joint to the foot
        // joint.
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
        // The middle joint bends to the same side as in the rest pose.
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

/// Builds a clip of one cycle with `frames` equal time steps. `pose` changes the rest pose for a phase in 0..1. The
/// last key equals the first.
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
