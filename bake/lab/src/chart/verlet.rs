//! Topic `verlet`: error and cost of simulated guided hair, compared with its equations ([`TrueGuide`]). Methods differ
//! in how they enforce the lengths of the pieces.
//!
//! Each method moves the same guides through the same frames of a sixtieth of a second. The runtime's solver is
//! measured with several numbers of steps, and of solves for the tensions. The methods from the literature use the
//! runtime's forces, whose springs are implicit, so that only the enforcement of lengths differs. The published form
//! has its own forces.
//!
//! The scenes keep hair taut. Slack hair whips: a rounding error changes its motion, so the truth would be arbitrary.

use super::{Cell, Panel};
use crate::stability::hair_motion::{PrintedStep, PrintedString, sweep};
use crate::truth::{TrueGuide, TrueMotion};
use glam::{DMat3, DVec3, Mat3, Quat, Vec3};
use pelage_formats::GroupMotion;
use pelage_formats::meaning::hair_motion::{
    Frame, GRAVITY, GroomedGuide, Particle, RootFrame, Solver, Springs, Wind, gravity_compensation,
};
use std::f64::consts::TAU;

/// Numbers of points per guide.
pub const POINTS: [usize; 3] = [7, 16, 36];
/// Approximate length of a guide, metres.
const LENGTH_M: f32 = 0.3;
/// Frames per second.
const FPS: u32 = 60;
/// Duration of each scene, seconds.
pub const SECONDS: u32 = 3;
/// Accepted change of the truth when its steps are halved, in lengths of the guide.
const TRUTH_TOLERANCE: f64 = 1e-5;
/// Damping ratio of the springs that pull towards the groomed position; 1 is critical damping.
const DAMPED: f32 = 0.3;
/// Fraction of the speed lost by length corrections that is restored, as in Müller 2012.
const RESTORED_SPEED: f32 = 0.9;
/// Compliance of a piece, metres per metre per second squared. The weight of a guide that hangs from a piece stretches
/// it by 1e-4 of its length.
const COMPLIANCE: f32 = 1e-8;

/// Columns of the chart.
///
/// * `points`: points per guide. `steps_per_s`: steps per second. `rounds`: mean number of passes over the lengths per
///   step; for the runtime's solver, the pass from root to tip is included.
/// * `rms_percent`: RMS distance of all points but the root from their true positions, in % of the guide's length, over
///   all frames of three scenes. `rms_turn` etc.: the same in one scene. `largest_percent`: largest distance.
/// * `stretch_percent`: largest relative deviation of any piece from its length.
/// * `nanoseconds`: time per guide and simulated second, on one core. `corrections_per_s`: number of times that each
///   piece's length is corrected per simulated second.
/// * `true_steps_per_s`: steps per second of the truth. `true_change_percent`: its change with half as many steps.
pub const COLUMNS: [&str; 13] = [
    "points",
    "steps_per_s",
    "rounds",
    "rms_percent",
    "largest_percent",
    "rms_turn",
    "rms_gallop",
    "rms_gust",
    "stretch_percent",
    "nanoseconds",
    "corrections_per_s",
    "true_steps_per_s",
    "true_change_percent",
];

/// Panels of the chart: one for each number of points, and one over the number of corrections.
pub const PANELS: [Panel; 4] = [
    panel(NANOSECONDS, "7 points: ns per guide and second, one core", "7"),
    panel(NANOSECONDS, "16 points: ns per guide and second, one core", "16"),
    panel(NANOSECONDS, "36 points: ns per guide and second, one core", "36"),
    panel("corrections_per_s", "16 points: length corrections per segment and second", "16"),
];

const NANOSECONDS: &str = "nanoseconds";

const fn panel(cost: &'static str, cost_label: &'static str, points: &'static str) -> Panel {
    let error_label = "RMS distance from the truth, % of the guide's length";
    Panel { cost, cost_label, error: "rms_percent", error_label, only: Some(("points", points)) }
}

/// Motion that drives a guide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scene {
    /// Head that turns to the side within 0.4 s and back.
    Turn,
    /// Root that moves up and down, as in a gallop.
    Gallop,
    /// Wind that rises and falls.
    Gust,
}

