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
/// Darkness from which the bare end of a leg is a hoof, and its maximum height as a share of the body's.
const DARK_HOOF: f32 = 0.4;
const HOOF_HEIGHT: f32 = 0.15;
/// Minimum amount of ink of a hoof.
const LEAST_HOOF_INK: f32 = 0.8;
/// Share of the bordering surface that must be paler.
const APART: f32 = 0.12;

/// Spot: its stroke from end to end, and the half width at each place.
pub(super) struct Spot {
    pub(super) kind: StrokeKind,
    /// Colour of a mineral pigment, linear RGB.
    pub(super) pigment: Option<[f32; 3]>,
    /// Amount of ink, 0..=1.
    pub(super) darkness: f32,
    pub(super) places: Vec<Place>,
    pub(super) half_widths: Vec<f32>,
    /// Places on the other side of a limb, for a stroke through the limb.
    pub(super) opposite: Option<Vec<Place>>,
    pub(super) vertices: Vec<u32>,
}

impl Spot {
    /// Returns the middle of the stroke.
    pub(super) fn center(&self) -> Vec3 {
        self.places.get(self.places.len() / 2).map_or(Vec3::ZERO, |place| place.position)
    }
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
    // Points within the ball hide nothing of it.
    let mut lids: Vec<f32> = near
        .iter()
        .map(|p| canvas.positions[*p] - center)
        .filter(|d| d.dot(normal) > 0.0 && d.length() > 0.95 * radius)
        .map(|d| (d - normal * d.dot(normal)).length())
        .collect();
    lids.sort_unstable_by(f32::total_cmp);
    let lid = lids.get(lids.len() / 4).copied().unwrap_or(radius);
    Some((normal, lid.clamp(0.4 * radius, radius)))
}

/// Returns the spot of a hoof: a stroke down through the end of the leg. `None` if it has no height.
fn hoof(canvas: &Canvas, of: Vec<u32>, count: usize) -> Option<Spot> {
    let (low, high) = of
        .iter()
        .map(|p| canvas.positions[*p as usize])
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let (middle, extent) = ((low + high) / 2.0, high - low);
    let half = 0.19 * (extent.x + extent.z);
    if !(half > 0.0 && extent.y > 0.0) {
        return None;
    }
    // The brush is nearly as wide as the hoof, so its ends are inside.
    let inset = (0.4 * half).min(0.3 * extent.y);
    let share = |i: usize| i as f32 / (count - 1) as f32;
    let side = |sign: f32| {
        let place = |i: usize| {
            let y = high.y - inset - (extent.y - 2.0 * inset) * share(i);
            canvas.nearest(Vec3::new(middle.x + sign * half, y, middle.z), Vec3::X * sign)
        };
        (0..count).map(place).collect::<Option<Vec<_>>>()
    };
    let darkness = of.iter().map(|p| canvas.darkness[*p as usize]).fold(LEAST_HOOF_INK, f32::max);
    let half_widths = (0..count).map(|i| half * (0.7 + 0.3 * share(i))).collect();
    let (places, opposite) = (side(1.0)?, Some(side(-1.0)?));
    Some(Spot { kind: StrokeKind::Spot, pigment: None, darkness, places, half_widths, opposite, vertices: of })
}

