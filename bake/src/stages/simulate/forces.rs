//! Forces that shape a strand, and the particle that follows them.

use super::locks::{Lock, Locks, forms_locks, heading_into_lock};
use super::styles::StyleForces;
use crate::noise::{hash, noise_1d, noise_in_tile, stratified, uniform, vector};
use crate::recipe::HairParams;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Minimum number of segments of a strand with frizz.
const FRIZZ_SEGMENTS: f32 = 28.0;
/// Segments per turn of a helix. The polyline deviates from the helix by at most 4 % of the radius.
const SEGMENTS_PER_TURN: f32 = 12.0;
/// Maximum turn of a helix in one segment, radians. Tighter curls are loosened and keep their radius.
const MAX_TURN_RAD: f32 = PI / 3.0;
const MAX_SEGMENTS: u32 = 192;
/// Number of frizz bends along a strand.
const FRIZZ_BENDS: f32 = 9.0;
/// Rate at which a heading relaxes towards the forces, per length of the strand.
const RELAXATION: f32 = 7.0;

/// Indices of a strand's random numbers, one per purpose. The first two indices are used by [`stratified`].
#[derive(Clone, Copy)]
enum RandomUse {
    Length = 2,
    Tilt,
    Phase,
    Hand,
    Brightness,
    Frizz,
    Stray,
}

/// Value that the seed is hashed with for underfur. It is not the index of any strand.
const UNDERFUR: u64 = u64::MAX - 4;

/// Grows strands of one kind.
pub(super) struct Grower<'a> {
    params: &'a HairParams,
    forces: StyleForces,
    height: f32,
    segments: u32,
    lean_to: Vec2,
    /// Seed for everything that the strands of the tile share.
    seed: u64,
    /// Seed for the individual values of each strand of this kind: root, length and tilt.
    own_seed: u64,
    /// Locks of the tile; `None` if hairs do not gather in locks.
    locks: Option<&'a Locks>,
    /// Grower of the guard hair whose locks the underfur joins; `None` for guard hair.
    leader: Option<&'a Grower<'a>>,
}

impl<'a> Grower<'a> {
    /// Creates a grower. `height`: length of the longest strand, tile widths; `max_segments`: maximum number of
    /// segments per strand.
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

    /// Returns the grower of the underfur below this guard hair. The underfur has its own roots, but the same flow and
    /// the same locks.
    pub(super) fn underfur<'b>(&'b self, params: &'b HairParams, height: f32, max_segments: u32) -> Grower<'b> {
        let own_seed = hash(self.seed, UNDERFUR);
        let locks = self.locks.filter(|_| forms_locks(params));
        Grower { own_seed, leader: Some(self), ..Grower::new(params, height, max_segments, locks) }
    }

