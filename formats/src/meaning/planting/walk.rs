//! Walks on the mesh surface by steps in tile coordinates: the path of a strand that extends beyond its triangle.
//!
//! Within a triangle, a step is a straight line. At an edge it continues in the neighbouring triangle, with that
//! triangle's own tile gradients. Within a patch, this gives the same line in tile coordinates. Tile coordinates jump
//! across a patch border, but the comb's frame is continuous there, and the walk keeps its direction in that frame.
//!
//! A step nearly parallel to a patch border may point across the border on both of its sides. Each side would then lead
//! back to the other. In this case the walk follows the edge by the component along it. Without a neighbour to continue
//! in, the walk leaves the surface straight ahead in the plane of its last triangle.

use super::PlantingMesh;
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Marker for a missing triangle.
const NONE: u32 = u32::MAX;
/// Maximum number of edges crossed in a single step; a walk that crosses more is going in circles.
const MAX_CROSSINGS: u32 = 256;
/// Minimum of 2 A / s², where A is the area of a triangle in tile coordinates and s its longest side. Below it, the
/// coordinates are unusable.
const LEAST_AREA: f64 = 1e-9;

/// Adjacency of triangles, and gradients of the tile coordinates in them.
#[derive(Clone, Debug)]
pub struct SurfaceWalk<'a> {
    ground: &'a PlantingMesh,
    /// For each corner, the triangle across the opposite edge; `NONE` at borders and where more than two triangles
    /// meet.
    across: Vec<[u32; 3]>,
    /// For each triangle, the change of the three corner weights along u and along v; `None` if no walk can enter it.
    gradients: Vec<Option<[DVec3; 2]>>,
}

/// Position of a walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WalkPosition {
    /// Index of the triangle.
    pub triangle: usize,
    /// Weights of the triangle's corners; non-negative, with sum 1.
    pub weights: DVec3,
    /// Offset from the point given by `weights`, tile coordinates, once the walk has left the surface.
    pub beyond: Option<DVec2>,
}

/// Events along a walk.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WalkEvents {
    /// The walk crossed an edge on which tile coordinates jump.
    pub patch_border: bool,
    /// The walk reached the end of the mesh or of the furred part.
    pub mesh_border: bool,
    /// The walk followed a patch border along its edge, because the step pointed across the border on both sides.
    pub slid: bool,
    /// The walk crossed too many edges in one step and left the surface.
    pub lost: bool,
}

impl<'a> SurfaceWalk<'a> {
    /// Computes adjacency and gradients of the furred triangles.
    pub fn new(ground: &'a PlantingMesh) -> Self {
        let mut sides: HashMap<[u32; 2], Vec<(u32, usize)>> = HashMap::new();
        for (t, triangle) in ground.triangles.iter().enumerate() {
            let p = triangle.map(|v| ground.same_place[v as usize]);
            for k in 0..3 {
                let (a, b) = (p[(k + 1) % 3], p[(k + 2) % 3]);
                sides.entry([a.min(b), a.max(b)]).or_default().push((t as u32, k));
            }
        }
        let mut across = vec![[NONE; 3]; ground.triangles.len()];
        for pair in sides.values() {
            if let [(t, k), (s, l)] = pair[..] {
                across[t as usize][k] = s;
                across[s as usize][l] = t;
            }
        }
        let gradients = (0..ground.triangles.len()).map(|t| gradients(ground, t)).collect();
        Self { ground, across, gradients }
    }

    /// Whether hair can root in a triangle.
    pub fn is_furred(&self, triangle: usize) -> bool {
        self.gradients[triangle].is_some()
    }

