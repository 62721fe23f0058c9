//! Tile coordinates of one patch by least squares (Praun, Finkelstein and Hoppe 2000, §4.2).
//!
//! Let S, T be a face's tile frame and s the tile's width. On each face, the map should take S to (1/s, 0) and T to (0,
//! 1/s). With weights by area, the matrix of the normal equations is the cotangent Laplacian, the same for u and v. So
//! one sparse Cholesky factorisation serves both, and also every later round with rotated targets.

use super::sparse::Symmetric;
use super::topology::Topology;
use glam::{DMat2, DVec2, DVec3};

/// Tile frame of a face: unit vectors in its plane, S × T = N.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceFrame {
    pub(super) s: DVec3,
    pub(super) t: DVec3,
    /// Width of a tile on the mesh surface, metres.
    pub(super) tile_m: f64,
}

/// Returns the gradients of the three barycentric coordinates in the face's frame (S, T); column i is (∇λᵢ·S, ∇λᵢ·T).
pub(super) fn gradients(topology: &Topology, face: usize, frame: &FaceFrame) -> [DVec2; 3] {
    let p = topology.corners(face);
    let (n, double) = (topology.normals[face], 2.0 * topology.areas[face]);
    [0, 1, 2].map(|i| {
        let gradient = n.cross(p[(i + 2) % 3] - p[(i + 1) % 3]) / double;
        DVec2::new(gradient.dot(frame.s), gradient.dot(frame.t))
    })
}

/// Returns the Jacobian of a face's map from its frame to tiles: columns φ(S) and φ(T), times the tile's width. It is
/// the identity for an undistorted face that follows the field.
pub(super) fn jacobian(gradients: &[DVec2; 3], uvs: [DVec2; 3], tile_m: f64) -> DMat2 {
    let mut columns = [DVec2::ZERO; 2];
    for (g, uv) in gradients.iter().zip(uvs) {
        columns[0] += uv * g.x;
        columns[1] += uv * g.y;
    }
    DMat2::from_cols(columns[0] * tile_m, columns[1] * tile_m)
}

/// Returns the singular values σ1 ≥ σ2 of a 2 × 2 matrix; σ2 is negative if the matrix mirrors.
pub(super) fn singular_values(m: DMat2) -> (f64, f64) {
    let (a, b, c, d) = (m.x_axis.x, m.x_axis.y, m.y_axis.x, m.y_axis.y);
    let (sum, difference) = (libm::hypot(a + d, b - c), libm::hypot(a - d, b + c));
    ((sum + difference) / 2.0, (sum - difference) / 2.0)
}

/// Returns the rotation nearest to `m`.
fn rotation_of(m: DMat2) -> DMat2 {
    let axis = DVec2::new(m.x_axis.x + m.y_axis.y, m.x_axis.y - m.y_axis.x).normalize_or(DVec2::X);
    DMat2::from_cols(axis, axis.perp())
}

/// Relative residual above which a solution is rejected. It is several orders of magnitude above the residual of any
/// sound patch.
const WORST_RESIDUAL: f64 = 1e-6;

/// System of equations of one patch.
pub(super) struct PatchSystem<'a> {
    topology: &'a Topology,
    faces: &'a [u32],
    frames: Vec<FaceFrame>,
    gradients: Vec<[DVec2; 3]>,
    /// Points of the patch; the first is fixed at 0.
    points: Vec<u32>,
    /// Indices into `points`, per face and corner.
    corners: Vec<[u32; 3]>,
}

impl<'a> PatchSystem<'a> {
    /// Sets up the equations. `faces` must be connected; `frames` has one entry per face.
    pub(super) fn new(topology: &'a Topology, faces: &'a [u32], frames: Vec<FaceFrame>) -> Self {
        let mut points: Vec<u32> = faces.iter().flat_map(|f| topology.faces[*f as usize]).collect();
        points.sort_unstable();
        points.dedup();
        let local = |p: u32| points.binary_search(&p).unwrap_or(0) as u32;
        let corners = faces.iter().map(|f| topology.faces[*f as usize].map(local)).collect();
        let gradients = faces.iter().zip(&frames).map(|(f, frame)| gradients(topology, *f as usize, frame)).collect();
        Self { topology, faces, frames, gradients, points, corners }
    }

