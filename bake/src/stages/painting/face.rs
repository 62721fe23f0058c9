//! Nostrils and mouth of a head with a snout, and eyes and noses between the vertices.
//!
//! They are placed by sections of the snout across its axis. Nothing is painted on a snout whose sections are missing,
//! lopsided or too wide, because a wrong face is worse than none.

use super::canvas::{Canvas, Place, darkness_of};
use super::head_frame::HeadFrame;
use super::model::PaintedModel;
use super::spots::{Ellipse, Spot};
use glam::{IVec3, Vec3};
use pelage_formats::{PaintStroke, StrokeKind};
use pelage_import::union_find::root;
use std::collections::BTreeMap;

/// Distances of the sections from the tip of the nose, in lengths of the head.
const SECTIONS: [f32; 6] = [0.04, 0.1, 0.2, 0.3, 0.4, 0.5];
/// Maximum half width and height of the section at 0.3, in lengths of the head.
const WIDEST: [f32; 2] = [0.42, 0.75];
/// Maximum offset of a section's middle from the plane of symmetry, divided by its half width.
const LOPSIDED: f32 = 0.2;
/// Maximum distance of a painted point from the section's ellipse, in lengths of the head.
const OFF: f32 = 0.15;
/// Half widths of nostrils and mouth, in lengths of the head.
const NOSTRIL: f32 = 0.022;
const MOUTH: f32 = 0.014;
/// Amount of ink of nostrils on white and on black surface, and of the mouth.
const NOSTRIL_INK: [f32; 2] = [0.65, 1.0];
const MOUTH_INK: [f32; 2] = [0.42, 0.85];

/// Section of a snout, in lengths of the head.
#[derive(Clone, Copy, Debug)]
struct Section {
    half_width: f32,
    low: f32,
    high: f32,
}

/// Snout with sections at [`SECTIONS`].
struct Snout<'a> {
    canvas: &'a Canvas,
    frame: HeadFrame,
    sections: [Section; SECTIONS.len()],
}

/// Whether most of a face belongs to the head.
fn is_in_head(canvas: &Canvas, face: &[u32; 3]) -> bool {
    face.iter().all(|p| canvas.head[*p as usize] > 0.5 && !canvas.eye[*p as usize])
}

impl<'a> Snout<'a> {
    /// Returns the snout of the head; `None` if its shape is doubtful.
    fn new(canvas: &'a Canvas) -> Option<Self> {
        let frame = canvas.face?;
        let mut sections = [Section { half_width: 0.0, low: 0.0, high: 0.0 }; SECTIONS.len()];
        for (section, behind) in sections.iter_mut().zip(SECTIONS) {
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for face in canvas.skin.faces.iter().filter(|face| is_in_head(canvas, face)) {
                let corners = face.map(|p| frame.coordinates(canvas.positions[p as usize]));
                for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
                    if (a.x < behind) != (b.x < behind) {
                        let p = a.lerp(b, (behind - a.x) / (b.x - a.x));
                        (low, high) = (low.min(p), high.max(p));
                    }
                }
            }
            let half_width = (high.y - low.y) / 2.0;
            if !(half_width > 0.0 && (high.y + low.y).abs() / 2.0 <= LOPSIDED * half_width) {
                return None;
            }
            *section = Section { half_width, low: low.z, high: high.z };
        }
        let Section { half_width, low, high } = sections[3];
        (half_width <= WIDEST[0] && high - low <= WIDEST[1]).then_some(Self { canvas, frame, sections })
    }

    /// Returns a point of the snout's surface; `None` if the surface is not near the section's ellipse.
    ///
    /// * `behind`: distance behind the tip of the nose, in lengths of the head
    /// * `angle`: angle above the horizontal plane, radians
    /// * `side`: 1 or -1
    fn place(&self, behind: f32, angle: f32, side: f32) -> Option<Place> {
        let Self { canvas, frame, sections } = self;
        let k = SECTIONS.iter().rposition(|s| *s <= behind).unwrap_or(0).min(SECTIONS.len() - 2);
        let share = ((behind - SECTIONS[k]) / (SECTIONS[k + 1] - SECTIONS[k])).clamp(0.0, 1.0);
        let mix =
            |value: fn(&Section) -> f32| value(&sections[k]) + (value(&sections[k + 1]) - value(&sections[k])) * share;
        let (low, high) = (mix(|s| s.low), mix(|s| s.high));
        let (sin, cos) = libm::sincosf(angle);
        let aside = frame.across * (side * cos);
        let off = aside * mix(|s| s.half_width) + frame.up * ((low + high) / 2.0 + sin * (high - low) / 2.0);
        let p = frame.nose + (off - frame.axis * behind) * frame.length;
        let normal = aside + frame.up * sin + frame.axis * (1.0 - behind / 0.15).max(0.0);
        let place = canvas.nearest(p, normal)?;
        let is_near = place.position.distance(p) <= OFF * frame.length;
        (is_near && is_in_head(canvas, &canvas.skin.faces[place.face])).then_some(place)
    }

    /// Returns a tapering stroke along a path; `None` if the path leaves the snout. On dark surface, it has more ink.
    fn stroke(&self, half_width: f32, [pale, dark]: [f32; 2], path: impl Fn(f32) -> Option<Place>) -> Option<Spot> {
        let shares = || (0..PaintStroke::POINTS).map(|i| i as f32 / (PaintStroke::POINTS - 1) as f32);
        let places = shares().map(path).collect::<Option<Vec<_>>>()?;
        let own = places.iter().map(|place| self.canvas.at(&self.canvas.darkness, place)).sum::<f32>();
        let darkness = pale + (dark - pale) * own / PaintStroke::POINTS as f32;
        // Quick onset, body in the first half, long taper.
        let pressure = |t: f32| (0.3 + 0.7 * (t / 0.3).min(1.0)) * (1.0 - 0.75 * t * t);
        let half_widths = shares().map(|t| half_width * self.frame.length * pressure(t)).collect();
        Some(Spot {
            kind: StrokeKind::Spot,
            pigment: None,
            darkness,
            places,
            half_widths,
            opposite: None,
            vertices: Vec::new(),
        })
    }
}

