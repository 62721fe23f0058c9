//! Small dark spots: eyes, noses, hooves. Each is painted with one stroke of full ink along its longer axis.

use super::canvas::{Canvas, Place};
use glam::Vec3;
use pelage_formats::StrokeKind;

/// Darkness from which a surface belongs to a spot, and the same for eyes by name.
const DARK: f32 = 0.86;
const DARK_EYE: f32 = 0.55;
/// Area of a spot as a share of the body's.
const AREA: [f32; 2] = [0.00006, 0.012];
/// Largest area of an eye.
const EYE_AREA: f32 = 0.004;
/// Largest ratio of length to width.
const LONGEST: f32 = 4.5;
/// Share of the bordering surface that must be paler.
const APART: f32 = 0.12;

/// Spot: its stroke from end to end, and the half width at each place.
pub(super) struct Spot {
    pub(super) kind: StrokeKind,
    /// Colour of a mineral pigment, linear RGB.
    pub(super) pigment: Option<[f32; 3]>,
    pub(super) places: Vec<Place>,
    pub(super) half_widths: Vec<f32>,
    pub(super) vertices: Vec<u32>,
}

/// Mean normal, as a vector, up to which a spot is a whole ball.
const BALL: f32 = 0.45;

/// Returns the direction in which a ball looks out of the body, and the radius of its visible part: the distance of the
/// lids from its axis. `None` if no other surface is near.
fn opening(canvas: &Canvas, ball: &[u32], center: Vec3) -> Option<(Vec3, f32)> {
    let radius = ball.iter().map(|p| canvas.positions[*p as usize].distance(center)).fold(0.0, f32::max);
    let piece = canvas.skin.pieces[ball[0] as usize];
    let near: Vec<usize> = (0..canvas.positions.len())
        .filter(|p| canvas.skin.pieces[*p] != piece && canvas.positions[*p].distance(center) < 1.9 * radius)
        .collect();
    let normal = near.iter().map(|p| canvas.skin.normals[*p] * canvas.skin.areas[*p]).sum::<Vec3>().try_normalize()?;
    let mut lids: Vec<f32> = near
        .iter()
        .map(|p| canvas.positions[*p] - center)
        .filter(|d| d.dot(normal) > 0.0)
        .map(|d| (d - normal * d.dot(normal)).length())
        .collect();
    lids.sort_unstable_by(f32::total_cmp);
    let lid = lids.get(lids.len() / 4).copied().unwrap_or(radius);
    Some((normal, lid.clamp(0.4 * radius, radius)))
}

pub(super) fn spots(canvas: &Canvas, count: usize) -> Vec<Spot> {
    let skin = &canvas.skin;
    let total: f32 = skin.areas.iter().sum::<f32>().max(1e-12);
    let is_dark = |p: usize| canvas.darkness[p] > DARK || canvas.eye[p] && canvas.darkness[p] > DARK_EYE;
    // Patches of mineral colour are spots too, apart from dark ones.
    let class = |p: usize| match (is_dark(p), &canvas.pigment[p]) {
        (true, _) => Some(false),
        (false, pigment) => pigment.map(|_| true),
    };
    let low = canvas.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let high = canvas.positions.iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    let mut seen = vec![false; canvas.positions.len()];
    let mut spots = Vec::new();
    for first in 0..canvas.positions.len() {
        let Some(colored) = class(first).filter(|_| !seen[first]) else { continue };
        let (mut of, mut stack) = (Vec::new(), vec![first as u32]);
        let (mut beside, mut paler) = (0.0, 0.0);
        seen[first] = true;
        while let Some(place) = stack.pop() {
            of.push(place);
            for next in skin.neighbors_of(place) {
                if class(next as usize) == Some(colored) {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        stack.push(next);
                    }
                } else {
                    beside += 1.0;
                    paler += f32::from(u8::from(colored || canvas.darkness[next as usize] < DARK - 0.15));
                }
            }
        }
        let share = of.iter().map(|p| skin.areas[*p as usize]).sum::<f32>() / total;
        if !(AREA[0]..=AREA[1]).contains(&share) || of.len() < 3 || beside > 0.0 && paler < APART * beside {
            continue;
        }
        of.sort_unstable();
        let weight = |p: u32| skin.areas[p as usize].max(1e-9);
        let sum: f32 = of.iter().map(|p| weight(*p)).sum();
        let center = of.iter().map(|p| canvas.positions[*p as usize] * weight(*p)).sum::<Vec3>() / sum;
        let mean_normal = of.iter().map(|p| skin.normals[*p as usize] * weight(*p)).sum::<Vec3>() / sum;
        let opening = if mean_normal.length() < BALL { opening(canvas, &of, center) } else { None };
        let normal = opening.map_or(mean_normal, |(normal, _)| normal).normalize_or(Vec3::Z);
        let (u, v) = normal.any_orthonormal_pair();
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in &of {
            let d = canvas.positions[*p as usize] - center;
            let (x, y) = (d.dot(u), d.dot(v));
            xx += x * x * weight(*p);
            xy += x * y * weight(*p);
            yy += y * y * weight(*p);
        }
        let angle = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
        let (sin, cos) = libm::sincosf(angle);
        let (mut long, side) = (u * cos + v * sin, v * cos - u * sin);
        if long.y < 0.0 {
            long = -long;
        }
        let range = |axis: Vec3| {
            of.iter()
                .map(|p| (canvas.positions[*p as usize] - center).dot(axis))
                .fold((0.0_f32, 0.0_f32), |r, x| (r.0.min(x), r.1.max(x)))
        };
        let widest = opening.map_or(f32::INFINITY, |(_, radius)| radius);
        let ((from, to), (left, right)) = (range(long), range(side));
        let (from, to, left, right) = (from.max(-widest), to.min(widest), left.max(-widest), right.min(widest));
        let (reach, width) = (to - from, right - left);
        if reach > LONGEST * width.max(1e-6) {
            continue;
        }
        let named = of.iter().filter(|p| canvas.eye[**p as usize]).count() * 2 > of.len();
        let is_high = center.y > low + 0.55 * (high - low);
        let kind = if !colored && (named || share < EYE_AREA && is_high && reach < 2.6 * width) {
            StrokeKind::Eye
        } else {
            StrokeKind::Spot
        };
        let half = 0.5 * width;
        let inset = (0.55 * half).min(0.35 * reach);
        let mut places = Vec::with_capacity(count);
        let mut half_widths = Vec::with_capacity(count);
        for i in 0..count {
            let t = i as f32 / (count - 1) as f32;
            let along = (to - inset) + (from - to + 2.0 * inset) * t;
            let Some(place) = canvas.nearest(center + long * along, normal) else { break };
            // An ellipse.
            let share = (along - 0.5 * (from + to)) / (0.5 * reach).max(1e-6);
            half_widths.push(half * (1.0 - 0.9 * share * share).max(0.05).sqrt());
            places.push(place);
        }
        if places.len() == count {
            let pigment = canvas.pigment[first].filter(|_| colored);
            spots.push(Spot { kind, pigment, places, half_widths, vertices: of });
        }
    }
    spots
}
