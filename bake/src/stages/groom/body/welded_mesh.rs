//! Mesh welded into one surface: vertices at the same position are joined across parts, seams and materials.

use glam::Vec3;
use pelage_import::mesh::{Mesh, RestPose};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Limits of the cotangents that weight edges. Without limits, degenerate triangles would give unbounded cotangents. A
/// positive lower limit ensures that averages over neighbours stay within their range.
const COTANGENTS: (f64, f64) = (0.02, 20.0);
/// Maximum number of solver steps, and relative residual at which the solver stops.
const SOLVER: (usize, f64) = (100, 1e-4);

/// Welded mesh at rest and its connectivity. Lengths are in mesh radii around the mesh's centre, so that constants suit
/// all models.
#[derive(Clone, Debug, Default)]
pub(crate) struct WeldedMesh {
    /// Welded vertex of each vertex of the mesh.
    pub place_of: Vec<u32>,
    /// Position of each welded vertex.
    pub positions: Vec<Vec3>,
    /// Normal of each welded vertex: unit length, outward.
    pub normals: Vec<Vec3>,
    /// Area of each welded vertex: a third of the area of its triangles.
    pub areas: Vec<f32>,
    /// Triangles of the mesh, in its order, with indices of welded vertices.
    pub faces: Vec<[u32; 3]>,
    /// Connected component of each welded vertex.
    pub pieces: Vec<u32>,
    /// Start of the neighbours of each welded vertex: vertex `i` has `neighbors[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    neighbors: Vec<Neighbor>,
}

/// Neighbour of a welded vertex, at the other end of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Neighbor {
    place: u32,
    length: f32,
    /// Half the sum of the cotangents of the angles opposite the edge.
    weight: f64,
}

impl WeldedMesh {
    /// Welds a mesh in its rest pose, metres.
    ///
    /// * `center`, `radius_m`: origin and unit of lengths; the radius is above 0
    pub(crate) fn new(mesh: &Mesh, rest: &RestPose, center: Vec3, radius_m: f32) -> Self {
        let bits =
            |v: usize| rest.positions.get(v).map(|p| (*p + 0.0).to_array().map(f32::to_bits)).unwrap_or_default();
        let mut order: Vec<u32> = (0..rest.positions.len() as u32).collect();
        order.sort_unstable_by_key(|v| (bits(*v as usize), *v));
        let mut skin = Self { place_of: vec![0; order.len()], ..Self::default() };
        let mut last = None;
        for v in order.into_iter().map(|v| v as usize) {
            let here = bits(v);
            if last != Some(here) {
                skin.positions.push((rest.positions[v] - center) / radius_m);
                last = Some(here);
            }
            skin.place_of[v] = skin.positions.len() as u32 - 1;
        }
        let count = skin.positions.len();
        skin.faces = mesh.triangles.iter().map(|t| t.map(|v| skin.place_of[v as usize])).collect();
        skin.areas = vec![0.0; count];
        skin.normals = vec![Vec3::ZERO; count];
        let mut edges: Vec<(u32, u32, f64)> = Vec::with_capacity(6 * skin.faces.len());
        for face in &skin.faces {
            let corners = face.map(|p| skin.positions[p as usize]);
            let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            for k in 0..3 {
                let (a, b, c) = (face[k], face[(k + 1) % 3], face[(k + 2) % 3]);
                skin.areas[a as usize] += across.length() / 6.0;
                skin.normals[a as usize] += across;
                if a != b {
                    let [p, q, r] = [a, b, c].map(|p| skin.positions[p as usize].as_dvec3());
                    let (u, v) = (p - r, q - r);
                    let cotangent = u.dot(v) / u.cross(v).length().max(1e-30);
                    let weight = 0.5 * cotangent.clamp(COTANGENTS.0, COTANGENTS.1);
                    edges.extend([(a, b, weight), (b, a, weight)]);
                }
            }
        }
        skin.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        edges.sort_unstable_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
        skin.starts = vec![0; count + 1];
        let mut from = None;
        for (a, b, weight) in edges {
            match skin.neighbors.last_mut().filter(|_| from == Some((a, b))) {
                Some(same) => same.weight += weight,
                None => {
                    let length = skin.positions[a as usize].distance(skin.positions[b as usize]);
                    skin.neighbors.push(Neighbor { place: b, length, weight });
                    skin.starts[a as usize + 1] = skin.neighbors.len() as u32;
                }
            }
            from = Some((a, b));
        }
        for place in 0..count {
            skin.starts[place + 1] = skin.starts[place + 1].max(skin.starts[place]);
        }
        skin.number_pieces();
        skin
    }

