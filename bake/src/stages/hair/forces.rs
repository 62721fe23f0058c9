//! The forces that shape a strand, and the particle that follows them.

use super::locks::{Lock, Locks, gathers, heading_into_lock};
use super::styles::StyleForces;
use crate::noise::{along, field, hash, stratified, uniform, vector};
use crate::recipe::HairParams;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Least number of segments of a strand with frizz.
const FRIZZ_SEGMENTS: f32 = 28.0;
/// Segments of a helix's turn: its polyline is then within 4 % of its radius.
const SEGMENTS_PER_TURN: f32 = 12.0;
/// A helix turns at most this far in a segment. Tighter curls are loosened, keeping their radius.
const MAX_TURN_RAD: f32 = PI / 3.0;
const MAX_SEGMENTS: u32 = 192;
/// Bends of frizz along a strand.
const FRIZZ_BENDS: f32 = 9.0;
/// How fast a heading follows the forces, per strand length.
const RELAXATION: f32 = 7.0;

/// Purposes of the random numbers of a strand; the first two are [`stratified`]'s.
#[derive(Clone, Copy)]
enum Draw {
    Length = 2,
    Tilt,
    Phase,
    Hand,
    Brightness,
    Frizz,
    Stray,
}

/// What the seed of underfur is hashed with: any number that no strand has.
const UNDERFUR: u64 = u64::MAX - 4;

/// Grows strands of one kind.
pub(super) struct Grower<'a> {
    params: &'a HairParams,
    forces: StyleForces,
    height: f32,
    segments: u32,
    lean_to: Vec2,
    /// Of what the strands of a coat have in common.
    seed: u64,
    /// Of what each strand of this kind has by itself: roots, lengths, tilts.
    own_seed: u64,
    /// Present where hairs gather.
    locks: Option<&'a Locks>,
    /// The guard hair above underfur, whose locks it joins.
    leader: Option<&'a Grower<'a>>,
}

impl<'a> Grower<'a> {
    /// `height` is the length of the longest strand in widths of the tile; a strand has at most `max_segments` segments.
    pub(super) fn new(params: &'a HairParams, height: f32, max_segments: u32, locks: Option<&'a Locks>) -> Self {
        let forces = StyleForces::of(params.style);
        let frizz = if params.frizz > 0.0 { FRIZZ_SEGMENTS } else { 0.0 };
        let helix = if forces.helix { height / turn_length(params) * SEGMENTS_PER_TURN } else { 0.0 };
        let wanted = forces.segments.max(frizz).max(helix).ceil() as u32;
        let segments = wanted.min(MAX_SEGMENTS).min(max_segments.max(8));
        let azimuth = params.lean_direction_deg.to_radians();
        Self {
            params,
            forces,
            height,
            segments,
            lean_to: Vec2::new(libm::sinf(azimuth), libm::cosf(azimuth)),
            seed: params.seed,
            own_seed: params.seed,
            locks,
            leader: None,
        }
    }

    /// What grows underfur below this guard hair: with roots of its own, along the same flow, in the same locks.
    pub(super) fn under<'b>(&'b self, params: &'b HairParams, height: f32, max_segments: u32) -> Grower<'b> {
        let own_seed = hash(self.seed, UNDERFUR);
        let locks = self.locks.filter(|_| gathers(params));
        Grower { own_seed, leader: Some(self), ..Grower::new(params, height, max_segments, locks) }
    }

