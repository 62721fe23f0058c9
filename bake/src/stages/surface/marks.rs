//! Comb directions at a few points, extended over the mesh surface.

use super::topology::{Key, Topology};
use crate::stages::reach::{MarkBlend, influence};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Mark: a direction at a point, or directions along a line.
#[derive(Clone, Debug, PartialEq)]
pub struct CombMark {
    /// Name, for messages.
    pub name: String,
    /// Points near the mesh surface, at least one: world space at rest, metres. Each has a direction of any length but
    /// 0.
    pub places: Vec<(Vec3, Vec3)>,
    /// Reach along the mesh surface, metres. Within it, the mark fades towards the direction that applies elsewhere.
    /// `None`: unlimited reach; all such marks share the surface.
    pub reach_m: Option<f32>,
}

/// Index that stands for no mark.
const NONE: u32 = u32::MAX;

/// Returns the wanted direction of each face. Marks without a reach share the whole surface; if there are none,
/// `elsewhere` applies. Marks with a reach override this within their reach.
pub(super) fn spread(
    topology: &Topology,
    marks: &[CombMark],
    elsewhere: Vec3,
    warnings: &mut Vec<String>,
) -> Vec<DVec3> {
    let faces = Faces::new(topology);
    let (near, far): (Vec<&CombMark>, Vec<&CombMark>) = marks.iter().partition(|mark| mark.reach_m.is_some());
    let mut wishes = match far.is_empty() {
        true => vec![elsewhere.as_dvec3().normalize_or_zero(); topology.faces.len()],
        false => blend_unlimited(&faces, &far, warnings),
    };
    let mut said = vec![MarkBlend::<Vec3>::default(); wishes.len()];
    for mark in near {
        let Some(reach) = mark.reach_m else { continue };
        let starts = faces.nearest_faces(mark, warnings);
        // A search for each mark is cheap, because it ends at the reach of the mark.
        for (f, (way, place)) in faces.distances(mark, &starts, f64::from(reach)).into_iter().enumerate() {
            let Some((_, direction)) = mark.places.get(place as usize) else { continue };
            said[f].add(influence(way as f32, reach), direction.normalize_or_zero());
        }
    }
    for (wish, said) in wishes.iter_mut().zip(said) {
        if let Some((share, direction)) = said.finish() {
            *wish += (direction.as_dvec3() - *wish) * f64::from(share);
        }
    }
    wishes
}

/// Combines directions by Shepard's inverse-distance weights, with distances along the mesh surface. On components
/// without a mark, distances are straight through space.
fn blend_unlimited(faces: &Faces<'_>, marks: &[&CombMark], warnings: &mut Vec<String>) -> Vec<DVec3> {
    let n = faces.centers.len();
    let mut sums = vec![DVec3::ZERO; n];
    let mut weights = vec![0.0; n];
    for mark in marks {
        let starts = faces.nearest_faces(mark, warnings);
        for (f, (way, place)) in faces.distances(mark, &starts, f64::INFINITY).into_iter().enumerate() {
            let Some((_, direction)) = mark.places.get(place as usize) else { continue };
            let weight = 1.0 / (way * way).max(1e-12);
            sums[f] += direction.as_dvec3().normalize_or_zero() * weight;
            weights[f] += weight;
        }
    }
    sums.iter().zip(weights).map(|(sum, weight)| if weight > 0.0 { *sum / weight } else { DVec3::ZERO }).collect()
}

/// Faces of the furred mesh, searchable by their centres.
struct Faces<'t> {
    topology: &'t Topology,
    centers: Vec<DVec3>,
    /// Indices of all faces, sorted by the x coordinates of their centres.
    by_x: Vec<u32>,
    /// Index of the connected region of each face.
    regions: Vec<u32>,
}

impl<'t> Faces<'t> {
    fn new(topology: &'t Topology) -> Self {
        let centers: Vec<DVec3> = (0..topology.faces.len()).map(|f| topology.centroid(f)).collect();
        let mut by_x: Vec<u32> = (0..centers.len() as u32).collect();
        by_x.sort_by(|a, b| centers[*a as usize].x.total_cmp(&centers[*b as usize].x));
        let regions = topology.regions(|_| true);
        Self { topology, centers, by_x, regions }
    }

