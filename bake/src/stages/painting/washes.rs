//! Broad strokes that cover the trunk, in three classes from broad and pale to narrow and dark.
//!
//! Each stroke begins where the surface lacks paint most, follows the combing direction both ways, and ends at a border
//! of colour, at a limb or where the surface is already covered. So the first strokes cover most, and any prefix of the
//! list is a coarser painting of the same surface.

use super::canvas::{Canvas, Place};
use super::trace::{follow_both_ways, length};
use crate::noise::{hash, r2_point, smooth_step};
use glam::{DVec2, IVec3, Vec3};
use pelage_formats::StrokeKind;
use std::collections::HashMap;

/// Number of samples of the surface, and their density on the head relative to the body.
const SAMPLES: usize = 8000;
const HEAD_SAMPLES: f32 = 4.0;
/// Size of strokes on the head relative to the body.
const HEAD_SIZE: f32 = 0.5;

/// Class of strokes; lengths are in units of the model's size.
struct Class {
    kind: StrokeKind,
    half_width: f32,
    longest: f32,
    shortest: f32,
    /// Darkness below which the surface needs no stroke of this class.
    from: f32,
    most: usize,
}

const CLASSES: [Class; 3] = [
    Class { kind: StrokeKind::Pale, half_width: 0.058, longest: 0.52, shortest: 0.056, from: 0.0, most: 60 },
    Class { kind: StrokeKind::Middle, half_width: 0.038, longest: 0.40, shortest: 0.05, from: 0.12, most: 80 },
    Class { kind: StrokeKind::Dark, half_width: 0.0145, longest: 0.3, shortest: 0.085, from: 0.3, most: 160 },
];
/// Share of the lack at a stroke's start below which the stroke ends.
const ENDS_AT: f32 = 0.34;
/// Difference of darkness at which a stroke ends: a border of colour.
const BORDER: f32 = 0.3;
/// Minimum ratio of a stroke's length to its half width. Shorter strokes read as beads.
const SLENDER: f32 = 3.9;
/// Share of the lack that remains under a stroke.
const REMAINS: f32 = 0.05;
/// Mean lack, over half a stroke's width, at which a class is complete.
const COMPLETE: f32 = 0.25;

/// Stroke on the surface.
pub(super) struct SurfaceStroke {
    pub(super) kind: StrokeKind,
    pub(super) places: Vec<Place>,
    pub(super) half_width: f32,
}

struct Sample {
    place: Place,
    normal: Vec3,
    darkness: f32,
    lack: f32,
    /// Size of strokes that begin here, relative to those of the class.
    size: f32,
}

/// Samples by the cells of a grid.
struct Grid {
    size: f32,
    cells: HashMap<IVec3, Vec<usize>>,
}

impl Grid {
    fn new(samples: &[Sample], size: f32) -> Self {
        let mut cells: HashMap<IVec3, Vec<usize>> = HashMap::new();
        for (k, sample) in samples.iter().enumerate() {
            cells.entry((sample.place.position / size).floor().as_ivec3()).or_default().push(k);
        }
        Self { size, cells }
    }

    /// Calls `with` for all samples in the cells around a point, and possibly for others.
    fn near(&self, p: Vec3, radius: f32, mut with: impl FnMut(usize)) {
        let low = ((p - radius) / self.size).floor().as_ivec3();
        let high = ((p + radius) / self.size).floor().as_ivec3();
        for (x, y, z) in
            (low.x..=high.x).flat_map(|x| (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| (x, y, z))))
        {
            if let Some(of) = self.cells.get(&IVec3::new(x, y, z)) {
                of.iter().for_each(|k| with(*k));
            }
        }
    }
}

/// Returns points spread evenly over the surface, and more densely over the head.
pub(super) fn spread_places(canvas: &Canvas, count: usize, seed: u64) -> Vec<Place> {
    let area = |face: usize| {
        let [a, b, c] = canvas.corners(face);
        let head = canvas.skin.faces[face].iter().map(|p| canvas.head[*p as usize]).sum::<f32>() / 3.0;
        f64::from((b - a).cross(c - a).length() * (1.0 + (HEAD_SAMPLES - 1.0) * head)) / 2.0
    };
    let total: f64 = (0..canvas.skin.faces.len()).map(area).sum();
    let mut places = Vec::with_capacity(count);
    let mut carried = 0.5;
    for face in 0..canvas.skin.faces.len() {
        carried += area(face) / total.max(1e-12) * count as f64;
        while carried >= 1.0 {
            carried -= 1.0;
            let shift = DVec2::new((hash(seed, 1) % 1000) as f64, (hash(seed, 2) % 1000) as f64) / 1000.0;
            let p = r2_point(places.len() as u32, shift).as_vec2();
            let (u, v) = if p.x + p.y > 1.0 { (1.0 - p.x, 1.0 - p.y) } else { (p.x, p.y) };
            places.push(canvas.place(face, Vec3::new(1.0 - u - v, u, v)));
        }
    }
    places
}