    fn number_pieces(&mut self) {
        let mut pieces = vec![u32::MAX; self.positions.len()];
        let (mut count, mut stack) = (0, Vec::new());
        for first in 0..pieces.len() {
            if pieces[first] != u32::MAX {
                continue;
            }
            pieces[first] = count;
            stack.push(first);
            while let Some(place) = stack.pop() {
                for next in self.around(place) {
                    if pieces[next.place as usize] == u32::MAX {
                        pieces[next.place as usize] = count;
                        stack.push(next.place as usize);
                    }
                }
            }
            count += 1;
        }
        self.pieces = pieces;
    }

    /// Returns the number of welded vertices.
    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    fn around(&self, place: usize) -> &[Neighbor] {
        &self.neighbors[self.starts[place] as usize..self.starts[place + 1] as usize]
    }

    /// Returns the neighbours of a welded vertex.
    pub(crate) fn neighbors_of(&self, place: u32) -> impl Iterator<Item = u32> {
        self.around(place as usize).iter().map(|neighbor| neighbor.place)
    }

    /// Returns the distance of each welded vertex from the nearest of `seeds` along the edges (Dijkstra 1959). It is
    /// infinite beyond `reach`. Each seed has an initial distance.
    pub(crate) fn distances(&self, seeds: impl Iterator<Item = (u32, f32)>, reach: f32) -> Vec<f32> {
        let mut distances = vec![f32::INFINITY; self.len()];
        // For non-negative floats, the bit patterns sort like the values.
        let mut front: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
        for (place, distance) in seeds {
            let distance = distance.max(0.0);
            if distance <= reach && distance < distances[place as usize] {
                distances[place as usize] = distance;
                front.push(Reverse((distance.to_bits(), place)));
            }
        }
        while let Some(Reverse((bits, place))) = front.pop() {
            let here = f32::from_bits(bits);
            if here > distances[place as usize] {
                continue;
            }
            for next in self.around(place as usize) {
                let there = here + next.length;
                if there <= reach && there < distances[next.place as usize] {
                    distances[next.place as usize] = there;
                    front.push(Reverse((there.to_bits(), next.place)));
                }
            }
        }
        distances
    }

    /// Smooths values over the surface by heat diffusion, with a Gaussian width of about `width`. It solves one
    /// implicit step (Desbrun et al. 1999), (A + t·L)·x = A·values with t = width² / 2, by conjugate gradients. The
    /// result stays within the range of the values.
    pub(crate) fn spread(&self, values: &[f32], width: f32) -> Vec<f32> {
        let time = 0.5 * f64::from(width) * f64::from(width);
        // A vertex without area has no weight, but must get a value.
        let areas: Vec<f64> = self.areas.iter().map(|a| f64::from(*a).max(1e-12)).collect();
        let flow = |place: usize| self.around(place).iter().map(|n| n.weight).sum::<f64>();
        let diagonal: Vec<f64> = areas.iter().enumerate().map(|(i, a)| a + time * flow(i)).collect();
        // Rows are independent, so the result does not depend on the number of threads.
        let apply = |x: &[f64]| -> Vec<f64> {
            let row = |i: usize| {
                diagonal[i] * x[i] - time * self.around(i).iter().map(|n| n.weight * x[n.place as usize]).sum::<f64>()
            };
            (0..x.len()).into_par_iter().with_min_len(4096).map(row).collect()
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };

        let start: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
        let (mut x, applied) = (start.clone(), apply(&start));
        let mut residual: Vec<f64> = (0..x.len()).map(|i| areas[i] * start[i] - applied[i]).collect();
        let mut way = scaled(&residual);
        let mut size = dot(&residual, &way);
        let enough = SOLVER.1 * SOLVER.1 * size;
        for _ in 0..SOLVER.0 {
            if size <= enough || size <= 0.0 {
                break;
            }
            let along = apply(&way);
            let step = size / dot(&way, &along);
            for i in 0..x.len() {
                x[i] += step * way[i];
                residual[i] -= step * along[i];
            }
            let next = scaled(&residual);
            let new = dot(&residual, &next);
            for (way, next) in way.iter_mut().zip(next) {
                *way = next + *way * (new / size);
            }
            size = new;
        }
        let low = values.iter().copied().fold(f32::INFINITY, f32::min);
        let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        x.into_iter().map(|x| (x as f32).clamp(low, high.max(low))).collect()
    }

    /// Returns an area-weighted quantile: 0.5 is the median. `None` if no vertex has both an area and a value.
    pub(crate) fn quantile(&self, values: &[Option<f32>], share: f64) -> Option<f32> {
        let mut found: Vec<(f32, f32)> =
            values.iter().zip(&self.areas).filter_map(|(v, area)| Some(((*v)?, *area))).collect();
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let total: f64 = found.iter().map(|(_, area)| f64::from(*area)).sum();
        let mut below = 0.0;
        found
            .iter()
            .find(|(_, area)| {
                below += f64::from(*area);
                below >= share * total
            })
            .map(|(value, _)| *value)
            .filter(|_| total > 0.0)
    }
}