/// Returns nostrils and mouth; nothing on a head without a clear snout. A model that has a spot for its nose has no
/// nostrils.
pub(super) fn nostrils_and_mouth(canvas: &Canvas, spots: &[Spot]) -> Vec<Spot> {
    let Some(snout) = Snout::new(canvas) else { return Vec::new() };
    let frame = &snout.frame;
    let has_nose = spots.iter().any(|spot| frame.is_nose(spot.center()));
    let mut strokes = Vec::new();
    for side in [-1.0, 1.0] {
        let nostril = || snout.stroke(NOSTRIL, NOSTRIL_INK, |t| snout.place(0.06 + 0.07 * t, 0.2 + 0.6 * t * t, side));
        strokes.push(if has_nose { None } else { nostril() });
        // From the middle below the nose to the side, then back along the cheek.
        let angle = |t: f32| -0.2 - 1.0 * (1.0 - t / 0.35).max(0.0);
        strokes.push(snout.stroke(MOUTH, MOUTH_INK, |t| snout.place(0.05 + 0.33 * t, angle(t), side)));
    }
    // A face is symmetric or not painted.
    if strokes[1].is_none() || strokes[3].is_none() || strokes[0].is_none() != strokes[2].is_none() {
        return Vec::new();
    }
    strokes.into_iter().flatten().collect()
}

/// Distance between samples of the colours, in lengths of the head, and their maximum number.
const FINE: f32 = 0.02;
const MOST_SAMPLES: usize = 200_000;
/// Minimum darkness of eyes and noses.
const EYE_DARK: f32 = 0.8;
/// Range of the diameter of an eye, in lengths of the head.
const EYE_SIZE: [f32; 2] = [0.03, 0.3];
/// Range of the distance of eyes behind the nose, and minimum distance from the plane of symmetry.
const EYE_BEHIND: [f32; 2] = [0.3, 0.95];
const EYE_ASIDE: f32 = 0.08;
/// Maximum height of eyes above the axis of the snout.
const EYE_ABOVE: f32 = 0.6;
/// Maximum distance of one eye from the mirror image of the other, and maximum ratio of their areas.
const EYE_MIRROR: f32 = 0.12;
const EYE_ALIKE: f32 = 2.0;

/// Dark patch of the head.
struct Patch {
    points: Vec<(Vec3, f32)>,
    normal: Vec3,
    center: Vec3,
    area: f32,
}

