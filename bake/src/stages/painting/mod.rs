//! `painting`: strokes with which the model is painted, attached to its surface.
//!
//! * `canvas`: the surface with its thickness, combing direction and darkness
//! * `axes`: curves through the centres of limbs, which are painted along them
//! * `washes`: broad strokes on the trunk, along the combing direction
//! * `spots`: eyes, noses and hooves
//! * `face`: nostrils, mouth, and eyes and noses between the vertices
//! * `locks`: guided hair
//! * `head_frame`: position and directions of the head
//! * `model`: data that a painting is made from
//! * `tufts`: fur
//! * `trace`: curves on the surface
//!
//! Lengths are in units of the model's size, the diagonal of its bounding box. The strokes do not depend on a view: a
//! frame draws those that face the eye and darkens them by its light.

mod axes;
mod canvas;
mod face;
mod head_frame;
mod locks;
mod model;
mod spots;
#[cfg(test)]
mod tests;
mod trace;
mod tufts;
mod washes;

use crate::stages::groom::name_of_eyes;
use axes::AxisPoint;
use canvas::{Canvas, Place};
use glam::Vec3;
use pelage_formats::{PaintStroke, StrokeAnchor, StrokeKind, StrokePoint, StrokePool};
use trace::{evenly, length};

pub use model::PaintedModel;

/// Radius of a ring up to which a limb is painted with a single stroke, in units of the model's size.
const BONE: f32 = 0.0145;
/// Minimum ratio of the length of a single stroke to its half width.
const SLENDER_BONE: f32 = 5.0;
/// Shares of a limb's radius that its washes cover, from pale to dark.
const LIMB_WIDTHS: [(StrokeKind, f32); 3] =
    [(StrokeKind::Pale, 0.9), (StrokeKind::Middle, 0.66), (StrokeKind::Dark, 0.36)];
/// Share of the points of an axis, from the trunk, over which a limb's stroke is in the trunk.
const LIMB_RADIUS: f32 = 0.06;

/// Returns the strokes of a model.
pub fn painting(model: &PaintedModel<'_>) -> StrokePool {
    let PaintedModel { hair_m, seed, .. } = *model;
    let canvas = Canvas::new(model, name_of_eyes);
    let mut pool = Pool { canvas: &canvas, strokes: Vec::new(), seed };
    let mut spots = spots::spots(&canvas, PaintStroke::POINTS);
    face::add_hidden_spots(model, &canvas, &mut spots);
    spots.extend(face::nostrils_and_mouth(&canvas, &spots));
    let mut covered = vec![false; canvas.positions.len()];
    for spot in &spots {
        spot.vertices.iter().for_each(|v| covered[*v as usize] = true);
        pool.add_spot(spot);
    }
    let spotted = covered.clone();
    let axes = axes::axes(&canvas);
    for (place, covered) in covered.iter_mut().enumerate() {
        *covered |= axes.distance[place] > 0.0;
    }
    axes.axes.iter().for_each(|axis| pool.add_axis(axis));
    for stroke in washes::washes(&canvas, &covered, seed) {
        pool.add_surface_stroke(stroke.kind, &stroke.places, |_| stroke.half_width);
    }
    let mut hair = vec![0.0_f32; canvas.positions.len()];
    for (v, place) in canvas.skin.place_of.iter().enumerate() {
        hair[*place as usize] = hair_m.get(v).copied().unwrap_or(0.0) / canvas.size;
    }
    for tuft in tufts::tufts(&canvas, &hair, &spotted, seed) {
        pool.add_surface_stroke(StrokeKind::Tuft, &tuft.places, |t| tuft.half_width * (0.35 + 0.9 * t));
    }
    for lock in locks::locks(model, canvas.size) {
        pool.add_lock(&lock);
    }
    pool.finish()
}

struct Pool<'a> {
    canvas: &'a Canvas,
    strokes: Vec<PaintStroke>,
    seed: u64,
}