    pub(super) fn params(&self) -> &'a HairParams {
        self.params
    }

    pub(super) fn segments(&self) -> usize {
        self.segments as usize
    }

    /// In -1..1.
    pub(super) fn brightness(&self, strand: u32) -> f32 {
        let own = 2.0 * self.draw(strand, Draw::Brightness) - 1.0;
        match self.locks {
            // Hairs that stick together look alike, wet ones more so.
            Some(locks) => {
                let [together, per_clump] = self.forces.lock_brightness;
                let together = together + per_clump * self.params.dry_clump;
                (1.0 - together) * own + together * locks.brightness(locks.of(self.root(strand)).index)
            }
            None => own,
        }
    }

    /// In -1..1: how far a strand's band lies nearer its root or its tip than others'.
    pub(super) fn stray(&self, strand: u32) -> f32 {
        2.0 * self.draw(strand, Draw::Stray) - 1.0
    }

    fn draw(&self, strand: u32, what: Draw) -> f32 {
        uniform(self.own_seed, u64::from(strand) << 8 | what as u64)
    }

    fn root(&self, strand: u32) -> Vec2 {
        stratified(self.own_seed, strand, self.params.density)
    }

    /// Arc length, widths of the tile. The longest are the rarest.
    pub(super) fn length(&self, strand: u32) -> f32 {
        let x = self.draw(strand, Draw::Length);
        let share = 1.0 - self.params.length_variation * (1.0 - x * x.sqrt());
        self.height * share.max(0.01)
    }

    /// Where a strand points at `t` (0 root, 1 tip) of its length if only lean acts: upright at the root, bending over to the
    /// tip; with a lean near 1 the root is combed over as well.
    fn lean(&self, t: f32) -> Vec3 {
        let StyleForces { lean: [least, span], root_deg, tip_deg, .. } = self.forces;
        let lean = least + span * self.params.lean;
        let root = root_deg[0] + root_deg[1] * lean + root_deg[2] * (lean * lean);
        let tip = tip_deg[0] + tip_deg[1] * lean;
        let angle = (root + (tip - root) * t).to_radians();
        (self.lean_to * libm::sinf(angle)).extend(libm::cosf(angle))
    }

    /// How fast a heading follows over a step of a strand of `length`: the exact solution of the relaxation, which never
    /// overshoots, however stiff or long the step.
    fn follow(step: f32, length: f32) -> f32 {
        -libm::expm1f(-RELAXATION * step / length)
    }

    /// Fills `points` with strand number `strand`, root first.
    pub(super) fn grow(&self, strand: u32, points: &mut [Vec3]) {
        let p = self.params;
        let segments = points.len().saturating_sub(1).max(1);
        let length = self.length(strand);
        let step = length / segments as f32;
        let follow = Self::follow(step, length);
        let tilt = vector(self.own_seed, u64::from(strand) << 8 | Draw::Tilt as u64) * self.forces.disorder;
        let frizz_seed = hash(self.own_seed, u64::from(strand) << 8 | Draw::Frizz as u64);
        let root = self.root(strand);
        let mut position = root.extend(0.0);
        let leader = self.leader.unwrap_or(self);
        let mut axis_of_lock = self.locks.map(|locks| LockAxis::new(leader, locks, locks.of(root)));
        let mut phase = self.curl_phase(strand, position);
        let hand = if self.draw(strand, Draw::Hand) < 0.15 { -1.0 } else { 1.0 };
        let mut axis = (self.lean(0.0) + tilt).normalize_or(Vec3::Z);
        for (j, point) in points.iter_mut().enumerate() {
            *point = position;
            let t = (j as f32 + 0.5) / segments as f32;
            let target = match &mut axis_of_lock {
                Some(lock) => {
                    let left = (segments - j.min(segments - 1)) as f32 * step;
                    let into_lock = heading_into_lock(position, lock.position, lock.heading, left);
                    let target = if self.forces.wet {
                        (lock.target + tilt).lerp(into_lock, p.clump)
                    } else {
                        // Dry hairs stand by themselves at their roots; it is their tips that gather.
                        (self.lean(t) + tilt + self.style_force(position, t)).lerp(into_lock, p.dry_clump * t)
                    };
                    lock.advance(leader, step);
                    target
                }
                None => self.lean(t) + tilt + self.style_force(position, t),
            };
            axis = (axis + (target - axis) * follow).normalize_or(axis);
            let mut heading = axis;
            if self.forces.helix {
                // The radius grows over the first third, so that the strand leaves the skin at its root.
                let radius = p.curl_radius * (3.0 * t).min(1.0);
                let rate = (TAU / turn_length(p)).min(MAX_TURN_RAD / step);
                let sin = (radius * rate).min(0.98);
                let frame = Quat::from_rotation_arc(Vec3::Z, axis);
                let around = Vec3::new(libm::cosf(phase), libm::sinf(phase), 0.0);
                heading = axis * (1.0 - sin * sin).sqrt() + frame * around * sin;
                phase += hand * rate * step;
            }
            if p.frizz > 0.0 {
                heading += along(frizz_seed, t * FRIZZ_BENDS) * (p.frizz * 1.2 * self.forces.frizz);
            }
            let heading = keep_above_skin(heading.normalize_or(axis), position.z, step, j == 0, self.lean_to);
            position += heading * step;
        }
    }

    /// Neighbouring curls turn together, as in a lock, with a little disorder.
    fn curl_phase(&self, strand: u32, root: Vec3) -> f32 {
        let together = field(hash(self.seed, u64::MAX), root, 3).x * TAU;
        together + (self.draw(strand, Draw::Phase) - 0.5) * 1.4
    }

    fn style_force(&self, position: Vec3, t: f32) -> Vec3 {
        let StyleForces { fields, field_scale, field_growth: [at_root, growth], droop, .. } = self.forces;
        let seeds = (1..).map(|n| hash(self.seed, u64::MAX - n));
        let noise = fields.iter().zip(seeds).map(|((cells, strength), seed)| field(seed, position, *cells) * *strength);
        noise.fold(Vec3::ZERO, |sum, push| sum + push) * field_scale * (at_root + growth * t)
            - Vec3::Z * (droop * t * t)
    }
}

