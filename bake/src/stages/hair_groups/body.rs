//! Mesh in the rest pose, with queries for the nearest surface point.

use crate::stages::cells::{TriangleGrid, closest_barycentric};
use glam::Vec3;
use pelage_formats::TrianglePoint;
use pelage_formats::meaning::hair_groups::triangle_frame;

/// Triangles of a mesh in the rest pose.
pub(super) struct SurfaceIndex<'a> {
    pub(super) triangles: &'a [[u32; 3]],
    positions: &'a [Vec3],
    normals: &'a [Vec3],
    cells: TriangleGrid,
    /// Mean edge length, metres.
    edge_m: f32,
}

/// Surface point nearest to a query point.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint {
    pub(super) at: TrianglePoint,
    pub(super) place: Vec3,
    /// Surface normal at that point, a unit vector.
    pub(super) normal: Vec3,
    pub(super) distance_m: f32,
}

impl<'a> SurfaceIndex<'a> {
    pub(super) fn new(triangles: &'a [[u32; 3]], positions: &'a [Vec3], normals: &'a [Vec3]) -> Self {
        let place = |v: u32| positions[v as usize];
        let edges: f32 = triangles.iter().map(|t| place(t[0]).distance(place(t[1]))).sum();
        let edge_m = (edges / triangles.len().max(1) as f32).max(1e-9);
        Self { triangles, positions, normals, cells: TriangleGrid::new(triangles, &place, edge_m), edge_m }
    }

    pub(super) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|v| self.positions[v as usize])
    }

    /// Returns the surface normal, a unit vector.
    pub(super) fn normal(&self, at: &TrianglePoint) -> Vec3 {
        let [a, b, c] = self.triangles[at.triangle as usize].map(|v| self.normals[v as usize]);
        let mixed = a * at.weights[0] + b * at.weights[1] + c * at.weights[2];
        mixed.try_normalize().unwrap_or(Vec3::Y)
    }

    /// Returns the nearest surface point within `reach_m` metres, on the triangles that `of` accepts.
    pub(super) fn nearest(&self, p: Vec3, reach_m: f32, of: impl Fn(u32) -> bool) -> Option<SurfacePoint> {
        // Most query points are near the surface, so the search starts small and widens only if it finds nothing.
        let mut reach = self.edge_m.min(reach_m);
        loop {
            let found = self.nearest_within(p, reach, &of);
            if found.is_some() || reach >= reach_m {
                return found;
            }
            reach = (2.0 * reach).min(reach_m);
        }
    }

    fn nearest_within(&self, p: Vec3, reach_m: f32, of: &impl Fn(u32) -> bool) -> Option<SurfacePoint> {
        let mut found: Option<SurfacePoint> = None;
        for triangle in self.cells.within(p, reach_m).filter(|t| of(*t)) {
            let at = TrianglePoint { triangle, weights: closest_barycentric(p, self.corners(triangle)).to_array() };
            let place = at.position(self.corners(triangle));
            let distance_m = place.distance(p);
            let nearer = found.is_none_or(|f| (distance_m, triangle) < (f.distance_m, f.at.triangle));
            if distance_m <= reach_m && nearer {
                found = Some(SurfacePoint { at, place, normal: Vec3::ZERO, distance_m });
            }
        }
        found.map(|near| SurfacePoint { normal: self.normal(&near.at), ..near })
    }

    /// Returns the signed distance of `p` from the surface, metres, and the nearest surface point. The distance is
    /// negative inside the body. The result is `None` if the surface is farther than `reach_m`.
    pub(super) fn signed_distance(&self, p: Vec3, reach_m: f32) -> Option<(f32, SurfacePoint)> {
        let near = self.nearest(p, reach_m, |_| true)?;
        let outside = (p - near.place).dot(near.normal) >= 0.0;
        Some((if outside { near.distance_m } else { -near.distance_m }, near))
    }

    /// Converts guides to the form that a package stores: points relative to the root, in the frame of its triangle,
    /// without the root itself.
    pub(super) fn in_frames(&self, guides: &[(TrianglePoint, Vec<Vec3>)]) -> Vec<(TrianglePoint, Vec<Vec3>)> {
        let local = |(root, points): &(TrianglePoint, Vec<Vec3>)| {
            let frame = triangle_frame(self.corners(root.triangle)).transpose();
            (*root, points[1..].iter().map(|p| frame * (*p - points[0])).collect())
        };
        guides.iter().map(local).collect()
    }
}
