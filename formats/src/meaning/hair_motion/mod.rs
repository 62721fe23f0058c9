//! Motion of guided hair: each guide is a string of particles whose root moves with the surface (Nalu demo; position
//! Verlet after Jakobsen 2001).
//!
//! The runtime does the same on the GPU (`runtime/src/passes/hair_motion`), particle for particle. Vectors are in world
//! space, lengths in metres, times in seconds.
//!
//! - Free particles move by Verlet integration, corrected for steps of unequal length, with air drag.
//! - One spring pulls each particle to its groomed position; another bends each segment back to its groomed shape. The
//!   effect of gravity at rest is part of the groomed shape ([`gravity_compensation`]), so hair at rest stays as
//!   groomed.
//! - Segment lengths are exact. The tensions of a string solve a tridiagonal system, which is iterated a few times; the
//!   remaining error is corrected from root to tip.
//! - A particle inside a collider moves to a point on its surface at the required distance from its neighbour.

mod ballast;
mod wind;

pub use ballast::{GRAVITY, gravity_compensation};
pub use wind::Wind;

use crate::sections::hair_motion::GroupMotion;
use glam::{Mat3, Quat, Vec3};

/// Minimum number of steps per second.
pub const STEPS_PER_S: f32 = 120.0;
/// Maximum number of steps per frame. If a frame is longer, hair simulates only the time of these steps.
pub const MOST_STEPS: u32 = 16;
/// Number of passes in which a particle is pushed out of all colliders.
const COLLISION_PASSES: u32 = 3;
/// Cosine of the angle that selects the direction of a tension. If a segment has turned by more since the start of the
/// step, its tension acts along its current direction, else along its direction at that start.
const MIN_TURN_COS: f32 = 0.995;
/// Damping of the springs to the groomed shape, as a share of critical damping.
const SHAPE_DAMPING: f32 = 0.3;
/// Natural logarithm of 1000: hair is at rest when its swing has decayed to a thousandth.
const LN_1000: f32 = 6.907_755;
/// Minimum and maximum of the time after which hair is considered at rest, seconds.
const REST_S: [f32; 2] = [0.5, 20.0];
/// Maximum speed of a particle relative to its root, guide lengths per second.
const MAX_SPEED: f32 = 25.0;

/// Accuracy of the simulation. The runtime always uses [`Solver::default`]; other values serve to measure cost and
/// accuracy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solver {
    /// Minimum number of steps per second, above 0 (default [`STEPS_PER_S`]).
    pub steps_per_s: f32,
    /// Maximum number of tension solves in a step (default 16). With 0, tensions are not solved, and lengths are only
    /// corrected from root to tip.
    pub solved: u32,
    /// Relative error of the segment lengths at which solving stops (default 0.0001). The remaining error is corrected
    /// from root to tip.
    pub within: f32,
}

/// Result of [`Solver::advance_frame`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Duration of a step, seconds.
    pub step_s: f32,
    /// Number of tension solves, over all steps.
    pub solved: u32,
}

impl Default for Solver {
    fn default() -> Self {
        Self { steps_per_s: STEPS_PER_S, solved: 16, within: 1e-4 }
    }
}

/// Returns the number of steps of a frame and the duration of each, seconds.
pub fn steps(frame_s: f32) -> (u32, f32) {
    Solver::default().steps(frame_s)
}

/// Spring constants of a group's hair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Springs {
    /// Drag rate: how fast hair takes on the velocity of the air, 1/s.
    pub drag_per_s: f32,
    /// Frequency of the spring to the groomed position, Hz. With 0, hair hangs.
    pub shape_hz: f32,
    /// Frequency of the spring to the groomed shape of each segment, Hz. With 0, hair is limp.
    pub bend_hz: f32,
    /// Share of the tangential speed that hair loses in 1 / [`STEPS_PER_S`] seconds while it touches a collider, 0..=1.
    pub friction: f32,
}