/// Returns a smooth step from 0 to 1 within `takes` seconds from `from` on. Its slope and curvature are 0 at both ends.
fn eased(time_s: f64, from: f64, takes: f64) -> f64 {
    let t = ((time_s - from) / takes).clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

impl Scene {
    /// All scenes.
    pub const ALL: [Self; 3] = [Self::Turn, Self::Gallop, Self::Gust];

    /// Returns the root's position and frame at a time in seconds.
    pub fn root_at(self, time_s: f64) -> (DVec3, DMat3) {
        match self {
            Self::Turn => {
                let turn = DMat3::from_rotation_y(1.2 * (eased(time_s, 0.2, 0.4) - eased(time_s, 1.4, 0.4)));
                (turn * DVec3::new(0.0, 0.0, -0.1), turn)
            }
            Self::Gallop => {
                let turns = TAU * 2.2 * time_s;
                let swells = eased(time_s, 0.0, 0.5);
                let nod = DMat3::from_rotation_x(0.15 * swells * (turns + 0.5).sin());
                (DVec3::new(0.0, 0.02 * swells * turns.sin(), 0.0), nod)
            }
            Self::Gust => (DVec3::ZERO, DMat3::IDENTITY),
        }
    }

    /// Returns the root's position and frame in single precision, as the renderer's type.
    fn rooted(self, time_s: f64) -> RootFrame {
        let (root, frame) = self.root_at(time_s);
        RootFrame { root: root.as_vec3(), frame: frame.as_mat3() }
    }

    /// Returns the wind of the scene.
    fn wind(self) -> Wind {
        if self == Self::Gust {
            Wind { velocity: Vec3::new(4.0, 0.0, 1.5), gust: 0.5, gust_s: 1.2, ..Wind::default() }
        } else {
            Wind::default()
        }
    }

    /// Returns the velocity of the air at a time and position.
    fn air(self, time_s: f32, place: Vec3) -> Vec3 {
        self.wind().at(place, time_s)
    }
}

/// Method of moving a guide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionForm {
    /// The runtime's [`Solver`].
    Ours(Solver),
    /// Separate correction of each piece from root to tip, several times per step (Jakobsen 2001).
    Sweeps {
        /// Steps per second.
        steps_per_s: u32,
        /// Sweeps per step.
        sweeps: u32,
    },
    /// Follow the leader: each point is moved to the correct distance from the previous one, and part of the speed lost
    /// by that is restored (Müller 2012).
    Leader {
        /// Steps per second.
        steps_per_s: u32,
    },
    /// Compliant pieces, each corrected once per step (Macklin 2016 and 2019: small steps instead of many iterations).
    Yielding {
        /// Steps per second.
        steps_per_s: u32,
    },
    /// Published method of Nalu, with one step per frame.
    Printed {
        /// Passes over all length constraints per step.
        sweeps: u32,
    },
    /// Truth for a root that moves straight between frames: the least error of any method that knows only frames.
    Straight,
}

/// Parameters of one measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct VerletConfiguration {
    /// Name of the varied setting.
    pub series: &'static str,
    /// Short value of the varied setting.
    pub label: String,
    /// Points of the guide.
    pub points: usize,
    /// Method of moving the guide.
    pub form: MotionForm,
    /// Whether this is what the runtime does.
    pub default: bool,
}

/// Lists what to measure for each of [`POINTS`], the runtime's default first.
pub fn configurations() -> Vec<VerletConfiguration> {
    let ours = Solver::default();
    let mut forms = vec![("as the runtime does", String::new(), MotionForm::Ours(ours))];
    for steps in [60u16, 240, 480] {
        let solver = Solver { steps_per_s: steps.into(), ..ours };
        forms.push(("ours, steps/s", steps.to_string(), MotionForm::Ours(solver)));
    }
    for solved in [1, 2, 3, 6] {
        // A tolerance of 0 forces exactly `solved` solves per step.
        let solver = Solver { solved, within: 0.0, ..ours };
        forms.push(("ours, solves per step", solved.to_string(), MotionForm::Ours(solver)));
    }
    for sweeps in [1, 2, 4, 8, 16, 32] {
        forms.push(("sweeps per step", sweeps.to_string(), MotionForm::Sweeps { steps_per_s: 120, sweeps }));
    }
    for steps_per_s in [60, 120, 240, 480] {
        forms.push(("follow the leader, steps/s", steps_per_s.to_string(), MotionForm::Leader { steps_per_s }));
    }
    for steps_per_s in [120, 240, 480, 960, 1920] {
        forms.push(("XPBD, steps/s", steps_per_s.to_string(), MotionForm::Yielding { steps_per_s }));
    }
    for sweeps in [1, 4, 16] {
        forms.push(("published form, sweeps per frame", sweeps.to_string(), MotionForm::Printed { sweeps }));
    }
    forms.push(("truth, straight between frames", String::new(), MotionForm::Straight));
    let all = POINTS.iter().flat_map(|points| forms.iter().map(move |form| (*points, form)));
    all.map(|(points, (series, label, form))| VerletConfiguration {
        series,
        label: label.clone(),
        points,
        form: *form,
        default: *form == MotionForm::Ours(ours),
    })
    .collect()
}