/// Adds the nose and the eyes that the colours between the vertices show, if `spots` lacks them: a dark patch at the
/// tip of the snout, and the pair of dark patches that are most alike.
pub(super) fn add_hidden_spots(model: &PaintedModel<'_>, canvas: &Canvas, spots: &mut Vec<Spot>) {
    let Some(frame) = canvas.face else { return };
    let has_nose = spots.iter().any(|spot| frame.is_nose(spot.center()));
    let has_eyes = spots.iter().filter(|spot| spot.kind == StrokeKind::Eye).count() >= 2;
    if has_nose && has_eyes {
        return;
    }
    let patches = dark_patches(model, canvas, &frame);
    let at: Vec<Vec3> = patches.iter().map(|patch| frame.coordinates(patch.center)).collect();
    let mut best: Option<(f32, [usize; 2])> = None;
    for i in 0..patches.len() {
        for j in 0..i {
            let [a, b] = [at[i], at[j]];
            let off = a.distance(b * Vec3::new(1.0, -1.0, 1.0));
            let ratio = patches[i].area.max(patches[j].area) / patches[i].area.min(patches[j].area);
            let is_eye =
                |p: Vec3| (EYE_BEHIND[0]..EYE_BEHIND[1]).contains(&p.x) && p.y.abs() >= EYE_ASIDE && p.z <= EYE_ABOVE;
            let score = off + 0.1 * (ratio - 1.0);
            if is_eye(a) && is_eye(b) && off <= EYE_MIRROR && ratio <= EYE_ALIKE && best.is_none_or(|(s, _)| score < s)
            {
                best = Some((score, [i, j]));
            }
        }
    }
    let spot = |kind: StrokeKind, patch: &Patch| {
        let shape = Ellipse::around(&patch.points, patch.center, patch.normal, f32::INFINITY)?;
        let (places, half_widths) = shape.stroke(canvas, PaintStroke::POINTS, None)?;
        Some(Spot { kind, pigment: None, darkness: 1.0, places, half_widths, opposite: None, vertices: Vec::new() })
    };
    if !has_nose {
        let nose = patches.iter().filter(|patch| frame.is_nose(patch.center));
        let largest = nose.max_by(|a, b| a.area.total_cmp(&b.area));
        spots.extend(largest.and_then(|patch| spot(StrokeKind::Spot, patch)));
    }
    let eyes = best.filter(|_| !has_eyes).map(|(_, pair)| pair.map(|k| spot(StrokeKind::Eye, &patches[k])));
    if let Some([Some(left), Some(right)]) = eyes {
        spots.retain(|spot| spot.kind != StrokeKind::Eye);
        spots.extend([left, right]);
    }
}

/// Returns the small dark patches of the head.
fn dark_patches(model: &PaintedModel<'_>, canvas: &Canvas, frame: &HeadFrame) -> Vec<Patch> {
    let (mesh, colors) = (&model.surface.mesh, model.colors);
    let step = FINE * frame.length;
    let mut points: Vec<(Vec3, f32, Vec3)> = Vec::new();
    let mut count = 0;
    for part in &mesh.parts {
        for face in part.first_triangle..part.first_triangle + part.triangle_count {
            let [a, b, c] = canvas.corners(face);
            let across = (b - a).cross(c - a);
            let is_in_head = canvas.skin.faces[face].iter().all(|p| canvas.head[*p as usize] > 0.5);
            if !is_in_head || across.length() <= 0.0 {
                continue;
            }
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let n = ((longest / step).ceil() as usize).clamp(1, 200);
            count += n * n;
            if count > MOST_SAMPLES {
                return Vec::new();
            }
            // Centres of n² equal triangles.
            for (i, j) in (0..n).flat_map(|i| (0..2 * (n - i) - 1).map(move |j| (i, j))) {
                let third = (1 + j % 2) as f32 / 3.0;
                let (v, w) = ((i as f32 + third) / n as f32, ((j / 2) as f32 + third) / n as f32);
                let weights = Vec3::new(1.0 - v - w, v, w);
                if darkness_of(colors.at(mesh, part.material, &mesh.triangles[face], weights)) > EYE_DARK {
                    let area = across.length() / (2 * n * n) as f32;
                    points.push((canvas.place(face, weights).position, area, across.normalize_or_zero()));
                }
            }
        }
    }
    // Points in the same or in adjacent cells are connected.
    let cell = |p: Vec3| (p / (1.2 * step)).floor().as_ivec3().to_array();
    let mut first_in: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut parents: Vec<u32> = (0..points.len() as u32).collect();
    for (k, (p, ..)) in points.iter().enumerate() {
        first_in.entry(cell(*p)).or_insert(k as u32);
    }
    for (k, (p, ..)) in points.iter().enumerate() {
        for n in 0..27 {
            let near = IVec3::from(cell(*p)) + IVec3::new(n / 9, n / 3 % 3, n % 3) - 1;
            if let Some(other) = first_in.get(&near.to_array()) {
                let (a, b) = (root(&mut parents, k as u32), root(&mut parents, *other));
                parents[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut groups: BTreeMap<u32, Vec<(Vec3, f32, Vec3)>> = BTreeMap::new();
    for (k, point) in points.iter().enumerate() {
        groups.entry(root(&mut parents, k as u32)).or_default().push(*point);
    }
    let patch = |of: Vec<(Vec3, f32, Vec3)>| {
        let area: f32 = of.iter().map(|(_, area, _)| area).sum();
        let center = of.iter().map(|(p, area, _)| *p * *area).sum::<Vec3>() / area;
        let normal = of.iter().map(|(_, area, normal)| *normal * *area).sum::<Vec3>().normalize_or(Vec3::Y);
        Patch { points: of.into_iter().map(|(p, area, _)| (p, area)).collect(), normal, center, area }
    };
    let sizes = EYE_SIZE.map(|d| d * d * frame.length * frame.length * std::f32::consts::FRAC_PI_4);
    groups.into_values().map(patch).filter(|p| (sizes[0]..=sizes[1]).contains(&p.area)).collect()
}