/// Guide as groomed.
#[derive(Clone, Copy, Debug)]
pub struct GroomedGuide<'a> {
    /// Points relative to the root, which is the first, in the frame of the root's triangle, metres; two or more.
    pub points: &'a [Vec3],
    /// Result of [`gravity_compensation`] for the points.
    pub ballast: &'a [Vec3],
    /// Freedom of each point, 0..=1: 0 is fixed to its groomed position, 1 is free. Fixed points come first.
    pub free: &'a [f32],
}

/// Particle: a moving point of a guide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Particle {
    /// Position relative to the root, metres.
    pub place: Vec3,
    /// Velocity, m/s.
    pub velocity: Vec3,
}

/// Root of a guide on the posed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootFrame {
    /// Position of the root.
    pub root: Vec3,
    /// Matrix from the frame of the root's triangle to world axes, including the scale of the character.
    pub frame: Mat3,
}

/// Capsule collider: all points closer than `radius_m` to a line segment. A segment of length 0 gives a sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Capsule {
    /// First end.
    pub from: Vec3,
    /// Second end.
    pub to: Vec3,
    /// Radius, metres.
    pub radius_m: f32,
}

#[derive(Clone, Copy, Debug)]
struct Step<'a> {
    /// Duration, seconds. With 0, only lengths and colliders are enforced.
    seconds: f32,
    /// Duration of the previous step, seconds; equal to `seconds` if there was none.
    before_s: f32,
    /// Gravitational acceleration, m/s².
    gravity: Vec3,
    /// Wind, and the time at the end of the step.
    wind: &'a Wind,
    time_s: f32,
    /// Colliders at the end of the step.
    colliders: &'a [Capsule],
    solver: Solver,
}

impl RootFrame {
    /// Interpolates linearly between two root frames: `share` 0 gives `self`, 1 gives `other`.
    pub fn between(self, other: Self, share: f32) -> Self {
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let axis = |i: usize| mix(self.frame.col(i), other.frame.col(i));
        Self { root: mix(self.root, other.root), frame: Mat3::from_cols(axis(0), axis(1), axis(2)) }
    }

    /// Returns the particles in their groomed positions, at rest.
    pub fn groomed(&self, points: &[Vec3]) -> Vec<Particle> {
        points.iter().map(|p| Particle { place: self.frame * *p, velocity: Vec3::ZERO }).collect()
    }

    /// Returns the scale of the hair relative to its groomed size.
    fn scale(&self) -> f32 {
        libm::cbrtf(self.frame.determinant().abs())
    }
}

impl Capsule {
    /// Interpolates linearly between two capsules: `share` 0 gives `self`, 1 gives `other`.
    pub fn between(self, other: Self, share: f32) -> Self {
        let mix = |a: Vec3, b: Vec3| a + (b - a) * share;
        let radius_m = self.radius_m + (other.radius_m - self.radius_m) * share;
        Self { from: mix(self.from, other.from), to: mix(self.to, other.to), radius_m }
    }

    /// Returns the point of the axis nearest to `place`.
    pub fn nearest(&self, place: Vec3) -> Vec3 {
        let along = self.to - self.from;
        let share = (place - self.from).dot(along) / along.length_squared().max(1e-20);
        self.from + along * share.clamp(0.0, 1.0)
    }
}

/// Time interval of a frame, which is divided into [`steps`].
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// Duration, seconds.
    pub seconds: f32,
    /// Duration of a step of the previous frame, seconds. Without a previous frame, that of a step of this frame.
    pub before_s: f32,
    /// Gravitational acceleration, m/s².
    pub gravity: Vec3,
    /// Wind.
    pub wind: Wind,
    /// Time at the end of the frame, seconds; the wind depends on it.
    pub time_s: f32,
    /// Colliders at the beginning and at the end of the frame.
    pub colliders: &'a [[Capsule; 2]],
}

/// Moves a guide by one frame with [`Solver::advance_frame`] of the default solver. Returns the duration of its steps.
pub fn advance_frame(
    pearls: &mut [Particle],
    groomed: &GroomedGuide<'_>,
    springs: &Springs,
    frame: &Frame<'_>,
    before: RootFrame,
    now: RootFrame,
) -> f32 {
    Solver::default().advance_frame(pearls, groomed, springs, frame, before, now).step_s
}

