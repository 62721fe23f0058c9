//! Simulated guided hair: stiff strings, springs and long steps, frames of any length, obstacles, and roots that
//! jump.
//!
//! The naive form is the published one of Nalu (GPU Gems 2, chapter 23, after Jakobsen 2001). It uses position Verlet
//! with one step per frame, whatever the frame's length, and loses a constant fraction of the speed per step. A few
//! iterations then move points out of spheres, and correct each piece from root to tip.

use super::row::{Finding, Row};
use glam::{Mat3, Vec3};
use pelage_formats::meaning::hair_motion::{
    Capsule, Frame, GRAVITY, GroomedGuide, Particle, RootFrame, Springs, Wind, advance_frame, gravity_compensation,
    steps,
};
use pelage_import::BakeError;
use std::f32::consts::TAU;

/// Row of the stability table.
pub const ROW: Row = Row {
    method: "hair in motion",
    cliff: "long guides, stiff springs, frames of varying length, colliders, roots that jump",
    naive: "Verlet, one step per frame, a fraction of the speed lost per step, four sweeps over spheres and lengths",
    safe: "steps of 1/120 s, damping per unit of time, implicit springs, a linear solve for tensions, \
           spheres resolved at constant segment length",
    drive,
};

/// String simulated by the published form.
#[derive(Clone, Debug)]
pub struct PrintedString {
    /// World positions of the points, the root first, metres.
    pub places: Vec<Vec3>,
    /// World positions at the previous step.
    before: Vec<Vec3>,
}

/// Parameters of a step of the published form.
#[derive(Clone, Copy, Debug)]
pub struct PrintedStep<'a> {
    /// Duration, seconds.
    pub seconds: f32,
    /// Fraction of the speed that is lost, 0..=1.
    pub lost: f32,
    /// Lengths of the pieces, metres, preceded by an unused entry.
    pub lengths: &'a [f32],
    /// Number of iterations over spheres and lengths.
    pub sweeps: u32,
    /// Spheres that hair must not enter, handled one after the other. Each is given as a capsule, of which only one end
    /// is used.
    pub spheres: &'a [Capsule],
}

impl PrintedString {
    /// Creates a string at rest at the given positions.
    pub fn new(places: Vec<Vec3>) -> Self {
        Self { before: places.clone(), places }
    }

    /// Moves the string by a step: x' = x + (1 − d)(x − x*) + a Δt². Iterations over spheres and lengths follow.
    ///
    /// * `root`: current position of the root
    /// * `accelerations`: of all points, metres per second squared
    pub fn step(&mut self, root: Vec3, accelerations: &[Vec3], step: &PrintedStep<'_>) {
        let (kept, square) = (1.0 - step.lost, step.seconds * step.seconds);
        for (k, pulled) in accelerations.iter().enumerate().skip(1) {
            let next = self.places[k] + (self.places[k] - self.before[k]) * kept + *pulled * square;
            self.before[k] = std::mem::replace(&mut self.places[k], next);
        }
        self.places[0] = root;
        for _ in 0..step.sweeps {
            for sphere in step.spheres {
                for place in &mut self.places[1..] {
                    let way = *place - sphere.from;
                    if way.length() < sphere.radius_m {
                        *place = sphere.from + way.normalize_or(Vec3::Y) * sphere.radius_m;
                    }
                }
            }
            sweep(&mut self.places, step.lengths);
        }
    }
}

/// Corrects each piece separately, from root to tip. Both ends move half the distance, but the root does not move.
pub fn sweep(places: &mut [Vec3], lengths: &[f32]) {
    for k in 1..places.len() {
        let way = places[k] - places[k - 1];
        let off = way * (1.0 - lengths[k] / way.length().max(1e-9));
        let share = if k == 1 { 0.0 } else { 0.5 };
        places[k - 1] += off * share;
        places[k] -= off * (1.0 - share);
    }
}

/// Number of iterations over the lengths in the published form.
const SWEEPS: u32 = 4;
/// Frames per second for which the damping of the published form is tuned.
const FPS: f32 = 60.0;
const CALM: Springs = Springs { drag_per_s: 2.0, shape_hz: 0.5, bend_hz: 0.0, friction: 0.2 };

/// Property of the root or the obstacles as a function of time in seconds.
type OverTime<'a, T> = &'a dyn Fn(f32) -> T;

/// Times of the ends of frames, and world positions of the points.
type Motion = Vec<(f32, Vec<Vec3>)>;

