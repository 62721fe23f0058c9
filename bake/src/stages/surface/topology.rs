//! Connectivity of the mesh surface. Triangles share points, which are joined by position, and edges; an edge has at
//! most two triangles.

use glam::DVec3;

/// Index for no half-edge: the edge is a border of the mesh.
pub(super) const NONE: u32 = u32::MAX;

/// Half-edge mesh of triangles. Half-edge `3 f + k` leads from corner `k` of face `f` to the next corner,
/// counter-clockwise.
#[derive(Clone, Debug, Default)]
pub(super) struct Topology {
    /// Positions at rest, metres. All positions differ by more than rounding errors.
    pub(super) points: Vec<DVec3>,
    /// Indices of the three different points of each face.
    pub(super) faces: Vec<[u32; 3]>,
    /// Twin of each half-edge, which runs in the opposite direction along the same edge, or [`NONE`].
    pub(super) twins: Vec<u32>,
    /// Unit normal of each face.
    pub(super) normals: Vec<DVec3>,
    /// Area of each face, square metres, greater than 0.
    pub(super) areas: Vec<f64>,
}

impl Topology {
    /// Creates the topology. Each of `faces` must have three different points and an area.
    pub(super) fn new(points: Vec<DVec3>, faces: Vec<[u32; 3]>, twins: Vec<u32>) -> Self {
        let mut out = Self { points, faces, twins, ..Self::default() };
        for f in 0..out.faces.len() {
            let [a, b, c] = out.corners(f);
            let cross = (b - a).cross(c - a);
            out.areas.push(cross.length() / 2.0);
            out.normals.push(cross.normalize_or(DVec3::Z));
        }
        out
    }

    pub(super) fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|p| self.points[p as usize])
    }

    pub(super) fn centroid(&self, face: usize) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (a + b + c) / 3.0
    }

    pub(super) fn ends(&self, half_edge: u32) -> [u32; 2] {
        let (f, k) = (half_edge as usize / 3, half_edge as usize % 3);
        [self.faces[f][k], self.faces[f][(k + 1) % 3]]
    }

    pub(super) fn edge_length(&self, half_edge: u32) -> f64 {
        let [a, b] = self.ends(half_edge);
        self.points[a as usize].distance(self.points[b as usize])
    }

    /// Numbers the connected regions in the order of their first faces. `joined` returns whether the faces on both
    /// sides of a half-edge are connected; borders of the mesh are not queried.
    pub(super) fn regions(&self, joined: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut region = vec![NONE; self.faces.len()];
        let (mut count, mut stack) = (0, Vec::new());
        for first in 0..region.len() {
            if region[first] != NONE {
                continue;
            }
            region[first] = count;
            stack.push(first);
            while let Some(f) = stack.pop() {
                for (h, g) in self.neighbors(f) {
                    if region[g] == NONE && joined(h) {
                        region[g] = count;
                        stack.push(g);
                    }
                }
            }
            count += 1;
        }
        region
    }

    /// Returns up to three faces across the edges of `face`, each with the half-edge of `face` that leads to it.
    pub(super) fn neighbors(&self, face: usize) -> impl Iterator<Item = (u32, usize)> + '_ {
        (3 * face as u32..3 * face as u32 + 3).filter_map(|h| {
            let twin = self.twins[h as usize];
            (twin != NONE).then_some((h, twin as usize / 3))
        })
    }
}

/// Distance used as a heap key; never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Key(pub(super) f64);

impl Eq for Key {}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Returns the half-edge before `h` in its face.
pub(super) fn prev(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}