impl Pool<'_> {
    fn push(&mut self, kind: StrokeKind, pigment: Option<[f32; 3]>, points: Vec<StrokePoint>) {
        let number = self.strokes.len() as u64;
        let seed = (crate::noise::hash(self.seed, number) >> 32) as u32;
        self.strokes.push(PaintStroke { kind, rank: 0.0, seed, pigment, points });
    }

    fn point(canvas: &Canvas, sides: [StrokeAnchor; 2], half_width: f32, darkness: f32) -> StrokePoint {
        let darkness = darkness.clamp(0.0, 1.0);
        StrokePoint { sides, offset_m: None, half_width_m: half_width * canvas.size, darkness }
    }

    fn add_spot(&mut self, spot: &spots::Spot) {
        let opposite = spot.opposite.as_ref().unwrap_or(&spot.places);
        let points = spot.places.iter().zip(opposite).zip(&spot.half_widths).map(|((place, opposite), half)| {
            let sides = [place, opposite].map(|place| self.canvas.anchor(place));
            Self::point(self.canvas, sides, *half, spot.darkness)
        });
        let points = points.collect();
        self.push(spot.kind, spot.pigment, points);
    }

    /// Adds a stroke on the surface; `half_width` is a function of the share of its length.
    fn add_surface_stroke(&mut self, kind: StrokeKind, places: &[Place], half_width: impl Fn(f32) -> f32) {
        let canvas = self.canvas;
        let positions: Vec<Vec3> = places.iter().map(|p| p.position).collect();
        let last = PaintStroke::POINTS - 1;
        let points: Vec<StrokePoint> = evenly(&positions, PaintStroke::POINTS)
            .into_iter()
            .enumerate()
            .map(|(i, (k, share))| {
                let next = (k + 1).min(places.len() - 1);
                let p = positions[k].lerp(positions[next], share);
                let normal = canvas.vector_at(&canvas.skin.normals, &places[k]);
                let place = canvas.nearest(p, normal).unwrap_or(places[k]);
                let thick = canvas.at(&canvas.thickness, &place);
                let half = half_width(i as f32 / last as f32).min(0.5 * thick.max(0.012));
                Self::point(canvas, [canvas.anchor(&place); 2], half, canvas.at(&canvas.darkness, &place))
            })
            .collect();
        let middle = &places[places.len() / 2];
        let pigment = self.canvas.pigment[self.canvas.skin.faces[middle.face][0] as usize];
        self.push(kind, pigment, points);
    }

    fn add_lock(&mut self, lock: &locks::Lock) {
        let last = (PaintStroke::POINTS - 1) as f32;
        let points = evenly(&lock.offsets_m, PaintStroke::POINTS).into_iter().enumerate().map(|(i, (k, share))| {
            let next = (k + 1).min(lock.offsets_m.len() - 1);
            let offset = lock.offsets_m[k].lerp(lock.offsets_m[next], share);
            let [root, tip] = lock.darkness;
            let darkness = root + (tip - root) * i as f32 / last;
            let offset_m = Some(offset.to_array());
            StrokePoint { offset_m, ..Self::point(self.canvas, [lock.root; 2], lock.half_width, darkness) }
        });
        let points = points.collect();
        self.push(StrokeKind::Lock, None, points);
    }

    fn add_axis(&mut self, axis: &[AxisPoint]) {
        let canvas = self.canvas;
        let centers: Vec<Vec3> = axis.iter().map(|p| p.center).collect();
        let mean = axis.iter().map(|p| p.radius).sum::<f32>() / axis.len() as f32;
        // A short single stroke would read as a bead, such as an ear's.
        if length(&centers) < if mean < BONE { SLENDER_BONE } else { 2.0 } * mean {
            return;
        }
        let nearest = |k: usize, share: f32| if share < 0.5 { k } else { (k + 1).min(axis.len() - 1) };
        let points = |width: f32| -> Vec<StrokePoint> {
            evenly(&centers, PaintStroke::POINTS)
                .into_iter()
                .map(|(k, share)| {
                    let (from, to) = (&axis[k], &axis[(k + 1).min(axis.len() - 1)]);
                    let radius = from.radius + (to.radius - from.radius) * share;
                    let darkness = from.darkness + (to.darkness - from.darkness) * share;
                    Self::point(canvas, axis[nearest(k, share)].sides, radius * width, darkness)
                })
                .collect()
        };
        if mean < BONE {
            let points = points(1.0);
            self.push(StrokeKind::Bone, None, points);
        } else if mean < LIMB_RADIUS {
            for (kind, width) in LIMB_WIDTHS {
                let points = points(width);
                self.push(kind, None, points);
            }
        }
    }

    /// Ranks the strokes of each kind in their order.
    fn finish(mut self) -> StrokePool {
        self.strokes.truncate(StrokePool::MOST);
        let mut counts = std::collections::BTreeMap::new();
        for stroke in &self.strokes {
            *counts.entry(stroke.kind as u32).or_insert(0_u32) += 1;
        }
        let mut seen = std::collections::BTreeMap::new();
        for stroke in &mut self.strokes {
            let k = seen.entry(stroke.kind as u32).or_insert(0_u32);
            stroke.rank = *k as f32 / (counts[&(stroke.kind as u32)] - 1).max(1) as f32;
            *k += 1;
        }
        StrokePool { size_m: self.canvas.size, strokes: self.strokes }
    }
}