    pub(super) fn params(&self) -> &'a HairParams {
        self.params
    }

    pub(super) fn segments(&self) -> usize {
        self.segments as usize
    }

    /// Returns the brightness of a strand, in -1..1.
    pub(super) fn brightness(&self, strand: u32) -> f32 {
        let own = 2.0 * self.draw(strand, RandomUse::Brightness) - 1.0;
        match self.locks {
            // Hairs of one lock look alike, and wet hairs even more so.
            Some(locks) => {
                let [together, per_clump] = self.forces.lock_brightness;
                let together = together + per_clump * self.params.dry_clump;
                (1.0 - together) * own + together * locks.brightness(locks.lock_at(self.root(strand)).index)
            }
            None => own,
        }
    }

    /// Returns the offset of a strand's colour band, in -1..1. Negative values are towards the root, positive ones
    /// towards the tip.
    pub(super) fn band_offset(&self, strand: u32) -> f32 {
        2.0 * self.draw(strand, RandomUse::Stray) - 1.0
    }

    fn draw(&self, strand: u32, what: RandomUse) -> f32 {
        uniform(self.own_seed, u64::from(strand) << 8 | what as u64)
    }

    fn root(&self, strand: u32) -> Vec2 {
        stratified(self.own_seed, strand, self.params.density)
    }

    /// Returns the arc length of a strand, in tile widths. The longest strands are the rarest.
    pub(super) fn length(&self, strand: u32) -> f32 {
        let x = self.draw(strand, RandomUse::Length);
        let share = 1.0 - self.params.length_variation * (1.0 - x * x.sqrt());
        self.height * share.max(0.01)
    }

    /// Returns the direction of a strand under lean alone, at share `t` of its length (0 root, 1 tip). It is upright at
    /// the root and bends towards the tip. With a lean near 1, the root is combed over as well.
    fn lean(&self, t: f32) -> Vec3 {
        let StyleForces { lean: [least, span], root_deg, tip_deg, .. } = self.forces;
        let lean = least + span * self.params.lean;
        let root = root_deg[0] + root_deg[1] * lean + root_deg[2] * (lean * lean);
        let tip = tip_deg[0] + tip_deg[1] * lean;
        let angle = (root + (tip - root) * t).to_radians();
        (self.lean_to * libm::sinf(angle)).extend(libm::cosf(angle))
    }

    /// Returns the share by which a heading approaches its target in one step. `length` is the length of the strand.
    /// The share is the exact solution of the relaxation and never overshoots, however long the step.
    fn relaxation_factor(step: f32, length: f32) -> f32 {
        -libm::expm1f(-RELAXATION * step / length)
    }

    /// Fills `points` with the points of strand `strand`, root first.
    pub(super) fn grow(&self, strand: u32, points: &mut [Vec3]) {
        let p = self.params;
        let segments = points.len().saturating_sub(1).max(1);
        let length = self.length(strand);
        let step = length / segments as f32;
        let follow = Self::relaxation_factor(step, length);
        let tilt = vector(self.own_seed, u64::from(strand) << 8 | RandomUse::Tilt as u64) * self.forces.disorder;
        let frizz_seed = hash(self.own_seed, u64::from(strand) << 8 | RandomUse::Frizz as u64);
        let root = self.root(strand);
        let mut position = root.extend(0.0);
        let leader = self.leader.unwrap_or(self);
        let mut axis_of_lock = self.locks.map(|locks| LockAxis::new(leader, locks, locks.lock_at(root)));
        let mut phase = self.curl_phase(strand, position);
        let hand = if self.draw(strand, RandomUse::Hand) < 0.15 { -1.0 } else { 1.0 };
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
                        // Dry hairs are separate at their roots; only the tips gather in locks.
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
                // The radius increases over the first third, so that the strand leaves the mesh surface at its root.
                let radius = p.curl_radius * (3.0 * t).min(1.0);
                let rate = (TAU / turn_length(p)).min(MAX_TURN_RAD / step);
                let sin = (radius * rate).min(0.98);
                let frame = Quat::from_rotation_arc(Vec3::Z, axis);
                let around = Vec3::new(libm::cosf(phase), libm::sinf(phase), 0.0);
                heading = axis * (1.0 - sin * sin).sqrt() + frame * around * sin;
                phase += hand * rate * step;
            }
            if p.frizz > 0.0 {
                heading += noise_1d(frizz_seed, t * FRIZZ_BENDS) * (p.frizz * 1.2 * self.forces.frizz);
            }
            let heading = keep_above_skin(heading.normalize_or(axis), position.z, step, j == 0, self.lean_to);
            position += heading * step;
        }
    }

    /// Returns the phase of a curl, radians. Neighbouring curls turn together, as in a lock, with a little disorder.
    fn curl_phase(&self, strand: u32, root: Vec3) -> f32 {
        let together = noise_in_tile(hash(self.seed, u64::MAX), root, 3).x * TAU;
        together + (self.draw(strand, RandomUse::Phase) - 0.5) * 1.4
    }

    fn style_force(&self, position: Vec3, t: f32) -> Vec3 {
        let StyleForces { fields, field_scale, field_growth: [at_root, growth], droop, .. } = self.forces;
        let seeds = (1..).map(|n| hash(self.seed, u64::MAX - n));
        let noise =
            fields.iter().zip(seeds).map(|((cells, strength), seed)| noise_in_tile(seed, position, *cells) * *strength);
        noise.fold(Vec3::ZERO, |sum, push| sum + push) * field_scale * (at_root + growth * t)
            - Vec3::Z * (droop * t * t)
    }
}

/// Curve on which the strands of a lock gather. It advances step by step together with one of the strands.
struct LockAxis {
    position: Vec3,
    /// Unit vector.
    heading: Vec3,
    /// Vector that the heading relaxes towards.
    target: Vec3,
    tilt: Vec3,
    /// Arc length so far, tile widths.
    along: f32,
}

impl LockAxis {
    fn new(grower: &Grower<'_>, locks: &Locks, lock: Lock) -> Self {
        let tilt = locks.tilt(lock.index) * Vec3::new(0.35, 0.35, 0.1) * grower.forces.lock_disorder;
        let target = grower.lean(0.0) + tilt;
        let heading = target.normalize_or(Vec3::Z);
        Self { position: lock.center.extend(0.0), heading, target, tilt, along: 0.0 }
    }

    /// Advances by one step. The axis bends as the longest strand does. So all strands of the lock share one curve,
    /// whatever their lengths.
    fn advance(&mut self, grower: &Grower<'_>, step: f32) {
        let first = self.along == 0.0;
        let heading = keep_above_skin(self.heading, self.position.z, step, first, grower.lean_to);
        self.position += heading * step;
        self.along += step;
        self.target = grower.lean((self.along / grower.height).min(1.0)) + self.tilt;
        let follow = Grower::relaxation_factor(step, grower.height);
        self.heading = (self.heading + (self.target - self.heading) * follow).normalize_or(self.heading);
    }
}

/// Returns the arc length of one turn of the helix, in tile widths.
fn turn_length(params: &HairParams) -> f32 {
    let around = TAU * params.curl_radius;
    (params.curl_pitch * params.curl_pitch + around * around).sqrt()
}

/// Turns a unit `heading` up just enough that a step from height `h` does not end below the mesh surface. The first
/// step always rises.
fn keep_above_skin(heading: Vec3, h: f32, step: f32, first: bool, lean_to: Vec2) -> Vec3 {
    let least = if first { 0.2 } else { (-h / step).clamp(-1.0, 0.0) };
    if heading.z >= least {
        return heading;
    }
    let flat = heading.truncate().normalize_or(lean_to);
    (flat * (1.0 - least * least).max(0.0).sqrt()).extend(least)
}
