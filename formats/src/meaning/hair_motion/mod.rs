//! How hair on guides moves: each guide is a string of pearls whose root goes with the skin (Nalu demo; position Verlet after Jakobsen 2001).
//!
//! The runtime does the same on the GPU (`runtime/src/passes/hair_motion`), pearl for pearl. Axes are those of the world, lengths metres, times seconds.
//!
//! - Free pearls fly as Verlet has them, corrected for steps of unequal length, and the air takes them along.
//! - A spring leads each to where it was groomed, another bends each piece back to the shape that it was groomed in. What gravity does to the groomed
//!   shape at rest is part of that shape ([`ballast`]): hair that nothing moves stands as it was groomed.
//! - Lengths hold exactly: the tensions of a string are the solution of a tridiagonal system, a few times over, and what is left goes from root to tip.
//! - A pearl within a collider goes to the place on its surface that is as far from its neighbour as it has to be.

mod ballast;
mod wind;

pub use ballast::{GRAVITY, ballast};
pub use wind::Wind;

use crate::sections::hair_motion::GroupMotion;
use glam::{Mat3, Quat, Vec3};

/// Steps that a second is divided into at least.
pub const STEPS_PER_S: f32 = 120.0;
/// Steps of a frame at most: of a longer frame only so much time passes for hair.
pub const MOST_STEPS: u32 = 16;
/// Times that a pearl is taken out of the colliders.
const PUSHED: u32 = 3;
/// Cosine of the turn beyond which a piece is not as it was.
const LEAST_TURN: f32 = 0.995;
/// Share of what would stop a spring from swinging at all that is in those to the groomed shape.
const DAMPED: f32 = 0.3;
/// Of what is left of a swing when it is said to rest, a thousandth.
const LN_1000: f32 = 6.907_755;
/// Seconds after which it is said to rest at the earliest, and at the latest.
const REST_S: [f32; 2] = [0.5, 20.0];
/// How many of its lengths a second a pearl flies at most, beside its root.
const FASTEST: f32 = 25.0;

/// How finely motion is followed. The runtime has one way, [`Solver::default`]; with others one measures what that costs, and how near to the truth it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Steps that a second is divided into at least, above 0 (default [`STEPS_PER_S`]).
    pub steps_per_s: f32,
    /// Times that the tensions of a string are solved for in a step at most; with 0 lengths go from root to tip only (default 16).
    pub solved: u32,
    /// Share of its length that each piece is to be right within: then no more is solved. What is left goes from root to tip (default 0.0001).
    pub within: f32,
}

/// What [`Solver::advance_frame`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Advanced {
    /// How long its steps were, seconds.
    pub step_s: f32,
    /// How often it solved for the tensions, in all of them.
    pub solved: u32,
}

impl Default for Solver {
    fn default() -> Self {
        Self { steps_per_s: STEPS_PER_S, solved: 16, within: 1e-4 }
    }
}

/// The steps of a frame: how many there are, and how long each is.
pub fn steps(frame_s: f32) -> (u32, f32) {
    Solver::default().steps(frame_s)
}

/// How the hair of a group moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    /// How fast the air takes hair along, 1/s.
    pub drag_per_s: f32,
    /// How often a second hair swings back to where it was groomed; 0: it hangs.
    pub shape_hz: f32,
    /// How often a second its pieces swing back to the shape that they were groomed in; 0: it is limp.
    pub bend_hz: f32,
    /// Share of its speed along a collider that hair loses in [`STEPS_PER_S`] of a second, 0..=1.
    pub friction: f32,
}

/// A guide as it was groomed.
#[derive(Clone, Copy, Debug)]
pub struct Groomed<'a> {
    /// Points relative to the root, which is the first, in the frame of its triangle, metres: two or more.
    pub points: &'a [Vec3],
    /// What [`ballast`] says of them.
    pub ballast: &'a [Vec3],
    /// How freely each moves, 0..=1: not at all, or as a pearl does. Those that do not are the first.
    pub free: &'a [f32],
}

/// A point of a guide that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pearl {
    /// Where it is, from where the root is.
    pub place: Vec3,
    /// Metres a second.
    pub velocity: Vec3,
}

/// Where the skin has the root of a guide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rooted {
    /// The root.
    pub root: Vec3,
    /// From the frame of its triangle to the axes of the world, with the scale of the character.
    pub frame: Mat3,
}

/// What hair does not go into: all that is nearer than `radius_m` to a piece of a line; of no length it is a sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capsule {
    /// One end.
    pub from: Vec3,
    /// The other end.
    pub to: Vec3,
    /// Metres.
    pub radius_m: f32,
}

