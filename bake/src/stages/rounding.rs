//! Rounding of coarse surface: triangles whose normals turn by large angles are split, and their new vertices are moved
//! onto a curved surface.
//!
//! Hair stands on the surface, so its density, direction and shadow change at every edge of a coarse mesh, whatever the
//! normals are. Only a finer surface makes fur as smooth as the normals. New vertices are on the edges of curved
//! PN triangles (Vlachos et al., "Curved PN Triangles", I3D 2001), whose surface follows the normals.

use glam::Vec3;
use pelage_formats::SkinVertex;
use pelage_import::mesh::{Mesh, Model, MorphRows, RestPose, RowDelta};
use std::collections::HashMap;

/// Cosine of the angle between the normals at the ends of an edge above which a triangle is coarse: 32°. Below it,
/// borders between triangles hardly show in fur.
const COARSE_COSINE: f32 = 0.848;
/// Cosine of the angle up to which edges of coarse triangles are not split: 15°.
const FINE_COSINE: f32 = 0.966;
/// Minimum cosine between the normal of a coarse triangle and those at its corners: 45°. Beyond it the normals do not
/// describe the shape, as those of a box whose corners have one normal each.
const FOLLOWED_COSINE: f32 = 0.707;
/// Minimum length of an edge of a coarse triangle, as a share of the bounding sphere's radius. Facets of rough scans
/// are shorter.
const LEAST_EDGE: f32 = 0.02;
/// Minimum share of the furred area that is coarse. Below it, the surface as a whole is fine, and rounding its few
/// sharp bends would multiply the triangles of every layer.
const COARSE_SHARE: f32 = 0.5;
/// Maximum number of times that an edge is halved.
const ROUNDS: usize = 4;

/// Returns the model with its coarse furred surface rounded; `None` if at most half of the furred area is coarse. Flat
/// surface with hard edges stays as it is, because its normals do not turn along its edges.
///
/// * `furred`: whether hair grows on each material
/// * `rest`: rest pose of the model
/// * `radius`: radius of its bounding sphere, metres
pub fn rounded(model: &Model, furred: &[bool], rest: &RestPose, radius: f32) -> Option<Model> {
    let mut coarse = vec![false; model.mesh.triangles.len()];
    let (mut furred_area, mut coarse_area) = (0.0, 0.0);
    for part in model.mesh.parts.iter().filter(|part| furred.get(part.material).copied().unwrap_or(false)) {
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        for (coarse, triangle) in coarse[range.clone()].iter_mut().zip(&model.mesh.triangles[range]) {
            *coarse = is_coarse(*triangle, rest, LEAST_EDGE * radius);
            let [a, b, c] = triangle.map(|v| rest.positions[v as usize]);
            let area = (b - a).cross(c - a).length();
            furred_area += area;
            coarse_area += if *coarse { area } else { 0.0 };
        }
    }
    if coarse_area <= COARSE_SHARE * furred_area {
        return None;
    }
    let mut finer = FinerMesh { mesh: model.mesh.clone(), rows: model.morph_rows.clone(), coarse };
    for _ in 0..ROUNDS {
        let curves = finer.curves();
        if curves.is_empty() {
            break;
        }
        finer.split(&curves);
    }
    Some(Model { mesh: finer.mesh, morph_rows: finer.rows, ..model.clone() })
}

fn is_coarse(triangle: [u32; 3], rest: &RestPose, least_edge: f32) -> bool {
    let [p, n] = [&rest.positions, &rest.normals].map(|of| triangle.map(|v| of[v as usize]));
    let face = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
    let turns = |(i, j): (usize, usize)| n[i].dot(n[j]) < COARSE_COSINE && p[i].distance(p[j]) > least_edge;
    n.iter().all(|normal| normal.dot(face) > FOLLOWED_COSINE) && [(0, 1), (1, 2), (2, 0)].into_iter().any(turns)
}

/// Positions of an edge's ends, as bits, in ascending order. Vertices of a seam have the same key.
type EdgeKey = [[u32; 3]; 2];