/// Hanging string, 0.3 m long, that both forms simulate.
struct HangingString<'a> {
    points: usize,
    springs: Springs,
    fps: f32,
    seconds: f32,
    root: OverTime<'a, Vec3>,
    spheres: OverTime<'a, Vec<Capsule>>,
}

const LENGTH: f32 = 0.3;

impl HangingString<'_> {
    fn points(&self) -> Vec<Vec3> {
        (0..self.points).map(|k| Vec3::NEG_Y * (LENGTH * k as f32 / (self.points - 1) as f32)).collect()
    }

    /// Simulates the string with the runtime's solver. Returns the time and the world positions at the end of each
    /// frame.
    fn ours(&self) -> Motion {
        let (points, free) = (self.points(), vec![1.0; self.points]);
        let ballast = gravity_compensation(&points, Mat3::IDENTITY);
        let groomed = GroomedGuide { points: &points, ballast: &ballast, free: &free };
        let rooted = |time_s| RootFrame { root: (self.root)(time_s), frame: Mat3::IDENTITY };
        let mut pearls: Vec<Particle> = rooted(0.0).groomed(&points);
        let mut before_s = steps(1.0 / self.fps).1;
        self.times()
            .map(|[from, to]| {
                let colliders: Vec<[Capsule; 2]> =
                    (self.spheres)(from).into_iter().zip((self.spheres)(to)).map(|(a, b)| [a, b]).collect();
                let frame = Frame {
                    seconds: 1.0 / self.fps,
                    before_s,
                    gravity: Vec3::NEG_Y * GRAVITY,
                    wind: Wind::default(),
                    time_s: to,
                    colliders: &colliders,
                };
                before_s = advance_frame(&mut pearls, &groomed, &self.springs, &frame, rooted(from), rooted(to));
                (to, pearls.iter().map(|pearl| rooted(to).root + pearl.place).collect())
            })
            .collect()
    }

    /// Simulates the string with the published form.
    fn printed(&self) -> Motion {
        let points = self.points();
        let lengths = vec![LENGTH / (self.points - 1) as f32; self.points];
        let mut string = PrintedString::new(points.iter().map(|p| (self.root)(0.0) + *p).collect());
        let omega = TAU * self.springs.shape_hz;
        let lost = 1.0 - libm::expf(-(self.springs.drag_per_s + 0.6 * omega) / FPS);
        self.times()
            .map(|[_, to]| {
                let (root, spheres) = ((self.root)(to), (self.spheres)(to));
                let step =
                    PrintedStep { seconds: 1.0 / self.fps, lost, lengths: &lengths, sweeps: SWEEPS, spheres: &spheres };
                let pulled = |k: usize| (root + points[k] - string.places[k]) * (omega * omega) + Vec3::NEG_Y * GRAVITY;
                let pulled: Vec<Vec3> = (0..self.points).map(pulled).collect();
                string.step(root, &pulled, &step);
                (to, string.places.clone())
            })
            .collect()
    }

    fn times(&self) -> impl Iterator<Item = [f32; 2]> {
        let fps = self.fps;
        (1..=libm::roundf(self.seconds * fps) as u32).map(move |n| [n - 1, n].map(|n| n as f32 / fps))
    }
}

/// Returns the greatest value of `of` from time `since` on. Values that are not finite count as infinite.
fn greatest(motion: &[(f32, Vec<Vec3>)], since: f32, of: impl Fn(f32, &[Vec3]) -> f32) -> f64 {
    let found = motion.iter().filter(|(time, _)| *time >= since).map(|(time, places)| of(*time, places));
    // `f32::max` would discard NaN.
    f64::from(found.fold(0.0f32, |most, x| {
        if x <= most {
            most
        } else if x.is_finite() {
            x
        } else {
            f32::INFINITY
        }
    }))
}

/// Returns the largest relative deviation of any piece from its length.
fn stretch(places: &[Vec3]) -> f32 {
    let length = LENGTH / (places.len() - 1) as f32;
    let off = |ends: &[Vec3]| (ends[0].distance(ends[1]) / length - 1.0).abs();
    places.windows(2).map(off).fold(0.0, |most, x| if x <= most { most } else { x })
}

fn no_obstacles(_: f32) -> Vec<Capsule> {
    Vec::new()
}