/// A step of time.
#[derive(Clone, Copy, Debug)]
struct Step<'a> {
    /// How long it is; 0: nothing but lengths and colliders are seen to.
    seconds: f32,
    /// How long the step before was; as long as this one where there was none.
    before_s: f32,
    /// Acceleration of everything, metres a second squared.
    gravity: Vec3,
    /// What the air does, and the moment at the end of the step.
    wind: &'a Wind,
    time_s: f32,
    /// At the end of the step.
    colliders: &'a [Capsule],
    /// How its lengths are held.
    solver: Solver,
}

impl Rooted {
    /// Between two, at a share of the way.
    pub fn between(self, other: Self, share: f32) -> Self {
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let axis = |i: usize| mix(self.frame.col(i), other.frame.col(i));
        Self { root: mix(self.root, other.root), frame: Mat3::from_cols(axis(0), axis(1), axis(2)) }
    }

    /// Pearls that lie as they were groomed, and do not move.
    pub fn groomed(&self, points: &[Vec3]) -> Vec<Pearl> {
        points.iter().map(|p| Pearl { place: self.frame * *p, velocity: Vec3::ZERO }).collect()
    }

    /// How much larger than it was groomed hair is here.
    fn scale(&self) -> f32 {
        libm::cbrtf(self.frame.determinant().abs())
    }
}

impl Capsule {
    /// Between two, at a share of the way.
    pub fn between(self, other: Self, share: f32) -> Self {
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let radius_m = self.radius_m + (other.radius_m - self.radius_m) * share;
        Self { from: mix(self.from, other.from), to: mix(self.to, other.to), radius_m }
    }

    /// The place of its axis that is nearest to another.
    pub fn nearest(&self, place: Vec3) -> Vec3 {
        let along = self.to - self.from;
        let share = (place - self.from).dot(along) / along.length_squared().max(1e-20);
        self.from + along * share.clamp(0.0, 1.0)
    }
}

/// A frame of time, which is some [`steps`].
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// How long it is.
    pub seconds: f32,
    /// How long the steps of the frame before were; as long as those of this one where there was none.
    pub before_s: f32,
    /// Acceleration of everything, metres a second squared.
    pub gravity: Vec3,
    /// What the air does.
    pub wind: Wind,
    /// The moment at the end of the frame, seconds: what the air does changes with it.
    pub time_s: f32,
    /// At the beginning and at the end of the frame.
    pub colliders: &'a [[Capsule; 2]],
}

/// Moves a guide by one frame, as [`Solver::advance_frame`] of the default. Returns how long its steps were.
pub fn advance_frame(
    pearls: &mut [Pearl],
    groomed: &Groomed<'_>,
    springs: &Springs,
    frame: &Frame<'_>,
    before: Rooted,
    now: Rooted,
) -> f32 {
    Solver::default().advance_frame(pearls, groomed, springs, frame, before, now).step_s
}

impl Solver {
    /// The steps of a frame: how many there are, and how long each is. Of a frame longer than [`MOST_STEPS`] of the default only so much time passes.
    pub fn steps(&self, frame_s: f32) -> (u32, f32) {
        let frame_s = frame_s.clamp(0.0, MOST_STEPS as f32 / STEPS_PER_S);
        // A frame of 1/60 s is two steps of 1/120 s, also where it is longer by a rounding.
        let count = ((frame_s * self.steps_per_s - 1e-3).ceil() as u32).max(1);
        (count, frame_s / count as f32)
    }

    /// Moves a guide by one frame.
    ///
    /// * `pearls`: as many as the guide has points
    /// * `before`, `now`: where the skin has its root at the beginning and at the end of the frame
    pub fn advance_frame(
        &self,
        pearls: &mut [Pearl],
        groomed: &Groomed<'_>,
        springs: &Springs,
        frame: &Frame<'_>,
        before: Rooted,
        now: Rooted,
    ) -> Advanced {
        let (count, seconds) = self.steps(frame.seconds);
        let mut solved = 0;
        for number in 1..=count {
            let at = |number: u32| number as f32 / count as f32;
            let colliders: Vec<Capsule> = frame.colliders.iter().map(|[a, b]| a.between(*b, at(number))).collect();
            let step = Step {
                seconds,
                before_s: if number == 1 { frame.before_s } else { seconds },
                gravity: frame.gravity,
                wind: &frame.wind,
                time_s: frame.time_s - (count - number) as f32 * seconds,
                colliders: &colliders,
                // Without time nothing bends or swings.
                solver: Self { solved: if seconds > 0.0 { self.solved } else { 0 }, ..*self },
            };
            let (from, to) = (before.between(now, at(number - 1)), before.between(now, at(number)));
            // Between two frames that are turned lengths are too short; what counts is where the frame goes.
            solved += advance(pearls, groomed, springs, &step, from, to, now);
        }
        Advanced { step_s: seconds, solved }
    }
}