    /// Moves the walk by `by`, in tile coordinates.
    pub fn step(&self, from: &mut WalkPosition, by: DVec2, crossed: &mut WalkEvents) {
        if let Some(way) = &mut from.beyond {
            *way += by;
            return;
        }
        let mut left = by;
        // Corner opposite the edge that the walk crossed to enter the triangle.
        let mut came_over = None;
        for _ in 0..MAX_CROSSINGS {
            let Some([along_u, along_v]) = self.gradients[from.triangle] else { break };
            let mut change = along_u * left.x + along_v * left.y;
            if let Some(k) = came_over
                && from.weights[k] == 0.0
                && change[k] < 0.0
            {
                crossed.slid = true;
                change = self.along_edge(from.triangle, k, change);
            }
            // First edge that the step crosses, and the share of the step before that edge.
            let (mut edge, mut share) = (None, 1.0);
            for k in 0..3 {
                if change[k] < 0.0 && from.weights[k] + change[k] * share < 0.0 {
                    (edge, share) = (Some(k), (from.weights[k] / -change[k]).clamp(0.0, share));
                }
            }
            from.weights = (from.weights + change * share).max(DVec3::ZERO);
            let Some(edge) = edge else {
                from.weights /= from.weights.element_sum();
                return;
            };
            from.weights[edge] = 0.0;
            from.weights /= from.weights.element_sum();
            left *= 1.0 - share;
            let next = self.across[from.triangle][edge];
            if next == NONE || self.gradients[next as usize].is_none() {
                crossed.mesh_border = true;
                from.beyond = Some(left);
                return;
            }
            came_over = self.enter(from, next as usize, crossed);
        }
        crossed.lost = true;
        from.beyond = Some(left);
    }

    /// Projects a change of the weights onto the edge opposite corner `k`.
    fn along_edge(&self, triangle: usize, k: usize, change: DVec3) -> DVec3 {
        let corners = self.ground.corners(triangle, &self.ground.positions);
        let way = corners[0] * change.x + corners[1] * change.y + corners[2] * change.z;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let edge = corners[j] - corners[i];
        let share = way.dot(edge) / edge.length_squared();
        let mut along = DVec3::ZERO;
        if share.is_finite() {
            (along[i], along[j]) = (-share, share);
        }
        along
    }

    /// Crosses an edge into the neighbour `next`; returns the neighbour's corner opposite that edge.
    fn enter(&self, from: &mut WalkPosition, next: usize, crossed: &mut WalkEvents) -> Option<usize> {
        let (here, there) = (self.ground.triangles[from.triangle], self.ground.triangles[next]);
        let place = |v: u32| self.ground.same_place[v as usize];
        let mut weights = DVec3::ZERO;
        let mut opposite = None;
        for (k, v) in there.iter().enumerate() {
            match (0..3).find(|j| place(here[*j]) == place(*v)) {
                Some(j) => {
                    weights[k] = from.weights[j];
                    let tile_uv = |v: u32| self.ground.tile_uv[v as usize];
                    crossed.patch_border |= tile_uv(here[j]) != tile_uv(*v);
                }
                None => opposite = Some(k),
            }
        }
        *from = WalkPosition { triangle: next, weights: weights / weights.element_sum(), beyond: None };
        opposite
    }

    /// Returns the weights of the corners at the walk's position. Once the walk has left the surface, the position is
    /// in the plane of its last triangle, and weights may be negative.
    pub fn place_weights(&self, at: &WalkPosition) -> DVec3 {
        match (at.beyond, self.gradients[at.triangle]) {
            (Some(way), Some([along_u, along_v])) => at.weights + along_u * way.x + along_v * way.y,
            _ => at.weights,
        }
    }
}

/// Returns the changes of a triangle's weights along u and v; `None` for a triangle that is bare or whose coordinates
/// are degenerate.
fn gradients(ground: &PlantingMesh, triangle: usize) -> Option<[DVec3; 2]> {
    if !ground.furred[triangle] {
        return None;
    }
    let [a, b, c] = ground.corners(triangle, &ground.tile_uv);
    let (e, f) = (b - a, c - a);
    let area = e.perp_dot(f);
    let longest = e.length_squared().max(f.length_squared()).max((f - e).length_squared());
    if area.abs() <= LEAST_AREA * longest || !area.is_finite() {
        return None;
    }
    let along = |u: f64, v: f64| {
        let (second, third) = ((u * f.y - v * f.x) / area, (v * e.x - u * e.y) / area);
        DVec3::new(-second - third, second, third)
    };
    Some([along(1.0, 0.0), along(0.0, 1.0)])
}
