//! True motion of hair on a guide, by the equations that `pelage_formats::meaning::hair_motion` solves with longer
//! steps.
//!
//! Points xₖ of unit mass follow the root x₀ = r(t), which moves with the mesh surface and its frame F(t). pₖ is the
//! groomed position in that frame, and gₖ = r + F pₖ is the position to which the surface would carry the point. eₖ is
//! the direction from xₖ₋₁ to xₖ, and τₖ is the tension of that piece:
//!
//! ```text
//! x″ₖ = G + F bₖ                              gravity, and the ballast that bears the groomed shape at rest
//!     + c (u(t, xₖ) − x′ₖ)                    air u drags the point along, c = drag_per_s
//!     + ω² (gₖ − xₖ) + 2 ζ ω (g′ₖ − x′ₖ)      spring to the groomed position, ω = 2π shape_hz, ζ = 0.3
//!     + β² Σ (Rⱼ F (pⱼ − pⱼ₋₁) − (xⱼ − xⱼ₋₁)) over j ≤ k: bending, β = 2π bend_hz
//!     − τₖ eₖ + τₖ₊₁ eₖ₊₁
//! |xₖ − xₖ₋₁| = |pₖ − pₖ₋₁|
//! R₁ = 1, Rⱼ₊₁ = (smallest rotation of Rⱼ F (pⱼ − pⱼ₋₁) to xⱼ − xⱼ₋₁) Rⱼ
//! ```
//!
//! Differentiating the length constraints twice gives a tridiagonal system for the tensions: eₖ·(x″ₖ − x″ₖ₋₁) = −|x′ₖ −
//! x′ₖ₋₁|² / lₖ. With these tensions, the equations are ordinary differential equations, which the fourth-order
//! Runge-Kutta method integrates. After each step, positions and velocities are projected onto the length constraints,
//! along the pieces and with the smallest change, which prevents drift. A sudden change of the root's velocity is an
//! impulse on the lengths, and the same projection applies it.
//!
//! [`TrueGuide::converged`] halves the steps until the result no longer changes. Chaotic motions remain sensitive to
//! rounding: a slack string whips, and its motion soon depends on rounding instead of its start. Such motions have no
//! truth beyond the first seconds, as the number of halvings shows.
//!
//! There are no colliders, and every point but the root is completely free. Friction and limited freedom are defined by
//! steps, and have no equation to compare with.

use glam::{DMat3, DQuat, DVec3};
use std::f64::consts::TAU;

/// Damping ratio ζ of the springs towards the groomed position; 1 is critical damping.
const DAMPED: f64 = 0.3;
/// Time step of the finite differences for velocities of the mesh surface, seconds.
const MOMENT_S: f64 = 1e-4;
/// Maximum number of Newton iterations that correct lengths after a step.
const ROUNDS: usize = 12;
/// Error at which the iterations stop, in lengths of the guide; only rounding is left then.
const EXACT: f64 = 1e-13;

/// Position and motion of a guide's root on the mesh surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RootMotion {
    /// Position of the root, metres.
    pub root: DVec3,
    /// Velocity of the root, metres per second.
    pub velocity: DVec3,
    /// Acceleration of the root, metres per second squared.
    pub acceleration: DVec3,
    /// Rotation from the frame of the root's triangle to the world axes.
    pub frame: DMat3,
    /// Time derivative of `frame`, 1/s.
    pub turning: DMat3,
}

impl RootMotion {
    /// Returns the state of a smoothly moving root, by finite differences of fourth order.
    ///
    /// * `way`: root and frame at a time in seconds
    pub fn smooth(way: impl Fn(f64) -> (DVec3, DMat3), time_s: f64) -> Self {
        let at = |k: f64| way(time_s + k * MOMENT_S);
        let [a, b, here, c, d] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(at);
        let per_s = 1.0 / (12.0 * MOMENT_S);
        let second = (16.0 * (b.0 + c.0) - (a.0 + d.0) - 30.0 * here.0) * (per_s / MOMENT_S);
        Self {
            root: here.0,
            velocity: (8.0 * (c.0 - b.0) - (d.0 - a.0)) * per_s,
            acceleration: second,
            frame: here.1,
            turning: ((c.1 - b.1) * 8.0 - (d.1 - a.1)) * per_s,
        }
    }