/// Guide that begins horizontally and curves downwards, with lengths, springs, and the ballast that holds its shape.
#[derive(Clone, Debug)]
pub struct Guide {
    points: Vec<Vec3>,
    ballast: Vec<Vec3>,
    free: Vec<f32>,
    /// Lengths of the pieces, preceded by 0.
    lengths: Vec<f32>,
    springs: Springs,
}

impl Guide {
    /// Creates a guide of `points` points (two or more), with the springs of a group with default settings.
    pub fn new(points: usize) -> Self {
        let place = |k: usize| {
            let t = k as f32 / (points - 1) as f32;
            Vec3::new(0.0, -0.93 * t * t.sqrt(), -0.5 * t) * LENGTH_M
        };
        let points: Vec<Vec3> = (0..points).map(place).collect();
        let pieces = points.windows(2).map(|ends| ends[0].distance(ends[1]));
        let GroupMotion { drag_per_s, shape_hz, bend_hz, friction, .. } = GroupMotion::default();
        Self {
            ballast: gravity_compensation(&points, Mat3::IDENTITY),
            free: vec![1.0; points.len()],
            lengths: std::iter::once(0.0).chain(pieces).collect(),
            springs: Springs { drag_per_s, shape_hz, bend_hz, friction },
            points,
        }
    }

    fn length(&self) -> f32 {
        self.lengths.iter().sum()
    }

    /// Moves the guide through a scene. Returns how often the runtime's solver solved for the tensions, or 0 for other
    /// methods.
    ///
    /// * `at_end`: called with the points relative to the root, at the end of each frame
    pub fn run(&self, form: &MotionForm, scene: Scene, at_end: &mut dyn FnMut(&[Vec3])) -> u32 {
        match *form {
            MotionForm::Ours(solver) => return self.ours(solver, scene, at_end),
            MotionForm::Sweeps { steps_per_s, sweeps } => {
                let hold = |string: &mut UnconstrainedString, h: f32| {
                    (0..sweeps).for_each(|_| sweep(&mut string.places, &self.lengths));
                    string.update_velocities(h);
                };
                self.unconstrained(steps_per_s, scene, &hold, at_end);
            }
            MotionForm::Leader { steps_per_s } => {
                let hold = |string: &mut UnconstrainedString, h: f32| string.follow(&self.lengths, h);
                self.unconstrained(steps_per_s, scene, &hold, at_end);
            }
            MotionForm::Yielding { steps_per_s } => {
                let hold = |string: &mut UnconstrainedString, h: f32| {
                    string.yielding(&self.lengths, h);
                    string.update_velocities(h);
                };
                self.unconstrained(steps_per_s, scene, &hold, at_end);
            }
            MotionForm::Printed { sweeps } => self.printed(sweeps, scene, at_end),
            MotionForm::Straight => {
                for (frame, places) in (1..).zip(self.truth(scene, true).places) {
                    let root = scene.root_at(time_s(frame)).0;
                    at_end(&places.iter().map(|p| (*p - root).as_vec3()).collect::<Vec<_>>());
                }
            }
        }
        0
    }

    fn ours(&self, solver: Solver, scene: Scene, at_end: &mut dyn FnMut(&[Vec3])) -> u32 {
        let mut solved = 0;
        let groomed = GroomedGuide { points: &self.points, ballast: &self.ballast, free: &self.free };
        let mut pearls: Vec<Particle> = scene.rooted(0.0).groomed(&self.points);
        let mut places = self.points.clone();
        let mut before_s = solver.steps(1.0 / FPS as f32).1;
        for number in 1..=FPS * SECONDS {
            let frame = Frame {
                seconds: 1.0 / FPS as f32,
                before_s,
                gravity: Vec3::NEG_Y * GRAVITY,
                wind: scene.wind(),
                time_s: time_s(number) as f32,
                colliders: &[],
            };
            let [before, now] = [number - 1, number].map(|n| scene.rooted(time_s(n)));
            let advanced = solver.advance_frame(&mut pearls, &groomed, &self.springs, &frame, before, now);
            before_s = advanced.step_s;
            solved += advanced.solved;
            places.iter_mut().zip(&pearls).for_each(|(place, pearl)| *place = pearl.place);
            at_end(&places);
        }
        solved
    }