    /// Returns the face with the nearest centre, or the first of several equally near ones.
    fn nearest(&self, at: DVec3) -> Option<u32> {
        let middle = self.by_x.partition_point(|f| self.centers[*f as usize].x < at.x);
        let mut best: Option<(f64, u32)> = None;
        let mut look = |f: u32| {
            let away = self.centers[f as usize] - at;
            let found = (away.length_squared(), f);
            let farther = best.is_some_and(|best| away.x * away.x > best.0);
            if best.is_none_or(|best| found.0.total_cmp(&best.0).then(found.1.cmp(&best.1)).is_lt()) {
                best = Some(found);
            }
            !farther
        };
        // Searches outwards on both sides, until the difference in x alone exceeds the distance found.
        let _ = self.by_x[middle..].iter().all(|f| look(*f));
        let _ = self.by_x[..middle].iter().rev().all(|f| look(*f));
        best.map(|(_, f)| f)
    }

    /// Returns the face nearest to each point of a mark. Adds a warning if the mark's directions have no effect there.
    fn nearest_faces(&self, mark: &CombMark, warnings: &mut Vec<String>) -> Vec<u32> {
        let nearest = |(at, _): &(Vec3, Vec3)| self.nearest(at.as_dvec3()).unwrap_or(NONE);
        let starts: Vec<u32> = mark.places.par_iter().map(nearest).collect();
        let along_normal = |((_, direction), f): (&(Vec3, Vec3), &u32)| {
            let normal = self.topology.normals.get(*f as usize);
            normal.is_some_and(|n| direction.as_dvec3().normalize_or_zero().reject_from(*n).length() < 0.1)
        };
        if !starts.is_empty() && mark.places.iter().zip(&starts).all(along_normal) {
            warnings.push(format!(
                "surface.comb_marks: {:?} points along the skin's normal at its position; its direction has almost no \
                 effect",
                mark.name
            ));
        }
        starts
    }

    /// Returns two values for each face: the shortest distance from a point of a mark, and the index of that point.
    /// Distances are measured along paths over face centres. For faces not connected to any point, the distance is
    /// straight through space. Distances beyond `reach` are infinite.
    fn distances(&self, mark: &CombMark, starts: &[u32], reach: f64) -> Vec<(f64, u32)> {
        let mut ways = vec![(f64::INFINITY, NONE); self.centers.len()];
        let mut heap = BinaryHeap::new();
        for (place, start) in (0..).zip(starts).filter(|(_, start)| **start != NONE) {
            let way = &mut ways[*start as usize];
            if way.1 == NONE {
                *way = (0.0, place);
                heap.push(Reverse((Key(0.0), *start)));
            }
        }
        while let Some(Reverse((Key(way), f))) = heap.pop() {
            let (shortest, place) = ways[f as usize];
            if way > shortest {
                continue;
            }
            for (_, g) in self.topology.neighbors(f as usize) {
                let next = way + self.centers[f as usize].distance(self.centers[g]);
                if next <= reach && next < ways[g].0 {
                    ways[g] = (next, place);
                    heap.push(Reverse((Key(next), g as u32)));
                }
            }
        }
        let regions = &self.regions;
        let mut reached = vec![false; regions.iter().max().map_or(0, |last| *last as usize + 1)];
        starts.iter().filter(|start| **start != NONE).for_each(|f| reached[regions[*f as usize] as usize] = true);
        for (f, way) in ways.iter_mut().enumerate().filter(|(f, _)| !reached[regions[*f] as usize]) {
            for (place, (at, _)) in (0..).zip(&mark.places) {
                let straight = self.centers[f].distance(at.as_dvec3());
                if straight <= reach && straight < way.0 {
                    *way = (straight, place);
                }
            }
        }
        ways
    }
}

#[cfg(test)]
#[path = "marks_tests.rs"]
mod tests;