impl Solver {
    /// Returns the number of steps of a frame and the duration of each, seconds. A frame is limited to the duration of
    /// [`MOST_STEPS`] default steps.
    pub fn steps(&self, frame_s: f32) -> (u32, f32) {
        let frame_s = frame_s.clamp(0.0, MOST_STEPS as f32 / STEPS_PER_S);
        // A frame of 1/60 s is two steps of 1/120 s, even if rounding makes it slightly longer.
        let count = ((frame_s * self.steps_per_s - 1e-3).ceil() as u32).max(1);
        (count, frame_s / count as f32)
    }

    /// Moves a guide by one frame.
    ///
    /// * `pearls`: particles, one for each point of the guide
    /// * `before`, `now`: root of the guide on the surface, at the beginning and at the end of the frame
    pub fn advance_frame(
        &self,
        pearls: &mut [Particle],
        groomed: &GroomedGuide<'_>,
        springs: &Springs,
        frame: &Frame<'_>,
        before: RootFrame,
        now: RootFrame,
    ) -> StepReport {
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
                // Nothing moves in a step of duration 0, so no tensions are solved.
                solver: Self { solved: if seconds > 0.0 { self.solved } else { 0 }, ..*self },
            };
            let (from, to) = (before.between(now, at(number - 1)), before.between(now, at(number)));
            // Interpolating between two rotated frames shortens lengths. Therefore all steps use the lengths at the end
            // of the frame.
            solved += advance(pearls, groomed, springs, &step, from, to, now);
        }
        StepReport { step_s: seconds, solved }
    }
}

/// Returns the time, in seconds, after which a swing of undisturbed hair has decayed to a thousandth.
pub fn rest_s(motion: &GroupMotion) -> f32 {
    let slowed_per_s = motion.drag_per_s + 2.0 * SHAPE_DAMPING * std::f32::consts::TAU * motion.shape_hz;
    // Oscillations decay at half the rate of velocities.
    (2.0 * LN_1000 / slowed_per_s.max(1e-6)).clamp(REST_S[0], REST_S[1])
}

/// Returns the direction of `v`, or `other` if the length of `v` is too small.
fn direction(v: Vec3, other: Vec3) -> Vec3 {
    let length = v.length();
    if length > 1e-9 { v / length } else { other }
}