/// Returns the spots of a model, each with a stroke of `count` points.
pub(super) fn spots(canvas: &Canvas, count: usize) -> Vec<Spot> {
    let skin = &canvas.skin;
    let total: f32 = skin.areas.iter().sum::<f32>().max(1e-12);
    let low = canvas.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let high = canvas.positions.iter().map(|p| p.y).fold(f32::NEG_INFINITY, f32::max);
    // Bare ends of furred legs.
    let has_fur = canvas.furred.contains(&true);
    let has_named = (0..canvas.positions.len()).any(|p| canvas.eye[p] && canvas.darkness[p] > DARK_EYE);
    let is_hoof = |p: usize| has_fur && !canvas.furred[p] && canvas.positions[p].y < low + HOOF_HEIGHT * (high - low);
    let is_dark = |p: usize| {
        let from = if is_hoof(p) {
            DARK_HOOF
        } else if canvas.eye[p] {
            DARK_EYE
        } else {
            DARK
        };
        canvas.darkness[p] > from
    };
    // Patches of mineral colour are spots too, apart from dark ones.
    let class = |p: usize| match (is_dark(p), &canvas.pigment[p]) {
        (true, _) => Some(false),
        (false, pigment) => pigment.map(|_| true),
    };
    let mut seen = vec![false; canvas.positions.len()];
    let mut spots = Vec::new();
    for first in 0..canvas.positions.len() {
        let Some(colored) = class(first).filter(|_| !seen[first]) else { continue };
        let (mut of, mut stack) = (Vec::new(), vec![first as u32]);
        let (mut beside, mut paler, mut goes_on) = (0.0, 0.0, false);
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
                    goes_on |= !canvas.furred[next as usize];
                    paler += f32::from(u8::from(colored || canvas.darkness[next as usize] < DARK - 0.15));
                }
            }
        }
        let are_hooves = !goes_on && of.iter().all(|p| is_hoof(*p as usize));
        let share = of.iter().map(|p| skin.areas[*p as usize]).sum::<f32>() / total;
        if !(AREA[0]..=AREA[1]).contains(&share)
            || of.len() < 3
            || beside > 0.0 && paler < APART * beside && !are_hooves
        {
            continue;
        }
        of.sort_unstable();
        let weight = |p: u32| skin.areas[p as usize].max(1e-9);
        let sum: f32 = of.iter().map(|p| weight(*p)).sum();
        let center = of.iter().map(|p| canvas.positions[*p as usize] * weight(*p)).sum::<Vec3>() / sum;
        let mean_normal = of.iter().map(|p| skin.normals[*p as usize] * weight(*p)).sum::<Vec3>() / sum;
        if are_hooves {
            spots.extend(hoof(canvas, of, count));
            continue;
        }
        let opening = if mean_normal.length() < BALL { opening(canvas, &of, center) } else { None };
        let normal = opening.map_or(mean_normal, |(normal, _)| normal).normalize_or(Vec3::Z);
        let points: Vec<(Vec3, f32)> = of.iter().map(|p| (canvas.positions[*p as usize], weight(*p))).collect();
        let widest = opening.map_or(f32::INFINITY, |(_, radius)| radius);
        let Some(shape) = Ellipse::around(&points, center, normal, widest) else { continue };
        let (reach, width) = (shape.to - shape.from, shape.width);
        let named = of.iter().filter(|p| canvas.eye[**p as usize]).count() * 2 > of.len();
        let is_nose = canvas.face.is_some_and(|frame| frame.is_nose(center));
        let is_high = !is_nose && center.y > low + 0.55 * (high - low);
        // Where eyes are named, other dark patches, such as tips of ears, are none.
        let looks_like_one = !has_named && share < EYE_AREA && is_high && reach < 2.6 * width;
        let kind = if !colored && (named || looks_like_one) { StrokeKind::Eye } else { StrokeKind::Spot };
        // The stroke of a ball stays on it, in front; its socket may be nearer to its middle.
        let ball = opening.map(|_| (0.5 * reach, &of[..]));
        if let Some((places, half_widths)) = shape.stroke(canvas, count, ball) {
            let pigment = canvas.pigment[first].filter(|_| colored);
            spots.push(Spot { kind, pigment, darkness: 1.0, places, half_widths, opposite: None, vertices: of });
        }
    }
    spots
}

/// Ellipse around points in a tangent plane.
pub(super) struct Ellipse {
    center: Vec3,
    normal: Vec3,
    /// Unit direction of the longer axis, upwards.
    long: Vec3,
    /// Ends of the longer axis.
    pub(super) from: f32,
    pub(super) to: f32,
    /// Length of the shorter axis.
    pub(super) width: f32,
}

impl Ellipse {
    /// Returns the ellipse around weighted points; `None` if it is too long.
    ///
    /// * `widest`: maximum distance of its ends from `center`
    pub(super) fn around(points: &[(Vec3, f32)], center: Vec3, normal: Vec3, widest: f32) -> Option<Self> {
        let (u, v) = normal.any_orthonormal_pair();
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (p, weight) in points {
            let d = *p - center;
            let (x, y) = (d.dot(u), d.dot(v));
            xx += x * x * weight;
            xy += x * y * weight;
            yy += y * y * weight;
        }
        let angle = 0.5 * libm::atan2f(2.0 * xy, xx - yy);
        let (sin, cos) = libm::sincosf(angle);
        let (mut long, side) = (u * cos + v * sin, v * cos - u * sin);
        if long.y < 0.0 {
            long = -long;
        }
        let range = |axis: Vec3| {
            points
                .iter()
                .map(|(p, _)| (*p - center).dot(axis))
                .fold((0.0_f32, 0.0_f32), |r, x| (r.0.min(x), r.1.max(x)))
        };
        let ((from, to), (left, right)) = (range(long), range(side));
        let (from, to) = (from.max(-widest), to.min(widest));
        let width = right.min(widest) - left.max(-widest);
        (to - from <= LONGEST * width.max(1e-6)).then_some(Self { center, normal, long, from, to, width })
    }

    /// Returns the stroke along the longer axis and its half widths; `None` if the surface is missing somewhere.
    ///
    /// * `ball`: radius and sorted vertices of a ball around the center
    pub(super) fn stroke(
        &self,
        canvas: &Canvas,
        count: usize,
        ball: Option<(f32, &[u32])>,
    ) -> Option<(Vec<Place>, Vec<f32>)> {
        let Self { center, normal, long, from, to, width } = *self;
        let (half, reach) = (0.5 * width, to - from);
        // The ends of the brush are round: that of a ball stays within its outline.
        let inset = if ball.is_some() { (0.9 * half).min(0.45 * reach) } else { (0.55 * half).min(0.35 * reach) };
        let point = |i: usize| {
            let along = (to - inset) + (from - to + 2.0 * inset) * (i as f32 / (count - 1) as f32);
            let share = (along - 0.5 * (from + to)) / (0.5 * reach).max(1e-6);
            let place = match ball {
                None => canvas.nearest(center + long * along, normal),
                Some((radius, of)) => {
                    let in_front = center + long * along + normal * radius;
                    canvas.nearest_on(in_front, normal, &|face| face.iter().all(|p| of.binary_search(p).is_ok()))
                }
            }?;
            Some((place, half * (1.0 - 0.9 * share * share).max(0.05).sqrt()))
        };
        (0..count).map(point).collect::<Option<Vec<_>>>().map(|points| points.into_iter().unzip())
    }
}