    /// Returns the points of the patch in ascending order.
    pub(super) fn points(&self) -> &[u32] {
        &self.points
    }

    /// Returns the Euler characteristic: points minus edges plus faces, 1 for a disc.
    pub(super) fn euler_characteristic(&self) -> i64 {
        let mut edges: Vec<[u32; 2]> = Vec::with_capacity(3 * self.corners.len());
        for c in &self.corners {
            edges.extend([[c[0], c[1]], [c[1], c[2]], [c[2], c[0]]].map(|[a, b]| [a.min(b), a.max(b)]));
        }
        edges.sort_unstable();
        edges.dedup();
        self.points.len() as i64 - edges.len() as i64 + self.corners.len() as i64
    }

    /// Returns tile coordinates, one per entry of [`Self::points`], with the first at 0. At `comb_weight` 1, the map
    /// follows the field. At 0, every face is rotated towards minimal distortion, `rounds` times (as rigid as possible,
    /// Liu et al. 2008).
    ///
    /// `None` if the system cannot be solved to a small residual.
    pub(super) fn solve(&self, comb_weight: f64, rounds: usize) -> Option<Vec<DVec2>> {
        let n = self.points.len() - 1;
        let entries = self.corners.iter().enumerate().flat_map(|(k, corners)| {
            let (area, g) = (self.topology.areas[self.faces[k] as usize], &self.gradients[k]);
            (0..9).filter_map(move |c| {
                let (i, j) = (c / 3, c % 3);
                let (row, column) = (corners[i] as usize, corners[j] as usize);
                (row.min(column) > 0).then(|| (row - 1, column - 1, area * g[i].dot(g[j])))
            })
        });
        let matrix = Symmetric::new(n, entries);
        let factor = matrix.factor()?;
        let mut turns = vec![DMat2::IDENTITY; self.faces.len()];
        let mut uvs = Vec::new();
        for round in 0..=rounds {
            let right = self.right_side(&turns);
            let solution = factor.solve(&right);
            if !is_solved(&matrix, &solution, &right) {
                return None;
            }
            uvs = std::iter::once(DVec2::ZERO).chain(solution).collect();
            if round == rounds {
                break;
            }
            for (k, turn) in turns.iter_mut().enumerate() {
                let j = self.jacobian(k, &uvs);
                *turn = rotation_of(j * (1.0 - comb_weight) + DMat2::IDENTITY * comb_weight);
            }
        }
        Some(uvs)
    }

    fn right_side(&self, turns: &[DMat2]) -> Vec<DVec2> {
        let mut right = vec![DVec2::ZERO; self.points.len() - 1];
        for (k, corners) in self.corners.iter().enumerate() {
            let face = self.faces[k] as usize;
            let weight = self.topology.areas[face] / self.frames[k].tile_m;
            for (corner, g) in corners.iter().zip(&self.gradients[k]).filter(|(c, _)| **c > 0) {
                right[*corner as usize - 1] += turns[k] * *g * weight;
            }
        }
        right
    }

    /// Returns the Jacobian of the k-th face of the patch.
    pub(super) fn jacobian(&self, k: usize, uvs: &[DVec2]) -> DMat2 {
        let corners = self.corners[k].map(|c| uvs[c as usize]);
        jacobian(&self.gradients[k], corners, self.frames[k].tile_m)
    }
}

/// Returns whether `x` solves the system. For patches with slivers, a factor can consist of rounding errors only, and
/// `x` is then wrong.
fn is_solved(matrix: &Symmetric, x: &[DVec2], right: &[DVec2]) -> bool {
    let error: f64 = matrix.times(x).iter().zip(right).map(|(found, wanted)| found.distance_squared(*wanted)).sum();
    let size: f64 = right.iter().map(|r| r.length_squared()).sum();
    // NaN gives false.
    error.sqrt() <= WORST_RESIDUAL * size.sqrt().max(f64::MIN_POSITIVE)
}