/// Moves a guide by one step and returns the number of tension solves.
///
/// * `before`, `now`: root at the beginning and at the end of the step
/// * `whole`: root whose scale determines the segment lengths
fn advance(
    pearls: &mut [Particle],
    groomed: &GroomedGuide<'_>,
    springs: &Springs,
    step: &Step<'_>,
    before: RootFrame,
    now: RootFrame,
    whole: RootFrame,
) -> u32 {
    let h = step.seconds;
    let scale = whole.scale();
    let goal = |k: usize| now.frame * groomed.points[k];
    let piece = |k: usize| goal(k) - goal(k - 1);
    let length = |k: usize| (whole.frame * (groomed.points[k] - groomed.points[k - 1])).length();
    let lengths: Vec<f32> = (0..pearls.len()).map(|k| if k == 0 { 0.0 } else { length(k) }).collect();
    let fastest = MAX_SPEED * lengths.iter().sum::<f32>();
    let went = now.root - before.root;
    let per_s = if h > 0.0 { 1.0 / h } else { 0.0 };
    let square = |hz: f32| (std::f32::consts::TAU * hz) * (std::f32::consts::TAU * hz);
    let shape = square(springs.shape_hz) / (1.0 + square(springs.shape_hz) * h * h);
    let kept_of_air = libm::expf(-springs.drag_per_s * h);
    let kept_of_shape = libm::expf(-2.0 * SHAPE_DAMPING * std::f32::consts::TAU * springs.shape_hz * h);
    let weight = step.gravity.length() / (GRAVITY * scale.max(1e-9));
    // Make positions relative to the current root.
    pearls.iter_mut().for_each(|pearl| pearl.place -= went);
    let started: Vec<Vec3> = pearls.iter().map(|pearl| pearl.place).collect();

    // Move the free particles by a Verlet step.
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

    // Apply the bending springs from root to tip: the groomed shape of each segment is rotated with the previous
    // segment. A correction also moves all later points.
    let bend = square(springs.bend_hz) * h * h;
    let bend = bend / (1.0 + bend);
    let (mut turn, mut aside) = (Quat::IDENTITY, Vec3::ZERO);
    for k in 1..pearls.len() {
        let (wanted, found) = (turn * piece(k), started[k] - started[k - 1]);
        if k > held {
            aside += (wanted - found) * bend;
            pearls[k].place += aside;
        }
        turn = smallest_rotation(wanted, found) * turn;
    }

    let mut solved = 0;
    while solved < step.solver.solved && (solved == 0 || max_length_error(pearls, &lengths, held) > step.solver.within)
    {
        restore_lengths(pearls, &started, &lengths, held);
        solved += 1;
    }

    // Correct the remaining length error from root to tip, and push particles out of colliders.
    for k in 0..pearls.len() {
        let mut touched = Vec3::ZERO;
        if k > held {
            // With a freedom of 0.5, each step of nominal duration halves the distance to the groomed position.
            let free = libm::powf(groomed.free[k], STEPS_PER_S * h);
            pearls[k].place = goal(k) + (pearls[k].place - goal(k)) * free;
            let (parent, length) = (pearls[k - 1].place, lengths[k]);
            let way = direction(pearls[k].place - parent, direction(piece(k), Vec3::Y));
            let mut place = parent + way * length;
            for _ in 0..COLLISION_PASSES {
                for capsule in step.colliders {
                    let center = capsule.nearest(now.root + place) - now.root;
                    if place.distance_squared(center) < capsule.radius_m * capsule.radius_m {
                        place = outside_sphere(parent, length, place, center, capsule.radius_m);
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

fn max_length_error(pearls: &[Particle], lengths: &[f32], held: usize) -> f32 {
    let of = |k: usize| (pearls[k].place.distance(pearls[k - 1].place) - lengths[k]).abs() / lengths[k].max(1e-9);
    (held + 1..pearls.len()).map(of).fold(0.0, f32::max)
}

fn smallest_rotation(from: Vec3, to: Vec3) -> Quat {
    let (from, to) = (direction(from, Vec3::Y), direction(to, Vec3::Y));
    let (across, half) = (from.cross(to), 1.0 + from.dot(to));
    // Opposite directions have no unique smallest rotation; the identity is better than an arbitrary one.
    if half < 1e-6 { Quat::IDENTITY } else { Quat::from_xyzw(across.x, across.y, across.z, half).normalize() }
}

/// Performs one Newton step for the tensions that restore the lengths of all segments. Particles after index `held`
/// have equal masses; the others do not move.
///
/// Tensions act along the segments' directions at the beginning of the step (SHAKE, Ryckaert 1977). Hair that carries
/// its own weight thus stays in place. If a segment has since turned beyond `MIN_TURN_COS`, its tension acts along its
/// current direction.
fn restore_lengths(pearls: &mut [Particle], started: &[Vec3], lengths: &[f32], held: usize) {
    let now = |pearls: &[Particle], k: usize| direction(pearls[k].place - pearls[k - 1].place, Vec3::Y);
    let then = |k: usize| direction(started[k] - started[k - 1], Vec3::Y);
    let along = |pearls: &[Particle], k: usize| {
        let (now, then) = (now(pearls, k), then(k));
        if now.dot(then) < MIN_TURN_COS { now } else { then }
    };
    // Thomas algorithm: `left` and `right` hold each row's upper coefficient and right-hand side after elimination.
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

/// Returns the point nearest to `place` at distance `length` from `parent` and `radius` from `center`. If there is
/// none, returns the point at distance `length` from `parent`, straight away from `center`.
fn outside_sphere(parent: Vec3, length: f32, place: Vec3, center: Vec3, radius: f32) -> Vec3 {
    let to_center = center - parent;
    let distance = to_center.length();
    let axis = direction(to_center, direction(parent - place, Vec3::Y));
    // Two spheres intersect in a circle about the line through their centres.
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