    /// Moves the guide with the runtime's forces, but without its solver. `hold` enforces the lengths at the end of
    /// each step, and receives the step's duration in seconds.
    fn unconstrained(
        &self,
        steps_per_s: u32,
        scene: Scene,
        hold: &dyn Fn(&mut UnconstrainedString, f32),
        at_end: &mut dyn FnMut(&[Vec3]),
    ) {
        let steps = steps_per_s / FPS;
        let h = 1.0 / steps_per_s as f32;
        let mut string = UnconstrainedString::new(&self.points, scene.rooted(0.0));
        let mut places = self.points.clone();
        for number in 1..=FPS * SECONDS {
            let [from, to] = [number - 1, number].map(|n| scene.rooted(time_s(n)));
            for step in 1..=steps {
                let at = |step: u32| from.between(to, step as f32 / steps as f32);
                let now_s = time_s(number) as f32 - (steps - step) as f32 * h;
                string.integrate(self, [at(step - 1), at(step)], h, |place| scene.air(now_s, place));
                hold(&mut string, h);
            }
            places.iter_mut().zip(&string.places).for_each(|(place, found)| *place = *found - to.root);
            at_end(&places);
        }
    }

    /// Moves the guide as in Nalu, with explicit forces and one damping factor for all resistance.
    fn printed(&self, sweeps: u32, scene: Scene, at_end: &mut dyn FnMut(&[Vec3])) {
        let first = scene.rooted(0.0);
        let mut string = PrintedString::new(self.points.iter().map(|p| first.root + first.frame * *p).collect());
        let seconds = 1.0 / FPS as f32;
        let (shape, bend) = (squared_frequency(self.springs.shape_hz), squared_frequency(self.springs.bend_hz));
        let slowed = self.springs.drag_per_s + 2.0 * DAMPED * shape.sqrt();
        let step = PrintedStep {
            seconds,
            lost: 1.0 - libm::expf(-slowed * seconds),
            lengths: &self.lengths,
            sweeps,
            spheres: &[],
        };
        let mut places = self.points.clone();
        for number in 1..=FPS * SECONDS {
            let (now, now_s) = (scene.rooted(time_s(number)), time_s(number) as f32);
            let mut pulled = self.bending_offsets(now.frame, &string.places);
            for (k, pulled) in pulled.iter_mut().enumerate() {
                let place = string.places[k];
                *pulled = *pulled * bend
                    + Vec3::NEG_Y * GRAVITY
                    + now.frame * self.ballast[k]
                    + scene.air(now_s, place) * self.springs.drag_per_s
                    + (now.root + now.frame * self.points[k] - place) * shape;
            }
            string.step(now.root, &pulled, &step);
            places.iter_mut().zip(&string.places).for_each(|(place, found)| *place = *found - now.root);
            at_end(&places);
        }
    }

    /// Returns the vector from each point to the position that it would have if the pieces up to it kept their groomed
    /// shape. The groomed shape of each piece is rotated with the previous piece.
    fn bending_offsets(&self, frame: Mat3, places: &[Vec3]) -> Vec<Vec3> {
        let mut out = vec![Vec3::ZERO; places.len()];
        let mut turn = Quat::IDENTITY;
        for k in 1..places.len() {
            let wanted = turn * (frame * (self.points[k] - self.points[k - 1]));
            let found = places[k] - places[k - 1];
            out[k] = out[k - 1] + wanted - found;
            let (from, to) = (wanted.normalize_or(Vec3::Y), found.normalize_or(Vec3::Y));
            let (across, half) = (from.cross(to), 1.0 + from.dot(to));
            if half > 1e-6 {
                turn = Quat::from_xyzw(across.x, across.y, across.z, half).normalize() * turn;
            }
        }
        out
    }

