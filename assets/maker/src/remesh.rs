//! Isotropic remeshing on an implicit surface. Each round splits long edges, collapses short ones, and flips edges
//! towards valence six. It then relaxes vertices in the tangent plane and projects them back onto the surface (Botsch
//! and Kobbelt 2004, "A Remeshing Approach to Multiresolution Modeling").
//!
//! Quadric decimation is more accurate for the same number of triangles. Remeshing gives the even, well-shaped
//! triangles that texture charts and skinning need, and its vertices are exactly on the surface.

use std::collections::BTreeSet;

use glam::DVec3;

use super::{
    sdf::{normal, project},
    trimesh::TriMesh,
};

/// Target edge lengths over the surface.
#[derive(Clone, Copy, Debug)]
pub struct Sizing {
    /// Target distance between an edge's midpoint and the surface, metres.
    pub sagitta: f64,
    /// Least edge length, metres.
    pub shortest: f64,
    /// Greatest edge length, metres.
    pub longest: f64,
    /// Greatest edge length at a point, metres; may be below `shortest`. Used for areas that need more detail than
    /// their curvature suggests.
    pub local: fn(DVec3) -> f64,
}

/// Returns `f64::MAX`, so that the edge length follows from the curvature alone.
pub fn no_local_limit(_: DVec3) -> f64 {
    f64::MAX
}

/// Remeshes in place with `rounds` rounds. `field` is negative inside. The mesh must be a closed manifold, and stays
/// one.
pub fn remesh(mesh: &mut TriMesh, field: &dyn Fn(DVec3) -> f64, sizing: Sizing, rounds: usize) {
    let mut work = Remesher::new(mesh, field, 2.0 * sizing.sagitta);
    for _ in 0..rounds {
        let wanted = work.edge_lengths(sizing);
        let wanted = work.split(wanted);
        work.collapse(&wanted);
        work.flip();
        work.relax();
    }
    *mesh = work.finish();
}

struct Remesher<'a> {
    positions: Vec<DVec3>,
    /// Corner indices; a removed triangle has three equal ones.
    triangles: Vec<[u32; 3]>,
    /// Triangles around each vertex, unordered.
    fans: Vec<Vec<u32>>,
    field: &'a dyn Fn(DVec3) -> f64,
    /// Greatest distance allowed between surface and triangles after a change, metres.
    tolerance: f64,
}

fn alive(t: &[u32; 3]) -> bool {
    t[0] != t[1]
}

impl<'a> Remesher<'a> {
    fn new(mesh: &TriMesh, field: &'a dyn Fn(DVec3) -> f64, tolerance: f64) -> Self {
        let mut fans = vec![Vec::new(); mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for &v in corners {
                fans[v as usize].push(t as u32);
            }
        }
        let positions = mesh.positions.iter().map(|&p| project(field, p, 8)).collect();
        Self { positions, triangles: mesh.triangles.clone(), fans, field, tolerance }
    }

    fn finish(self) -> TriMesh {
        let triangles = self.triangles.into_iter().filter(alive).collect();
        let mut mesh = TriMesh { positions: self.positions, triangles };
        mesh.drop_unused_vertices();
        mesh
    }

    fn position(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }

    fn ring(&self, v: u32) -> BTreeSet<u32> {
        let fan = self.fans[v as usize].iter();
        fan.flat_map(|&t| self.triangles[t as usize]).filter(|&w| w != v).collect()
    }

    fn edges(&self) -> Vec<(u32, u32)> {
        let directed = self.triangles.iter().filter(|t| alive(t)).flat_map(|t| (0..3).map(|k| (t[k], t[(k + 1) % 3])));
        directed.filter(|(a, b)| a < b).collect()
    }

    /// Returns the two triangles at the edge `(a, b)`. In the first triangle, corner b follows corner a.
    fn wings(&self, a: u32, b: u32) -> Option<(u32, u32)> {
        let holds = |t: u32, from, to| {
            let c = self.triangles[t as usize];
            (0..3).any(|k| c[k] == from && c[(k + 1) % 3] == to)
        };
        let left = self.fans[a as usize].iter().copied().find(|&t| holds(t, a, b))?;
        let right = self.fans[a as usize].iter().copied().find(|&t| holds(t, b, a))?;
        Some((left, right))
    }

    fn opposite(&self, t: u32, a: u32, b: u32) -> u32 {
        let corners = self.triangles[t as usize];
        corners.into_iter().find(|&v| v != a && v != b).unwrap_or(a)
    }