/// Sum of the offsets of an edge's middle that its sides propose, and of their weights.
#[derive(Clone, Copy, Default)]
struct EdgeCurve {
    offset: Vec3,
    weight: f32,
}

/// Mesh that is being split.
struct FinerMesh {
    mesh: Mesh,
    rows: MorphRows,
    /// Whether each triangle is part of a coarse triangle of the model.
    coarse: Vec<bool>,
}

impl FinerMesh {
    fn key(&self, a: u32, b: u32) -> EdgeKey {
        // Adding zero turns -0 into +0.
        let [a, b] = [a, b].map(|v| self.mesh.positions[v as usize].to_array().map(|x| (x + 0.0).to_bits()));
        [a.min(b), a.max(b)]
    }

    /// Cosine between the normals at the ends of an edge, as one side has them.
    fn cosine(&self, a: u32, b: u32) -> f32 {
        self.mesh.normals[a as usize].dot(self.mesh.normals[b as usize])
    }

    /// Returns the edges to be split, with the curves that their sides propose. Sides weigh more the more their normals
    /// turn: a flat side has no opinion on the shape of the other.
    fn curves(&self) -> HashMap<EdgeKey, EdgeCurve> {
        let sides = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)];
        let of_coarse = self.mesh.triangles.iter().zip(&self.coarse).filter(|(_, coarse)| **coarse);
        let turning = of_coarse.flat_map(|(triangle, _)| sides(*triangle)).filter(|(a, b)| {
            self.cosine(*a, *b) < FINE_COSINE && self.mesh.positions[*a as usize] != self.mesh.positions[*b as usize]
        });
        let mut curves: HashMap<_, _> = turning.map(|(a, b)| (self.key(a, b), EdgeCurve::default())).collect();
        for (a, b) in self.mesh.triangles.iter().flat_map(|triangle| sides(*triangle)) {
            if let Some(curve) = curves.get_mut(&self.key(a, b)) {
                let weight = (1.0 - self.cosine(a, b)).max(0.0);
                let [p, q] = [a, b].map(|v| self.mesh.positions[v as usize]);
                let [n, m] = [a, b].map(|v| self.mesh.normals[v as usize]);
                curve.offset += weight * 0.125 * (m * m.dot(q - p) - n * n.dot(q - p));
                curve.weight += weight;
            }
        }
        curves
    }

    fn split(&mut self, curves: &HashMap<EdgeKey, EdgeCurve>) {
        let (mut middles, mut mean_rows) = (HashMap::new(), HashMap::new());
        let before = std::mem::take(&mut self.mesh.triangles);
        let mut coarse = Vec::new();
        let mut triangles = Vec::new();
        let mut parts = std::mem::take(&mut self.mesh.parts);
        for part in &mut parts {
            let range = part.first_triangle..part.first_triangle + part.triangle_count;
            part.first_triangle = triangles.len();
            for t in range {
                let corners = before[t];
                let middle = [0, 1, 2].map(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let curve = curves.get(&self.key(a, b))?;
                    let at = (a.min(b), a.max(b));
                    Some(*middles.entry(at).or_insert_with(|| self.middle(at.0, at.1, curve, &mut mean_rows)))
                });
                triangles.extend(pieces(corners, middle));
                coarse.resize(triangles.len(), self.coarse[t]);
            }
            part.triangle_count = triangles.len() - part.first_triangle;
        }
        (self.mesh.triangles, self.mesh.parts, self.coarse) = (triangles, parts, coarse);
    }

    /// Appends the middle of an edge to the mesh. `mean_rows`: means of rows that exist.
    fn middle(&mut self, a: u32, b: u32, curve: &EdgeCurve, mean_rows: &mut HashMap<(u32, u32), u32>) -> u32 {
        let (a, b) = (a as usize, b as usize);
        let mesh = &mut self.mesh;
        let offset = if curve.weight > 0.0 { curve.offset / curve.weight } else { Vec3::ZERO };
        mesh.positions.push(0.5 * (mesh.positions[a] + mesh.positions[b]) + offset);
        mesh.normals.push((mesh.normals[a] + mesh.normals[b]).try_normalize().unwrap_or(mesh.normals[a]));
        mesh.uvs.push(0.5 * (mesh.uvs[a] + mesh.uvs[b]));
        let (from, to) = (mesh.colors[a], mesh.colors[b]);
        mesh.colors.push(std::array::from_fn(|i| u8::midpoint(from[i], to[i])));
        if let (Some(from), Some(to)) = (mesh.skin.get(a), mesh.skin.get(b)) {
            let mean = mean_skin(from, to);
            mesh.skin.push(mean);
        }
        if let (Some(from), Some(to)) = (mesh.morph_rows.get(a).copied(), mesh.morph_rows.get(b).copied()) {
            let rows = &mut self.rows.0;
            let row = *mean_rows.entry((from.min(to), from.max(to))).or_insert_with(|| {
                if from == to {
                    return from;
                }
                let of = |row: u32| rows.get(row as usize).map_or(&[][..], Vec::as_slice);
                let mean = mean_row(of(from), of(to));
                rows.push(mean);
                rows.len() as u32 - 1
            });
            mesh.morph_rows.push(row);
        }
        mesh.positions.len() as u32 - 1
    }
}