    /// Returns the true motion through a scene. If `straight`, the root moves in a straight line from frame to frame.
    pub fn truth(&self, scene: Scene, straight: bool) -> TrueMotion {
        let wide = |points: &[Vec3]| points.iter().map(|p| p.as_dvec3()).collect::<Vec<_>>();
        let (points, ballast) = (wide(&self.points), wide(&self.ballast));
        let air = |time_s: f64, place: DVec3| scene.air(time_s as f32, place.as_vec3()).as_dvec3();
        let guide = TrueGuide {
            points: &points,
            ballast: &ballast,
            drag_per_s: self.springs.drag_per_s.into(),
            shape_hz: self.springs.shape_hz.into(),
            bend_hz: self.springs.bend_hz.into(),
            gravity: DVec3::NEG_Y * f64::from(GRAVITY),
            air: &air,
        };
        let way = |time_s: f64| scene.root_at(time_s);
        guide.converged(&way, straight, (FPS * SECONDS, 1.0 / f64::from(FPS)), TRUTH_TOLERANCE)
    }
}

/// Returns the time of a frame's end, seconds.
fn time_s(frame: u32) -> f64 {
    f64::from(frame) / f64::from(FPS)
}

/// Returns the stiffness of a spring of frequency `hz` per unit of mass, 1/s².
fn squared_frequency(hz: f32) -> f32 {
    let omega = std::f32::consts::TAU * hz;
    omega * omega
}

/// String of points without length constraints.
#[derive(Clone, Debug)]
struct UnconstrainedString {
    /// Positions in world space.
    places: Vec<Vec3>,
    velocities: Vec<Vec3>,
    /// Positions at the beginning of the step.
    started: Vec<Vec3>,
}

impl UnconstrainedString {
    fn new(points: &[Vec3], rooted: RootFrame) -> Self {
        let places: Vec<Vec3> = points.iter().map(|p| rooted.root + rooted.frame * *p).collect();
        Self { velocities: vec![Vec3::ZERO; places.len()], started: places.clone(), places }
    }

    /// Moves the points by one step without constraints, while the root moves from one frame to the next.
    fn integrate(&mut self, guide: &Guide, [before, now]: [RootFrame; 2], h: f32, air: impl Fn(Vec3) -> Vec3) {
        let springs = &guide.springs;
        let (shape, bend) = (squared_frequency(springs.shape_hz), squared_frequency(springs.bend_hz));
        let (shape, bend) = (shape / (1.0 + shape * h * h), bend / (1.0 + bend * h * h));
        let kept_of_air = libm::expf(-springs.drag_per_s * h);
        let kept_of_shape = libm::expf(-2.0 * DAMPED * std::f32::consts::TAU * springs.shape_hz * h);
        self.started.clone_from(&self.places);
        let bent = guide.bending_offsets(now.frame, &self.places);
        for (k, bent) in bent.iter().enumerate().skip(1) {
            let place = self.places[k];
            let air = air(place);
            let goal = now.root + now.frame * guide.points[k];
            let with_skin = (goal - before.root - before.frame * guide.points[k]) / h;
            let velocity = air + (self.velocities[k] - air) * kept_of_air;
            let velocity = with_skin + (velocity - with_skin) * kept_of_shape;
            let pulled = Vec3::NEG_Y * GRAVITY
                + now.frame * guide.ballast[k]
                + (goal - place - (now.root - before.root)) * shape
                + *bent * bend;
            self.places[k] = place + velocity * h + pulled * (h * h);
        }
        self.places[0] = now.root;
    }

    /// Computes velocities from the points' displacements during the step.
    fn update_velocities(&mut self, h: f32) {
        for (k, velocity) in self.velocities.iter_mut().enumerate() {
            *velocity = (self.places[k] - self.started[k]) / h;
        }
    }

    fn follow(&mut self, lengths: &[f32], h: f32) {
        let mut moved = vec![Vec3::ZERO; self.places.len() + 1];
        for k in 1..self.places.len() {
            let parent = self.places[k - 1];
            let place = parent + (self.places[k] - parent).normalize_or(Vec3::NEG_Y) * lengths[k];
            moved[k] = place - std::mem::replace(&mut self.places[k], place);
        }
        self.update_velocities(h);
        for (k, velocity) in self.velocities.iter_mut().enumerate() {
            *velocity -= moved[k + 1] * (RESTORED_SPEED / h);
        }
    }

    fn yielding(&mut self, lengths: &[f32], h: f32) {
        let yields = COMPLIANCE / (h * h);
        for (k, wanted) in lengths.iter().enumerate().skip(1) {
            let way = self.places[k] - self.places[k - 1];
            let length = way.length().max(1e-9);
            let masses = if k == 1 { 1.0 } else { 2.0 };
            let off = way * ((length - wanted) / (length * (masses + yields)));
            if k > 1 {
                self.places[k - 1] += off;
            }
            self.places[k] -= off;
        }
    }
}