    /// Returns the target edge length at each vertex, metres. It is the chord that has the target sagitta at the
    /// greatest normal curvature, smoothed so that neighbours differ little.
    fn edge_lengths(&self, sizing: Sizing) -> Vec<f64> {
        let step = 2e-3;
        let curvature_length = |p: DVec3| {
            let n = normal(self.field, p);
            let tangent = n.any_orthonormal_vector();
            let across = n.cross(tangent);
            let turn = |d: DVec3| (normal(self.field, p + d * step) - normal(self.field, p - d * step)) / (2.0 * step);
            // Largest eigenvalue magnitude of the symmetric 2x2 shape operator.
            let (du, dv) = (turn(tangent), turn(across));
            let (a, b, c) = (du.dot(tangent), 0.5 * (du.dot(across) + dv.dot(tangent)), dv.dot(across));
            let mean = 0.5 * (a + c);
            let curvature = mean.abs() + (0.25 * (a - c) * (a - c) + b * b).sqrt();
            (8.0 * sizing.sagitta / curvature.max(1e-6))
                .sqrt()
                .clamp(sizing.shortest, sizing.longest)
                .min((sizing.local)(p))
        };
        // Collapsed vertices have no triangles, and their target lengths are not computed. Most vertices of the first
        // mesh are soon collapsed.
        let length = |(&p, fan): (&DVec3, &Vec<u32>)| if fan.is_empty() { 0.0 } else { curvature_length(p) };
        let mut wanted: Vec<f64> = self.positions.iter().zip(&self.fans).map(length).collect();
        for _ in 0..3 {
            wanted = (0..wanted.len())
                .map(|v| {
                    let ring = self.ring(v as u32);
                    let sum: f64 = ring.iter().map(|&w| wanted[w as usize]).sum();
                    if ring.is_empty() { wanted[v] } else { 0.5 * (wanted[v] + sum / ring.len() as f64) }
                })
                .collect();
        }
        wanted
    }

    fn split(&mut self, mut wanted: Vec<f64>) -> Vec<f64> {
        for (a, b) in self.edges() {
            let target = 0.5 * (wanted[a as usize] + wanted[b as usize]);
            let (pa, pb) = (self.position(a), self.position(b));
            if (pa - pb).length() <= target * 4.0 / 3.0 {
                continue;
            }
            let Some((left, right)) = self.wings(a, b) else { continue };
            let middle = self.positions.len() as u32;
            self.positions.push(project(self.field, (pa + pb) * 0.5, 8));
            wanted.push(target);
            self.fans.push(Vec::new());
            // Each of the two triangles keeps the half with `a`; the half with `b` becomes a new triangle.
            for t in [left, right] {
                let old = self.triangles[t as usize];
                let new = self.triangles.len() as u32;
                self.triangles.push(old.map(|v| if v == a { middle } else { v }));
                self.triangles[t as usize] = old.map(|v| if v == b { middle } else { v });
                let c = self.opposite(t, a, middle);
                self.fans[b as usize].retain(|&x| x != t);
                self.fans[b as usize].push(new);
                self.fans[c as usize].push(new);
                self.fans[middle as usize].extend([t, new]);
            }
        }
        wanted
    }

    fn collapse(&mut self, wanted: &[f64]) {
        for (a, b) in self.edges() {
            let Some((left, right)) = self.wings(a, b) else { continue };
            let target = 0.5 * (wanted[a as usize] + wanted[b as usize]);
            if (self.position(a) - self.position(b)).length() >= target * 0.8 {
                continue;
            }
            let (ring_a, ring_b) = (self.ring(a), self.ring(b));
            // Link condition: the only common neighbours of `a` and `b` may be the two opposite corners, else the
            // surface would pinch. An opposite corner of valence three is not allowed either, because the surface would
            // fold onto itself there.
            let tips = [self.opposite(left, a, b), self.opposite(right, a, b)];
            if ring_a.intersection(&ring_b).count() != 2 || tips.iter().any(|&c| self.fans[c as usize].len() <= 3) {
                continue;
            }
            let middle = project(self.field, (self.position(a) + self.position(b)) * 0.5, 8);
            let too_long = |&v: &u32| {
                let limit = (wanted[v as usize] + target) * 0.5 * 4.0 / 3.0;
                v != a && v != b && (self.position(v) - middle).length() > limit
            };
            if ring_a.union(&ring_b).any(too_long) || self.would_rotate(a, b, middle) || self.would_rotate(b, a, middle)
            {
                continue;
            }
            // Without this check, thin parts such as ears erode at their rims.
            if self.fan_error(a, b, middle).max(self.fan_error(b, a, middle)) > self.tolerance {
                continue;
            }
            self.positions[a as usize] = middle;
            for t in [left, right] {
                for v in self.triangles[t as usize] {
                    self.fans[v as usize].retain(|&x| x != t);
                }
                self.triangles[t as usize] = [0; 3];
            }
            for t in std::mem::take(&mut self.fans[b as usize]) {
                for v in &mut self.triangles[t as usize] {
                    if *v == b {
                        *v = a;
                    }
                }
                self.fans[a as usize].push(t);
            }
        }
    }