/// The curve that the strands of a lock gather on, followed in step with one of them.
struct LockAxis {
    position: Vec3,
    /// Unit length.
    heading: Vec3,
    /// What the heading relaxes towards.
    target: Vec3,
    tilt: Vec3,
    /// Arc length so far.
    along: f32,
}

impl LockAxis {
    fn new(grower: &Grower<'_>, locks: &Locks, lock: Lock) -> Self {
        let tilt = locks.tilt(lock.index) * Vec3::new(0.35, 0.35, 0.1) * grower.forces.lock_disorder;
        let target = grower.lean(0.0) + tilt;
        let heading = target.normalize_or(Vec3::Z);
        Self { position: lock.center.extend(0.0), heading, target, tilt, along: 0.0 }
    }

    /// The axis bends as the longest strand does, so that all strands of the lock share one curve, whatever their lengths.
    fn advance(&mut self, grower: &Grower<'_>, step: f32) {
        let first = self.along == 0.0;
        let heading = keep_above_skin(self.heading, self.position.z, step, first, grower.lean_to);
        self.position += heading * step;
        self.along += step;
        self.target = grower.lean((self.along / grower.height).min(1.0)) + self.tilt;
        let follow = Grower::follow(step, grower.height);
        self.heading = (self.heading + (self.target - self.heading) * follow).normalize_or(self.heading);
    }
}

/// Arc length of one turn of the helix, widths of the tile.
fn turn_length(params: &HairParams) -> f32 {
    let around = TAU * params.curl_radius;
    (params.curl_pitch * params.curl_pitch + around * around).sqrt()
}

/// Turns a unit `heading` up just so far that a step from height `h` ends on the skin at the lowest; the first step leaves it.
fn keep_above_skin(heading: Vec3, h: f32, step: f32, first: bool, lean_to: Vec2) -> Vec3 {
    let least = if first { 0.2 } else { (-h / step).clamp(-1.0, 0.0) };
    if heading.z >= least {
        return heading;
    }
    let flat = heading.truncate().normalize_or(lean_to);
    (flat * (1.0 - least * least).max(0.0).sqrt()).extend(least)
}
