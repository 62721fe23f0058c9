//! Directions at a few places, spread over the skin.

use super::topology::{Key, Topology};
use crate::stages::reach::{Said, share};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A direction at a place, or directions along a line.
#[derive(Clone, Debug, PartialEq)]
pub struct CombMark {
    /// Name, for messages.
    pub name: String,
    /// Places near the skin, world space at rest, metres, with the direction there, any length but 0. At least one.
    pub places: Vec<(Vec3, Vec3)>,
    /// How far it reaches along the skin, metres, fading to what holds elsewhere; `None` as far as there is no other mark.
    pub reach_m: Option<f32>,
}

/// No mark.
const NONE: u32 = u32::MAX;

/// One wish per face. Marks without a reach share the surface among each other; those with one go before them, or before `elsewhere` where there are
/// none, as far as they reach.
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
        false => shared(&faces, &far, warnings),
    };
    let mut said = vec![Said::<Vec3>::default(); wishes.len()];
    for mark in near {
        let Some(reach) = mark.reach_m else { continue };
        let starts = faces.starts(mark, warnings);
        // Every mark for itself is cheap, as it goes no farther than it reaches.
        for (f, (way, place)) in faces.ways(mark, &starts, f64::from(reach)).into_iter().enumerate() {
            let Some((_, direction)) = mark.places.get(place as usize) else { continue };
            said[f].add(share(way as f32, reach), direction.normalize_or_zero());
        }
    }
    for (wish, said) in wishes.iter_mut().zip(said) {
        if let Some((share, direction)) = said.together() {
            *wish += (direction.as_dvec3() - *wish) * f64::from(share);
        }
    }
    wishes
}

/// Shepard's inverse-distance weights with distances along the skin; other components measure straight through space.
fn shared(faces: &Faces<'_>, marks: &[&CombMark], warnings: &mut Vec<String>) -> Vec<DVec3> {
    let n = faces.centers.len();
    let mut sums = vec![DVec3::ZERO; n];
    let mut weights = vec![0.0; n];
    for mark in marks {
        let starts = faces.starts(mark, warnings);
        for (f, (way, place)) in faces.ways(mark, &starts, f64::INFINITY).into_iter().enumerate() {
            let Some((_, direction)) = mark.places.get(place as usize) else { continue };
            let weight = 1.0 / (way * way).max(1e-12);
            sums[f] += direction.as_dvec3().normalize_or_zero() * weight;
            weights[f] += weight;
        }
    }
    sums.iter().zip(weights).map(|(sum, weight)| if weight > 0.0 { *sum / weight } else { DVec3::ZERO }).collect()
}

/// Faces of the skin by their centres.
struct Faces<'t> {
    topology: &'t Topology,
    centers: Vec<DVec3>,
    /// All faces, by x of their centres.
    by_x: Vec<u32>,
    /// For each face the region of faces that it hangs together with.
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

    /// The face whose centre is nearest; of several the first.
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
        // Outwards to both sides, until x alone is farther.
        let _ = self.by_x[middle..].iter().all(|f| look(*f));
        let _ = self.by_x[..middle].iter().rev().all(|f| look(*f));
        best.map(|(_, f)| f)
    }

    /// For each place of a mark the face that it stands on. A mark that has no say there is told of.
    fn starts(&self, mark: &CombMark, warnings: &mut Vec<String>) -> Vec<u32> {
        let nearest = |(at, _): &(Vec3, Vec3)| self.nearest(at.as_dvec3()).unwrap_or(NONE);
        let starts: Vec<u32> = mark.places.par_iter().map(nearest).collect();
        let along_normal = |((_, direction), f): (&(Vec3, Vec3), &u32)| {
            let normal = self.topology.normals.get(*f as usize);
            normal.is_some_and(|n| direction.as_dvec3().normalize_or_zero().reject_from(*n).length() < 0.1)
        };
        if !starts.is_empty() && mark.places.iter().zip(&starts).all(along_normal) {
            warnings.push(format!(
                "surface.comb_marks: {:?} points along the skin's normal where it stands; its direction has hardly an effect",
                mark.name
            ));
        }
        starts
    }

    /// For each face the length of the shortest way over faces' centres from a place of a mark, and which of its places that is; straight through space
    /// to faces that do not hang together with any. Farther than `reach` it is left open.
    fn ways(&self, mark: &CombMark, starts: &[u32], reach: f64) -> Vec<(f64, u32)> {
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