    /// Returns true if moving `v` to `to` would rotate one of its triangles by more than 45 degrees, ignoring those
    /// that contain `other`.
    fn would_rotate(&self, v: u32, other: u32, to: DVec3) -> bool {
        self.fans[v as usize].iter().map(|&t| self.triangles[t as usize]).filter(|c| !c.contains(&other)).any(|c| {
            let face = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]);
            let before = face(c.map(|w| self.position(w)));
            let after = face(c.map(|w| if w == v { to } else { self.position(w) }));
            before.dot(after) < 0.7 * before.length() * after.length() || after.length() < 1e-9
        })
    }

    /// Returns the greatest distance from the surface to the midpoints of a triangle and of its edges.
    fn error(&self, p: [DVec3; 3]) -> f64 {
        let middles = [(p[0] + p[1]) * 0.5, (p[1] + p[2]) * 0.5, (p[2] + p[0]) * 0.5, (p[0] + p[1] + p[2]) / 3.0];
        middles.into_iter().fold(0.0, |worst, m| (self.field)(m).abs().max(worst))
    }

    /// Returns the greatest [`Self::error`] of the triangles around `v` if `v` were at `to`, ignoring those that
    /// contain `other`.
    fn fan_error(&self, v: u32, other: u32, to: DVec3) -> f64 {
        let fan = self.fans[v as usize].iter().map(|&t| self.triangles[t as usize]).filter(|c| !c.contains(&other));
        let moved = |c: [u32; 3]| c.map(|w| if w == v { to } else { self.position(w) });
        fan.fold(0.0, |worst, c| self.error(moved(c)).max(worst))
    }

    fn flip(&mut self) {
        for (a, b) in self.edges() {
            let Some((left, right)) = self.wings(a, b) else { continue };
            let (c, d) = (self.opposite(left, a, b), self.opposite(right, a, b));
            let valence = |v: u32| self.fans[v as usize].len() as i32;
            let excess = |n: i32| (n - 6) * (n - 6);
            let before = excess(valence(a)) + excess(valence(b)) + excess(valence(c)) + excess(valence(d));
            let after =
                excess(valence(a) - 1) + excess(valence(b) - 1) + excess(valence(c) + 1) + excess(valence(d) + 1);
            if after >= before || valence(a) <= 3 || valence(b) <= 3 || c == d || self.ring(c).contains(&d) {
                continue;
            }
            let (new_left, new_right) = ([a, d, c], [d, b, c]);
            let area = |t: [u32; 3]| {
                let p = t.map(|v| self.position(v));
                (p[1] - p[0]).cross(p[2] - p[0])
            };
            let old = (area(self.triangles[left as usize]) + area(self.triangles[right as usize])).normalize_or_zero();
            // Both new triangles must face in about the same direction as the old pair, and the new edge must not cut a
            // corner of the surface.
            let smooth = |t: [u32; 3]| area(t).normalize_or_zero().dot(old) > 0.8;
            let off = |t: [u32; 3]| self.error(t.map(|v| self.position(v)));
            let before = off(self.triangles[left as usize]).max(off(self.triangles[right as usize]));
            if !smooth(new_left) || !smooth(new_right) || off(new_left).max(off(new_right)) > before.max(self.tolerance)
            {
                continue;
            }
            self.triangles[left as usize] = new_left;
            self.triangles[right as usize] = new_right;
            self.fans[b as usize].retain(|&t| t != left);
            self.fans[a as usize].retain(|&t| t != right);
            self.fans[c as usize].push(right);
            self.fans[d as usize].push(left);
        }
    }

    /// Moves each vertex towards the area-weighted centre of its triangles, within the tangent plane.
    fn relax(&mut self) {
        let moved: Vec<DVec3> = (0..self.positions.len())
            .map(|v| {
                let p = self.positions[v];
                let (mut sum, mut total) = (DVec3::ZERO, 0.0);
                for &t in &self.fans[v] {
                    let c = self.triangles[t as usize].map(|w| self.position(w));
                    let area = (c[1] - c[0]).cross(c[2] - c[0]).length();
                    sum += (c[0] + c[1] + c[2]) / 3.0 * area;
                    total += area;
                }
                if total <= 0.0 {
                    return p;
                }
                let n = normal(self.field, p);
                let step = sum / total - p;
                project(self.field, p + (step - n * step.dot(n)) * 0.8, 8)
            })
            .collect();
        for (v, to) in moved.into_iter().enumerate() {
            let v = v as u32;
            if self.would_rotate(v, u32::MAX, to) {
                continue;
            }
            // The error before the move is computed only if the error after it is too large, which is rare.
            let after = self.fan_error(v, u32::MAX, to);
            if after <= self.tolerance || after <= self.fan_error(v, u32::MAX, self.position(v)) {
                self.positions[v as usize] = to;
            }
        }
    }
}