/// Seconds after which hair of such a group has come to rest where nothing moves it: when a thousandth of its swing is left.
pub fn rest_s(motion: &GroupMotion) -> f32 {
    let slowed_per_s = motion.drag_per_s + 2.0 * DAMPED * std::f32::consts::TAU * motion.shape_hz;
    // Oscillations die at half of the rate at which speeds do.
    (2.0 * LN_1000 / slowed_per_s.max(1e-6)).clamp(REST_S[0], REST_S[1])
}

/// A direction, or that of `other` where there is none.
fn direction(v: Vec3, other: Vec3) -> Vec3 {
    let length = v.length();
    if length > 1e-9 { v / length } else { other }
}

/// Moves a guide by one step, from `before` to `now`; pieces are as long as they are in `whole`. Returns how often it solved for the tensions.
fn advance(
    pearls: &mut [Pearl],
    groomed: &Groomed<'_>,
    springs: &Springs,
    step: &Step<'_>,
    before: Rooted,
    now: Rooted,
    whole: Rooted,
) -> u32 {
    let h = step.seconds;
    let scale = whole.scale();
    let goal = |k: usize| now.frame * groomed.points[k];
    let piece = |k: usize| goal(k) - goal(k - 1);
    let length = |k: usize| (whole.frame * (groomed.points[k] - groomed.points[k - 1])).length();
    let lengths: Vec<f32> = (0..pearls.len()).map(|k| if k == 0 { 0.0 } else { length(k) }).collect();
    let fastest = FASTEST * lengths.iter().sum::<f32>();
    let went = now.root - before.root;
    let per_s = if h > 0.0 { 1.0 / h } else { 0.0 };
    let square = |hz: f32| (std::f32::consts::TAU * hz) * (std::f32::consts::TAU * hz);
    let shape = square(springs.shape_hz) / (1.0 + square(springs.shape_hz) * h * h);
    let kept_of_air = libm::expf(-springs.drag_per_s * h);
    let kept_of_shape = libm::expf(-2.0 * DAMPED * std::f32::consts::TAU * springs.shape_hz * h);
    let weight = step.gravity.length() / (GRAVITY * scale.max(1e-9));
    // Where pearls are, from where the root is now.
    pearls.iter_mut().for_each(|pearl| pearl.place -= went);
    let started: Vec<Vec3> = pearls.iter().map(|pearl| pearl.place).collect();

    // What flies.
    let mut held = 0;
    for (k, pearl) in pearls.iter_mut().enumerate() {
        if groomed.free[k] <= 0.0 || k == 0 {
            pearl.place = goal(k);
            held = k;
            continue;
        }
        let air = step.wind.at(now.root + pearl.place, step.time_s);
        let mut velocity = air + (pearl.velocity - air) * kept_of_air;
        let with_skin = (went + goal(k) - before.frame * groomed.points[k]) * per_s;
        let beside = (velocity - with_skin) * kept_of_shape;
        velocity = with_skin + beside * (fastest / beside.length().max(1e-9)).min(1.0);
        let pulled = step.gravity + now.frame * groomed.ballast[k] * weight + (goal(k) - pearl.place) * shape;
        pearl.place += velocity * h + pulled * (0.5 * h * (h + step.before_s));
    }

    // What bends back: each piece turns with the one before, and takes those behind it along.
    let bend = square(springs.bend_hz) * h * h;
    let bend = bend / (1.0 + bend);
    let (mut turn, mut aside) = (Quat::IDENTITY, Vec3::ZERO);
    for k in 1..pearls.len() {
        let (wanted, found) = (turn * piece(k), started[k] - started[k - 1]);
        if k > held {
            aside += (wanted - found) * bend;
            pearls[k].place += aside;
        }
        turn = turned(wanted, found) * turn;
    }

    let mut solved = 0;
    while solved < step.solver.solved && (solved == 0 || off(pearls, &lengths, held) > step.solver.within) {
        hold_lengths(pearls, &started, &lengths, held);
        solved += 1;
    }

    // What is left, from root to tip, and around what is in the way.
    for k in 0..pearls.len() {
        let mut touched = Vec3::ZERO;
        if k > held {
            // Half free means half as far from the groomed place as what is free, step for step of the same length.
            let free = libm::powf(groomed.free[k], STEPS_PER_S * h);
            pearls[k].place = goal(k) + (pearls[k].place - goal(k)) * free;
            let (parent, length) = (pearls[k - 1].place, lengths[k]);
            let way = direction(pearls[k].place - parent, direction(piece(k), Vec3::Y));
            let mut place = parent + way * length;
            for _ in 0..PUSHED {
                for capsule in step.colliders {
                    let center = capsule.nearest(now.root + place) - now.root;
                    if place.distance_squared(center) < capsule.radius_m * capsule.radius_m {
                        place = outside(parent, length, place, center, capsule.radius_m);
                        touched = direction(place - center, Vec3::Y);
                    }
                }
            }
            pearls[k].place = place;
        }
        if h > 0.0 {
            let velocity = (pearls[k].place - started[k]) * per_s;
            let along = velocity - touched * velocity.dot(touched);
            let lost =
                if touched == Vec3::ZERO { 0.0 } else { 1.0 - libm::powf(1.0 - springs.friction, STEPS_PER_S * h) };
            pearls[k].velocity = velocity - along * lost;
        }
    }
    solved
}