/// Returns the pieces of a triangle. `middle`: new vertices on the edges from corner 0 to 1, 1 to 2 and 2 to 0.
fn pieces([a, b, c]: [u32; 3], middle: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    match middle {
        [None, None, None] => vec![[a, b, c]],
        [Some(d), None, None] => vec![[a, d, c], [d, b, c]],
        [Some(d), Some(e), None] => vec![[d, b, e], [a, d, e], [a, e, c]],
        [Some(d), Some(e), Some(f)] => vec![[a, d, f], [d, b, e], [f, e, c], [d, e, f]],
        // The other cases are rotations of these.
        [d, e, f] => pieces([b, c, a], [e, f, d]),
    }
}

/// Returns the mean of two vertices' joints and weights: the four largest weights, with sum 1.
fn mean_skin(a: &SkinVertex, b: &SkinVertex) -> SkinVertex {
    let mut sums: Vec<(u16, f32)> = Vec::with_capacity(8);
    let both = [a, b].into_iter().flat_map(|of| of.joints.into_iter().zip(of.weights));
    for (joint, weight) in both.filter(|(_, weight)| *weight > 0.0) {
        match sums.iter_mut().find(|(other, _)| *other == joint) {
            Some((_, sum)) => *sum += weight,
            None => sums.push((joint, weight)),
        }
    }
    sums.sort_by(|(_, x), (_, y)| y.total_cmp(x));
    sums.truncate(4);
    let total: f32 = sums.iter().map(|(_, weight)| weight).sum();
    if total <= 0.0 {
        return *a;
    }
    let mut out = SkinVertex { joints: [sums[0].0; 4], weights: [0.0; 4] };
    for (i, (joint, weight)) in sums.into_iter().enumerate() {
        (out.joints[i], out.weights[i]) = (joint, weight / total);
    }
    out
}

fn mean_row(a: &[RowDelta], b: &[RowDelta]) -> Vec<RowDelta> {
    let mut targets: Vec<u32> = a.iter().chain(b).map(|delta| delta.target).collect();
    targets.sort_unstable();
    targets.dedup();
    let mean = |target: u32| {
        let both = [a, b].map(|row| row.iter().find(|delta| delta.target == target));
        let half = |of: fn(&RowDelta) -> Vec3| both.iter().flatten().map(|delta| 0.5 * of(delta)).sum::<Vec3>();
        let authored = both.iter().flatten().any(|delta| delta.normal.is_some());
        RowDelta {
            target,
            position: half(|delta| delta.position),
            normal: authored.then(|| half(|delta| delta.normal.unwrap_or_default())),
            hidden_at: Option::zip(both[0], both[1]).and_then(|(a, b)| Some(a.hidden_at?.midpoint(b.hidden_at?))),
        }
    };
    targets.into_iter().map(mean).collect()
}
