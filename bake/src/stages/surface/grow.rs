//! Patches that grow from seeds, all at once, until a patch would turn or extend too far (Lengyel et al. 2001; Praun et
//! al. 2000, §4.1).
//!
//! Each face belongs to the nearest seed. Nearness combines the distance along the mesh surface with the rotation of
//! the face's frame from that of the seed. New seeds are added where no patch reaches within the limits, until all
//! faces are covered. Patches that grow side by side are rounder than patches grown one after the other, which leave
//! slits and slivers between them.

use super::solve::FaceFrame;
use super::topology::{Key, NONE, Topology};
use pelage_import::angle::between;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Limits of a patch's growth from its seed. The used shares of both limits are added: at half the distance, half the
/// rotation remains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reach {
    /// Distance along the mesh surface, tile widths.
    pub(super) tiles: f64,
    /// Rotation between the frames of the seed and of a face, radians.
    pub(super) turn_rad: f64,
    /// Whether the frames follow a comb; without a comb, only the rotation of the normals counts.
    pub(super) combed: bool,
}

/// Grows patches and returns the patch of each face, numbered from 0 without gaps. Each patch is connected by edges.
pub(super) fn grow(topology: &Topology, frames: &[FaceFrame], reach: &Reach) -> Vec<u32> {
    // Patches do not leave their component, so components grow in parallel.
    let components = members(&topology.regions(|_| true));
    let mut slots = vec![0; topology.faces.len()];
    for (slot, f) in components.iter().flat_map(|faces| faces.iter().enumerate()) {
        slots[*f as usize] = slot;
    }
    let seeds_of = |faces: &Vec<u32>| {
        let mut flood = Flood::new(topology, frames, reach, faces.len());
        let mut farthest: BinaryHeap<(Key, Reverse<u32>)> =
            faces.iter().map(|f| (Key(f64::INFINITY), Reverse(*f))).collect();
        let mut seeds = 0;
        while let Some((key, Reverse(f))) = farthest.pop() {
            let now = flood.cost[slots[f as usize]];
            if now <= 1.0 {
                continue;
            }
            if now < key.0 {
                farthest.push((Key(now), Reverse(f)));
                continue;
            }
            flood.grow_from(f, seeds, |f| Some(slots[f]));
            seeds += 1;
        }
        flood.seed_of
    };
    let of_components: Vec<Vec<u32>> = components.par_iter().map(seeds_of).collect();
    let mut seed_of = vec![NONE; slots.len()];
    for (f, seed) in components.iter().flatten().zip(of_components.iter().flatten()) {
        seed_of[*f as usize] = *seed;
    }
    topology.regions(|h| seed_of[h as usize / 3] == seed_of[topology.twins[h as usize] as usize / 3])
}

/// Returns the faces of each patch in ascending order, given the patch of each face, numbered from 0 without gaps.
pub(super) fn members(owner: &[u32]) -> Vec<Vec<u32>> {
    let mut out: Vec<Vec<u32>> = Vec::new();
    for (f, o) in owner.iter().enumerate() {
        if *o as usize >= out.len() {
            out.resize(*o as usize + 1, Vec::new());
        }
        out[*o as usize].push(f as u32);
    }
    out
}

/// Splits a connected patch in two: one part grows from one end, the other from the face farthest from it. Returns
/// whether each face belongs to the second part. Both parts have at least one face, and each may be disconnected.
pub(super) fn split(topology: &Topology, frames: &[FaceFrame], reach: &Reach, faces: &[u32]) -> Vec<bool> {
    let mut sorted: Vec<u32> = faces.to_vec();
    sorted.sort_unstable();
    let local = |f: usize| sorted.binary_search(&(f as u32)).ok();
    let mut flood = Flood::new(topology, frames, reach, faces.len());
    let farthest = |flood: &Flood<'_>| {
        let costs = flood.cost.iter().zip(&sorted);
        costs.max_by(|a, b| a.0.total_cmp(b.0).then(b.1.cmp(a.1))).map_or(sorted[0], |(_, f)| *f)
    };
    // The face farthest from any start is one end; the face farthest from this end is the other.
    flood.grow_from(sorted[0], 0, local);
    let one_end = farthest(&flood);
    flood.cost.fill(f64::INFINITY);
    flood.grow_from(one_end, 0, local);
    let other_end = farthest(&flood);
    flood.grow_from(other_end, 1, local);
    faces.iter().map(|f| local(*f as usize).is_some_and(|i| flood.seed_of[i] == 1)).collect()
}

/// Costs and owners of faces during growth.
struct Flood<'a> {
    topology: &'a Topology,
    frames: &'a [FaceFrame],
    reach: &'a Reach,
    /// Cost of reaching each face from its seed; 1 is the full reach.
    cost: Vec<f64>,
    seed_of: Vec<u32>,
}

impl<'a> Flood<'a> {
    fn new(topology: &'a Topology, frames: &'a [FaceFrame], reach: &'a Reach, n: usize) -> Self {
        Self { topology, frames, reach, cost: vec![f64::INFINITY; n], seed_of: vec![NONE; n] }
    }

    /// Assigns to `seed` all faces connected to it that are nearer to it than to their owner. `slot` returns the index
    /// of a face in the lists, or `None` for faces to ignore.
    fn grow_from(&mut self, seed: u32, id: u32, slot: impl Fn(usize) -> Option<usize>) {
        // Ordered by distance, which never decreases along a path, so each face is expanded at most once. The rotation
        // may decrease: in the order of the costs, faces would be reached by detours first and expanded repeatedly.
        let mut heap = BinaryHeap::from([Reverse((Key(0.0), seed))]);
        while let Some(Reverse((Key(way), f))) = heap.pop() {
            let Some(i) = slot(f as usize).filter(|i| way < self.cost[*i]) else { continue };
            let turn = if f == seed { 0.0 } else { self.turn(seed as usize, f as usize) };
            let cost = way + turn / self.reach.turn_rad;
            if cost >= self.cost[i] {
                continue;
            }
            self.cost[i] = cost;
            self.seed_of[i] = id;
            let center = self.topology.centroid(f as usize);
            for (_, g) in self.topology.neighbors(f as usize) {
                let way = way + center.distance(self.topology.centroid(g)) / (self.frames[g].tile_m * self.reach.tiles);
                if slot(g).is_some_and(|j| way < self.cost[j]) {
                    heap.push(Reverse((Key(way), g as u32)));
                }
            }
        }
    }

    /// Returns the angle of the rotation between the frames of two faces, radians.
    fn turn(&self, f: usize, g: usize) -> f64 {
        let (a, b) = (&self.frames[f], &self.frames[g]);
        if !self.reach.combed {
            return between(self.topology.normals[f], self.topology.normals[g]);
        }
        let trace = a.s.dot(b.s) + a.t.dot(b.t) + self.topology.normals[f].dot(self.topology.normals[g]);
        libm::acos(((trace - 1.0) / 2.0).clamp(-1.0, 1.0))
    }
}