/// The most that a piece is longer or shorter than it should be, over its length.
fn off(pearls: &[Pearl], lengths: &[f32], held: usize) -> f32 {
    let of = |k: usize| (pearls[k].place.distance(pearls[k - 1].place) - lengths[k]).abs() / lengths[k].max(1e-9);
    (held + 1..pearls.len()).map(of).fold(0.0, f32::max)
}

/// The least turn from one direction to another.
fn turned(from: Vec3, to: Vec3) -> Quat {
    let (from, to) = (direction(from, Vec3::Y), direction(to, Vec3::Y));
    let (across, half) = (from.cross(to), 1.0 + from.dot(to));
    // Opposite directions have no least turn: none is better than any.
    if half < 1e-6 { Quat::IDENTITY } else { Quat::from_xyzw(across.x, across.y, across.z, half).normalize() }
}

/// One step of Newton's method for the tensions that give all pieces their lengths: pearls beyond `held` have one mass, those up to it do not move.
///
/// Tensions act along the pieces as they were at the beginning of the step (SHAKE, Ryckaert 1977), so that what bears its weight stays where it is; along
/// a piece as it is where that turned too far.
fn hold_lengths(pearls: &mut [Pearl], started: &[Vec3], lengths: &[f32], held: usize) {
    let now = |pearls: &[Pearl], k: usize| direction(pearls[k].place - pearls[k - 1].place, Vec3::Y);
    let then = |k: usize| direction(started[k] - started[k - 1], Vec3::Y);
    let along = |pearls: &[Pearl], k: usize| {
        let (now, then) = (now(pearls, k), then(k));
        if now.dot(then) < LEAST_TURN { now } else { then }
    };
    // Thomas' algorithm: `left` and `right` are what elimination leaves of the row's neighbour and of its right side.
    let mut left = vec![0.0; pearls.len()];
    let mut right = vec![0.0; pearls.len()];
    let mut before = Vec3::ZERO;
    for k in held + 1..pearls.len() {
        let (here, own) = (now(pearls, k), along(pearls, k));
        let neighbour = -here.dot(before);
        let masses = if k == held + 1 { 1.0 } else { 2.0 };
        let pivot = masses * here.dot(own) - neighbour * left[k - 1];
        let next = if k + 1 < pearls.len() { -here.dot(along(pearls, k + 1)) } else { 0.0 };
        let off = pearls[k].place.distance(pearls[k - 1].place) - lengths[k];
        left[k] = next / pivot;
        right[k] = (off - neighbour * right[k - 1]) / pivot;
        before = own;
    }
    let (mut tension, mut pull) = (0.0, Vec3::ZERO);
    for k in (held + 1..pearls.len()).rev() {
        let own = along(pearls, k);
        tension = right[k] - left[k] * tension;
        pearls[k].place += pull - own * tension;
        pull = own * tension;
    }
}

/// The place nearest to `place` that is `length` from `parent` and `radius` from `center`; where there is none, straight away from `center`.
fn outside(parent: Vec3, length: f32, place: Vec3, center: Vec3, radius: f32) -> Vec3 {
    let to_center = center - parent;
    let distance = to_center.length();
    let axis = direction(to_center, direction(parent - place, Vec3::Y));
    // Two spheres meet in a circle about the line through their centers.
    let along = (length * length - radius * radius + distance * distance) / (2.0 * distance.max(1e-9));
    let squared = length * length - along * along;
    if squared <= 0.0 || distance <= 1e-9 {
        return parent - axis * length;
    }
    let beside = place - parent;
    let beside = beside - axis * beside.dot(axis);
    let beside = direction(beside, axis.any_orthonormal_vector());
    parent + axis * along + beside * squared.sqrt()
}

#[cfg(test)]
mod tests;
