//! The forces that shape a strand, and the particle that follows them.

use super::noise::{along, field, hash, uniform, vector};
use crate::recipe::{HairParams, Style};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Segments of a strand that bends smoothly.
const SMOOTH_SEGMENTS: f32 = 14.0;
/// Segments of a strand with noise in it.
const NOISY_SEGMENTS: f32 = 28.0;
/// Segments of a helix's turn: its polyline is then within 4 % of its radius.
const SEGMENTS_PER_TURN: f32 = 12.0;
/// A helix turns at most this far in a segment. Tighter curls are loosened, keeping their radius.
const MAX_TURN_RAD: f32 = PI / 3.0;
const MAX_SEGMENTS: u32 = 192;
/// Bends of frizz along a strand.
const FRIZZ_BENDS: f32 = 9.0;
/// How fast a heading follows the forces, per strand length.
const RELAXATION: f32 = 7.0;

/// Purposes of the random numbers of a strand.
#[derive(Clone, Copy)]
enum Draw {
    RootU,
    RootV,
    Length,
    Tilt,
    Phase,
    Hand,
    Brightness,
    Frizz,
}

/// Grows strands of one recipe.
pub(super) struct Grower<'a> {
    params: &'a HairParams,
    height: f32,
    segments: u32,
    rows: u32,
    lean_to: Vec2,
    seed: u64,
}

impl<'a> Grower<'a> {
    /// `height` is the length of the longest strand in widths of the tile; a strand has at most `max_segments` segments.
    pub(super) fn new(params: &'a HairParams, height: f32, max_segments: u32) -> Self {
        let noise = if params.frizz > 0.0 { NOISY_SEGMENTS } else { 0.0 };
        let wanted = match params.style {
            Style::Straight => SMOOTH_SEGMENTS,
            Style::Messy => NOISY_SEGMENTS,
            Style::Curly => height / turn_length(params) * SEGMENTS_PER_TURN,
        };
        let segments =
            (wanted.max(noise).max(SMOOTH_SEGMENTS).ceil() as u32).min(MAX_SEGMENTS).min(max_segments.max(8));
        let azimuth = params.lean_direction_deg.to_radians();
        Self {
            params,
            height,
            segments,
            rows: (f64::from(params.density).sqrt().round() as u32).max(1),
            lean_to: Vec2::new(libm::sinf(azimuth), libm::cosf(azimuth)),
            seed: params.seed,
        }
    }

    pub(super) fn segments(&self) -> usize {
        self.segments as usize
    }

    /// In -1..1.
    pub(super) fn brightness(&self, strand: u32) -> f32 {
        2.0 * self.draw(strand, Draw::Brightness) - 1.0
    }

    fn draw(&self, strand: u32, what: Draw) -> f32 {
        uniform(self.seed, u64::from(strand) << 8 | what as u64)
    }

    /// Roots are stratified: the tile is cut into rows of cells of equal area, and each cell has one root anywhere in it.
    /// Plain random roots would leave bald spots.
    fn root(&self, strand: u32) -> Vec3 {
        let (n, rows) = (u64::from(self.params.density), u64::from(self.rows));
        let row = u64::from(strand) * rows / n;
        let first = (row * n).div_ceil(rows);
        let cells = ((row + 1) * n).div_ceil(rows) - first;
        let u = ((u64::from(strand) - first) as f32 + self.draw(strand, Draw::RootU)) / cells as f32;
        let v = (row as f32 + self.draw(strand, Draw::RootV)) / rows as f32;
        Vec3::new(u, v, 0.0)
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
        let lean = self.params.lean;
        let (root, tip) = (lean * lean * 65.0, lean * 88.0);
        let angle = (root + (tip - root) * t).to_radians();
        (self.lean_to * libm::sinf(angle)).extend(libm::cosf(angle))
    }

    /// Fills `points` with strand number `strand`, root first.
    pub(super) fn grow(&self, strand: u32, points: &mut [Vec3]) {
        let p = self.params;
        let segments = points.len().saturating_sub(1).max(1);
        let step = self.length(strand) / segments as f32;
        // Exact solution of the relaxation over one step: never overshoots, however stiff or long the step.
        let follow = -libm::expm1f(-RELAXATION / segments as f32);
        let tilt = vector(self.seed, u64::from(strand) << 8 | Draw::Tilt as u64);
        let tilt = match p.style {
            Style::Messy => tilt * 0.4,
            Style::Straight | Style::Curly => tilt * 0.12,
        };
        let frizz_seed = hash(self.seed, u64::from(strand) << 8 | Draw::Frizz as u64);
        let mut position = self.root(strand);
        let mut phase = self.curl_phase(strand, position);
        let hand = if self.draw(strand, Draw::Hand) < 0.15 { -1.0 } else { 1.0 };
        let mut axis = (self.lean(0.0) + tilt).normalize_or(Vec3::Z);
        for (j, point) in points.iter_mut().enumerate() {
            *point = position;
            let t = (j as f32 + 0.5) / segments as f32;
            let target = self.lean(t) + tilt + self.style_force(position, t);
            axis = (axis + (target - axis) * follow).normalize_or(axis);
            let mut heading = axis;
            if p.style == Style::Curly {
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
                heading += along(frizz_seed, t * FRIZZ_BENDS) * (p.frizz * 1.2);
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
        match self.params.style {
            Style::Straight | Style::Curly => Vec3::ZERO,
            Style::Messy => {
                let wide = field(hash(self.seed, u64::MAX - 1), position, 4) * 1.5;
                let narrow = field(hash(self.seed, u64::MAX - 2), position, 9) * 1.0;
                // Sideways more than up and down: hair that points into the skin looks broken. Long hair droops.
                (wide + narrow) * Vec3::new(1.0, 1.0, 0.4) * (0.35 + 0.65 * t) - Vec3::Z * (0.3 * t * t)
            }
        }
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