    /// Returns the state of a root that moves in a straight line between two positions, as in a renderer that knows
    /// only frames. `share` is the fraction of the way that is covered.
    pub fn straight_between(from: (DVec3, DMat3), to: (DVec3, DMat3), seconds: f64, share: f64) -> Self {
        let (velocity, turning) = ((to.0 - from.0) / seconds, (to.1 - from.1) * (1.0 / seconds));
        let s = share * seconds;
        let (root, frame) = (from.0 + velocity * s, from.1 + turning * s);
        Self { root, velocity, acceleration: DVec3::ZERO, frame, turning }
    }
}

/// Guide with all forces on it.
#[derive(Clone, Copy)]
pub struct TrueGuide<'a> {
    /// Groomed points relative to the root, in the frame of its triangle, metres. The root is the first of two or more
    /// points; consecutive points differ.
    pub points: &'a [DVec3],
    /// Accelerations that keep the points at rest in their groomed shape, in the frame of the root's triangle; one per
    /// point.
    pub ballast: &'a [DVec3],
    /// Rate at which the air drags hair along, 1/s, 0..
    pub drag_per_s: f64,
    /// Frequency of the springs towards the groomed positions, Hz, 0..
    pub shape_hz: f64,
    /// Frequency of the springs that keep the groomed shape of the pieces, Hz, 0..
    pub bend_hz: f64,
    /// Acceleration of all points, metres per second squared.
    pub gravity: DVec3,
    /// Velocity of the air as a function of time in seconds and position, metres per second.
    pub air: &'a (dyn Fn(f64, DVec3) -> DVec3 + Sync),
}

/// State of a moving guide.
#[derive(Clone, Debug, PartialEq)]
pub struct GuideState {
    /// World positions of the points, the root first, metres.
    pub places: Vec<DVec3>,
    /// Velocities of the points, metres per second.
    pub velocities: Vec<DVec3>,
}

/// Motion that starts at rest, computed with steps that are short enough.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueMotion {
    /// World positions of the points at the end of each frame, metres.
    pub places: Vec<Vec<DVec3>>,
    /// Number of steps per frame.
    pub steps: u32,
    /// Largest distance between a point and its position when computed with half as many steps, in lengths of the
    /// guide.
    pub change: f64,
}

/// Returns the tensions of pieces with directions `along` for which eₖ·(aₖ − aₖ₋₁) = `wanted`ₖ. The system is solved by
/// elimination from root to tip and back. The first entry of both arguments is unused.
fn tensions(along: &[DVec3], wanted: &[f64]) -> Vec<f64> {
    let count = along.len();
    let (mut left, mut right) = (vec![0.0; count], vec![0.0; count]);
    for k in 1..count {
        // Tensions do not accelerate the root.
        let (diagonal, before) = if k == 1 { (1.0, 0.0) } else { (2.0, -along[k].dot(along[k - 1])) };
        let pivot = diagonal - before * left[k - 1];
        left[k] = if k + 1 < count { -along[k].dot(along[k + 1]) / pivot } else { 0.0 };
        right[k] = (-wanted[k] - before * right[k - 1]) / pivot;
    }
    let mut out = vec![0.0; count];
    for k in (1..count).rev() {
        out[k] = right[k] - if k + 1 < count { left[k] * out[k + 1] } else { 0.0 };
    }
    out
}

/// Adds the accelerations or impulses due to tensions to the values of a string's points.
fn pull(points: &mut [DVec3], along: &[DVec3], tensions: &[f64]) {
    for k in 1..points.len() {
        points[k] -= along[k] * tensions[k];
        if k + 1 < points.len() {
            points[k] += along[k + 1] * tensions[k + 1];
        }
    }
}

/// Returns the unit directions of the pieces, preceded by a zero vector.
fn directions(places: &[DVec3]) -> Vec<DVec3> {
    std::iter::once(DVec3::ZERO).chain(places.windows(2).map(|ends| (ends[1] - ends[0]).normalize_or_zero())).collect()
}