/// Error of a method in one or several scenes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionDeviation {
    /// Sum of squared distances from the truth in lengths of the guide, and the number of distances.
    squares: f64,
    count: usize,
    /// Largest distance, in lengths of the guide.
    largest: f64,
    /// Largest relative deviation of any piece from its length.
    stretch: f64,
    /// Number of times that the runtime's solver solved for the tensions.
    solved: u32,
}

impl MotionDeviation {
    /// Measures a method against the truth at the ends of frames.
    pub fn of(guide: &Guide, form: &MotionForm, scene: Scene, truth: &[Vec<DVec3>]) -> Self {
        let mut off = Self::default();
        let mut frame = 0;
        let solved = guide.run(form, scene, &mut |places| {
            let found = &truth[frame];
            frame += 1;
            for k in 1..places.len() {
                let away = (places[k].as_dvec3() - (found[k] - found[0])).length() / f64::from(guide.length());
                let stretch = f64::from((places[k].distance(places[k - 1]) / guide.lengths[k] - 1.0).abs());
                off = off.and(Self { squares: away * away, count: 1, largest: away, stretch, solved: 0 });
            }
        });
        Self { solved, ..off }
    }

    /// Combines both errors; NaN is preserved.
    pub fn and(self, other: Self) -> Self {
        let greater = |a: f64, b: f64| if b <= a { a } else { b };
        Self {
            squares: self.squares + other.squares,
            count: self.count + other.count,
            largest: greater(self.largest, other.largest),
            stretch: greater(self.stretch, other.stretch),
            solved: self.solved + other.solved,
        }
    }

    /// Returns the root mean square distance, in lengths of the guide.
    pub fn rms(&self) -> f64 {
        (self.squares / self.count.max(1) as f64).sqrt()
    }
}

impl MotionForm {
    /// Returns the steps per second, and the passes over the lengths per step. `found`: result of all scenes together.
    pub fn effort(&self, found: &MotionDeviation) -> Option<(f64, f64)> {
        Some(match *self {
            // Adds one pass per step: the pass from root to tip that corrects the error left by the tensions.
            Self::Ours(Solver { steps_per_s, .. }) => {
                let steps_per_s = f64::from(steps_per_s);
                let seconds = f64::from(SECONDS * Scene::ALL.len() as u32);
                (steps_per_s, f64::from(found.solved) / (seconds * steps_per_s) + 1.0)
            }
            Self::Sweeps { steps_per_s, sweeps } => (steps_per_s.into(), sweeps.into()),
            Self::Leader { steps_per_s } | Self::Yielding { steps_per_s } => (steps_per_s.into(), 1.0),
            Self::Printed { sweeps } => (FPS.into(), sweeps.into()),
            Self::Straight => return None,
        })
    }
}

/// Returns the cells of a row, in the order of [`COLUMNS`].
///
/// * `off`: errors in each of [`Scene::ALL`]
/// * `nanoseconds`: per guide and simulated second
/// * `truths`: true motions in the same scenes
pub fn cells(
    configuration: &VerletConfiguration,
    off: &[MotionDeviation; 3],
    nanoseconds: Option<f64>,
    truths: &[TrueMotion],
) -> Vec<Cell> {
    let number = |x: Option<f64>| x.map_or(Cell::Empty, Cell::Number);
    let all = off.iter().copied().fold(MotionDeviation::default(), MotionDeviation::and);
    let effort = configuration.form.effort(&all);
    vec![
        Cell::Number(configuration.points as f64),
        number(effort.map(|(steps, _)| steps)),
        number(effort.map(|(_, rounds)| rounds)),
        Cell::Number(100.0 * all.rms()),
        Cell::Number(100.0 * all.largest),
        Cell::Number(100.0 * off[0].rms()),
        Cell::Number(100.0 * off[1].rms()),
        Cell::Number(100.0 * off[2].rms()),
        Cell::Number(100.0 * all.stretch),
        number(nanoseconds),
        number(effort.map(|(steps, rounds)| steps * rounds)),
        Cell::Number(f64::from(truths.iter().map(|truth| truth.steps).max().unwrap_or(0)) * f64::from(FPS)),
        Cell::Number(100.0 * truths.iter().map(|truth| truth.change).fold(0.0, f64::max)),
    ]
}

#[cfg(test)]
#[path = "verlet_tests.rs"]
mod tests;