/// Returns the washes of the trunk. `is_covered`: whether another stroke paints a welded vertex.
pub(super) fn washes(canvas: &Canvas, is_covered: &[bool], seed: u64) -> Vec<SurfaceStroke> {
    let covered: Vec<f32> = is_covered.iter().map(|c| f32::from(u8::from(*c))).collect();
    let places = spread_places(canvas, SAMPLES, seed);
    let mut strokes = Vec::new();
    for class in &CLASSES {
        let mut samples: Vec<Sample> = places
            .iter()
            .map(|&place| {
                let darkness = canvas.at(&canvas.darkness, &place);
                let free = 1.0 - smooth_step(0.3, 0.7, canvas.at(&covered, &place));
                let wanted = if class.from > 0.0 { smooth_step(class.from, class.from + 0.3, darkness) } else { 1.0 };
                let normal = canvas.vector_at(&canvas.skin.normals, &place);
                let size = 1.0 - (1.0 - HEAD_SIZE) * smooth_step(0.2, 0.8, canvas.at(&canvas.head, &place));
                Sample { place, normal, darkness, lack: free * wanted, size }
            })
            .collect();
        let grid = Grid::new(&samples, class.half_width * 0.5);
        let around: Vec<Vec<usize>> = samples
            .iter()
            .map(|sample| {
                let mut near = Vec::new();
                let radius = class.half_width * 0.6 * sample.size;
                grid.near(sample.place.position, radius, |k| {
                    let other = &samples[k];
                    if other.place.position.distance_squared(sample.place.position) < radius * radius
                        && other.normal.dot(sample.normal) > 0.3
                    {
                        near.push(k);
                    }
                });
                near
            })
            .collect();
        let mean = |samples: &[Sample], k: usize| {
            around[k].iter().map(|j| samples[*j].lack).sum::<f32>() / around[k].len().max(1) as f32
        };
        let mut made = 0.0;
        for _ in 0..class.most * 8 {
            if made >= class.most as f32 {
                break;
            }
            let best = (0..samples.len())
                .map(|k| (mean(&samples, k), k))
                .max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            let Some((lack, best)) = best.filter(|(lack, _)| *lack > COMPLETE) else { break };
            let start = &samples[best];
            let (from, darkness, size) = (start.place, start.darkness, start.size);
            let thick = canvas.at(&canvas.thickness, &from);
            let half_width = (class.half_width * size).min(0.5 * thick.max(0.02));
            let places = follow_both_ways(canvas, from, class.longest * size, |place| {
                let (mut sum, mut n) = (0.0, 0.0);
                grid.near(place.position, class.half_width * 0.5 * size, |k| {
                    sum += samples[k].lack;
                    n += 1.0;
                });
                (canvas.at(&canvas.darkness, place) - darkness).abs() < BORDER
                    && canvas.at(&covered, place) < 0.5
                    && (n == 0.0 || sum / n > ENDS_AT * lack)
            });
            let positions: Vec<Vec3> = places.iter().map(|p| p.position).collect();
            let long = length(&positions);
            let keeps = long >= SLENDER * half_width && long >= class.shortest * size;
            for place in &places {
                let normal = canvas.vector_at(&canvas.skin.normals, place);
                let mut touched = Vec::new();
                grid.near(place.position, half_width, |k| touched.push(k));
                for k in touched {
                    let sample = &mut samples[k];
                    if sample.place.position.distance(place.position) < half_width && sample.normal.dot(normal) > 0.2 {
                        sample.lack *= if keeps { 0.6 * REMAINS + 0.4 * 0.2 } else { 0.3 };
                    }
                }
            }
            samples[best].lack *= 0.2;
            if keeps {
                // Strokes on the head take up less of the number by their area.
                made += size * size;
                strokes.push(SurfaceStroke { kind: class.kind, places, half_width });
            }
        }
    }
    strokes
}