/// Returns the smallest rotation from one direction to another. For opposite directions, it is not unique, and the
/// identity is returned.
fn smallest_rotation(from: DVec3, to: DVec3) -> DQuat {
    let (from, to) = (from.normalize_or_zero(), to.normalize_or_zero());
    let (across, half) = (from.cross(to), 1.0 + from.dot(to));
    if half < 1e-12 { DQuat::IDENTITY } else { DQuat::from_xyzw(across.x, across.y, across.z, half).normalize() }
}

impl TrueGuide<'_> {
    /// Returns the length of the guide, metres.
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
    }

    /// Returns the state in which the groomed shape moves rigidly with the mesh surface.
    pub fn groomed(&self, skin: &RootMotion) -> GuideState {
        GuideState {
            places: self.points.iter().map(|p| skin.root + skin.frame * *p).collect(),
            velocities: self.points.iter().map(|p| skin.velocity + skin.turning * *p).collect(),
        }
    }

    /// Returns the accelerations of all points. The root has the acceleration of the mesh surface.
    fn accelerations(&self, skin: &RootMotion, time_s: f64, places: &[DVec3], velocities: &[DVec3]) -> Vec<DVec3> {
        let count = places.len();
        let (shape, bend) = (TAU * self.shape_hz, TAU * self.bend_hz);
        let mut out = vec![skin.acceleration; count];
        let (mut turn, mut bent) = (DQuat::IDENTITY, DVec3::ZERO);
        for k in 1..count {
            let wanted = turn * (skin.frame * (self.points[k] - self.points[k - 1]));
            let found = places[k] - places[k - 1];
            bent += wanted - found;
            turn = smallest_rotation(wanted, found) * turn;
            let goal = skin.root + skin.frame * self.points[k];
            let goes = skin.velocity + skin.turning * self.points[k];
            out[k] = self.gravity
                + skin.frame * self.ballast[k]
                + ((self.air)(time_s, places[k]) - velocities[k]) * self.drag_per_s
                + (goal - places[k]) * (shape * shape)
                + (goes - velocities[k]) * (2.0 * DAMPED * shape)
                + bent * (bend * bend);
        }
        let along = directions(places);
        let wanted: Vec<f64> = (0..count)
            .map(|k| {
                if k == 0 {
                    return 0.0;
                }
                let turns = (velocities[k] - velocities[k - 1]).length_squared() / places[k].distance(places[k - 1]);
                -turns - along[k].dot(out[k] - out[k - 1])
            })
            .collect();
        pull(&mut out, &along, &tensions(&along, &wanted));
        out
    }

    /// Projects positions onto the length constraints, and removes velocities that violate them.
    fn project_lengths(&self, skin: &RootMotion, swing: &mut GuideState) {
        swing.places[0] = skin.root;
        swing.velocities[0] = skin.velocity;
        let lengths: Vec<f64> =
            std::iter::once(0.0).chain(self.points.windows(2).map(|ends| ends[0].distance(ends[1]))).collect();
        let most = EXACT * self.length();
        for _ in 0..ROUNDS {
            let along = directions(&swing.places);
            let off = |k: usize| if k == 0 { 0.0 } else { lengths[k] - swing.places[k].distance(swing.places[k - 1]) };
            let wanted: Vec<f64> = (0..lengths.len()).map(off).collect();
            if wanted.iter().all(|off| off.abs() <= most) {
                break;
            }
            pull(&mut swing.places, &along, &tensions(&along, &wanted));
        }
        let along = directions(&swing.places);
        let grows = |k: usize| if k == 0 { 0.0 } else { along[k].dot(swing.velocities[k - 1] - swing.velocities[k]) };
        let wanted: Vec<f64> = (0..lengths.len()).map(grows).collect();
        pull(&mut swing.velocities, &along, &tensions(&along, &wanted));
    }

    /// Advances the state by `seconds` from `time_s` on, in `steps` steps.
    ///
    /// * `skin`: motion of the root after a fraction of `seconds`, 0..=1; smooth within this range
    pub fn advance(
        &self,
        swing: &mut GuideState,
        skin: impl Fn(f64) -> RootMotion,
        time_s: f64,
        seconds: f64,
        steps: u32,
    ) {
        let h = seconds / f64::from(steps);
        let mut here = skin(0.0);
        self.project_lengths(&here, swing);
        for step in 0..steps {
            let share = |part: f64| (f64::from(step) + part) / f64::from(steps);
            let (middle, end) = (skin(share(0.5)), skin(share(1.0)));
            let mut at = swing.clone();
            let mut sum = GuideState { places: vec![DVec3::ZERO; at.places.len()], velocities: Vec::new() };
            sum.velocities.clone_from(&sum.places);
            for (skin, part, weight) in [(&here, 0.0, 1.0), (&middle, 0.5, 2.0), (&middle, 0.5, 2.0), (&end, 1.0, 1.0)]
            {
                if part > 0.0 {
                    // Each Runge-Kutta stage starts from the slope that the previous stage left in `at`.
                    for k in 0..at.places.len() {
                        at.places[k] = swing.places[k] + at.places[k] * (h * part);
                        at.velocities[k] = swing.velocities[k] + at.velocities[k] * (h * part);
                    }
                    (at.places[0], at.velocities[0]) = (skin.root, skin.velocity);
                }
                let time_s = time_s + share(part) * seconds;
                let accelerations = self.accelerations(skin, time_s, &at.places, &at.velocities);
                (at.places, at.velocities) = (at.velocities, accelerations);
                for k in 0..at.places.len() {
                    sum.places[k] += at.places[k] * weight;
                    sum.velocities[k] += at.velocities[k] * weight;
                }
            }
            for k in 0..at.places.len() {
                swing.places[k] += sum.places[k] * (h / 6.0);
                swing.velocities[k] += sum.velocities[k] * (h / 6.0);
            }
            self.project_lengths(&end, swing);
            here = end;
        }
    }

    /// Returns the positions of the points at the end of each frame. The motion starts at rest at time 0.
    ///
    /// * `way`: root and frame at a time in seconds
    /// * `straight`: whether the root moves in a straight line from frame to frame
    pub fn frames(
        &self,
        way: &dyn Fn(f64) -> (DVec3, DMat3),
        straight: bool,
        (frames, frame_s): (u32, f64),
        steps: u32,
    ) -> Vec<Vec<DVec3>> {
        let skin = |frame: u32, share: f64| {
            let at = |share: f64| (f64::from(frame) + share) * frame_s;
            if straight {
                RootMotion::straight_between(way(at(0.0)), way(at(1.0)), frame_s, share)
            } else {
                RootMotion::smooth(way, at(share))
            }
        };
        let mut swing = self.groomed(&RootMotion::straight_between(way(0.0), way(0.0), frame_s, 0.0));
        (0..frames)
            .map(|frame| {
                self.advance(&mut swing, |share| skin(frame, share), f64::from(frame) * frame_s, frame_s, steps);
                swing.places.clone()
            })
            .collect()
    }

    /// Computes the motion of [`Self::frames`], doubling the number of steps until no point moves by more than `within`
    /// lengths of the guide. Stops at 4096 steps per frame.
    pub fn converged(
        &self,
        way: &dyn Fn(f64) -> (DVec3, DMat3),
        straight: bool,
        times: (u32, f64),
        within: f64,
    ) -> TrueMotion {
        let mut steps = 32;
        let mut places = self.frames(way, straight, times, steps / 2);
        loop {
            let finer = self.frames(way, straight, times, steps);
            let off =
                |(a, b): (&Vec<DVec3>, &Vec<DVec3>)| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            let change = places.iter().zip(&finer).map(off).fold(0.0, f64::max) / self.length();
            places = finer;
            if change <= within || steps >= 4096 {
                return TrueMotion { places, steps, change };
            }
            steps *= 2;
        }
    }
}

#[cfg(test)]
#[path = "hair_motion_tests.rs"]
mod tests;