fn drive() -> Result<Vec<Finding>, BakeError> {
    let still = |_: f32| Vec3::ZERO;
    let gallop = |time_s: f32| Vec3::new(0.0, 0.15 * libm::sinf(TAU * 2.2 * time_s), 0.0);
    let base =
        HangingString { points: 64, springs: CALM, fps: FPS, seconds: 5.0, root: &still, spheres: &no_obstacles };
    let both = |drive: &HangingString<'_>, since: f32, of: &dyn Fn(f32, &[Vec3]) -> f32| {
        (greatest(&drive.printed(), since, of), greatest(&drive.ours(), since, of))
    };
    let finding = |case: &str, measure: &'static str, (naive, safe): (f64, f64), bound: f64, fails_above: f64| {
        Finding { case: case.into(), measure, naive, safe, bound, fails_above }
    };
    let longer = "largest relative error of a segment's length";
    let mut out = Vec::new();

    let hangs = both(&base, 3.0, &|_, places| stretch(places));
    out.push(finding("a string of 64 points hangs at rest", longer, hangs, 0.01, 0.1));
    let gallops = both(&HangingString { root: &gallop, ..base }, 0.0, &|_, places| stretch(places));
    out.push(finding("a string of 64 points at a gallop", longer, gallops, 0.03, 0.3));

    let stiff = HangingString {
        points: 16,
        springs: Springs { shape_hz: 5.0, ..CALM },
        fps: 2.0,
        seconds: 3.0,
        root: &|time_s: f32| Vec3::X * (0.05 * time_s),
        ..base
    };
    let far = |time_s: f32, places: &[Vec3]| {
        let root = (stiff.root)(time_s);
        let farthest = places.iter().map(|p| p.distance(root)).fold(0.0f32, |a, b| if b <= a { a } else { b });
        (farthest / LENGTH - 1.0).max(0.0)
    };
    let exploded = both(&stiff, 0.0, &far);
    out.push(finding(
        "frames of half a second, a spring of 5 Hz",
        "largest distance from the root minus the guide's length, in guide lengths",
        exploded,
        0.01,
        1.0,
    ));

    let sway = |time_s: f32| Vec3::X * (0.3 * libm::sinf(TAU * 0.7 * time_s));
    let at = |fps: f32| HangingString { points: 16, fps, root: &sway, ..base };
    let ends = |motion: Motion| motion.last().map_or_else(Vec::new, |(_, places)| places.clone());
    let apart = |a: &[Vec3], b: &[Vec3]| {
        let off = a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0f32, |a, b| if b <= a { a } else { b });
        f64::from(off / LENGTH)
    };
    let spread = |run: &dyn Fn(&HangingString<'_>) -> Motion| {
        let [few, some, many] = [30.0, 60.0, 144.0].map(|fps| ends(run(&at(fps))));
        apart(&few, &many).max(apart(&few, &some)).max(apart(&some, &many))
    };
    let rates = (spread(&|drive| drive.printed()), spread(&|drive| drive.ours()));
    out.push(finding(
        "5 s at 30, 60 and 144 frames per second",
        "largest distance between corresponding points at two frame rates, in guide lengths",
        rates,
        0.03,
        0.1,
    ));

    // A head and a neck move through the string.
    let body = |time_s: f32| {
        let x = -0.6 + 0.8 * time_s;
        let ball = |place: Vec3, radius_m: f32| Capsule { from: place, to: place, radius_m };
        vec![ball(Vec3::new(x, -0.12, 0.01), 0.08), ball(Vec3::new(x + 0.02, -0.2, 0.01), 0.06)]
    };
    let inside = |time_s: f32, places: &[Vec3]| {
        let of =
            |ball: &Capsule| places.iter().map(|p| 1.0 - p.distance(ball.from) / ball.radius_m).fold(0.0, f32::max);
        body(time_s).iter().map(of).fold(0.0, f32::max)
    };
    let pushed = both(&HangingString { points: 16, seconds: 2.0, spheres: &body, ..base }, 0.0, &inside);
    out.push(finding(
        "a head and a neck move through the hair",
        "greatest penetration, as a share of the sphere's radius",
        pushed,
        0.02,
        0.05,
    ));

    let jump = |time_s: f32| Vec3::X * if time_s > 0.5 { 100.0 } else { 0.0 };
    let jumped =
        both(&HangingString { points: 16, seconds: 2.0, root: &jump, ..base }, 0.0, &|_, places| stretch(places));
    out.push(finding("a root that jumps 100 m without a reset of the motion", longer, jumped, 0.01, 100.0));
    Ok(out)
}
