//! Texture coordinates aligned with the comb: v runs along the comb, u to its right. Both have the same world scale, so
//! that hair has an even density.
//!
//! The mesh is cut into charts. The coordinates of a chart are the least-squares solution of "gradient of u = S /
//! scale, gradient of v = T / scale". T is the comb direction in the face's plane, and S = T x N. Each coordinate is
//! the solution of a Poisson problem with the cotangent Laplacian (Praun, Finkelstein and Hoppe 2000 in the
//! area-weighted form; Lengyel 2001).
//!
//! Charts grow from single faces by pairwise merging; pairs with the longest shared border are merged first. A merge is
//! refused if a face would be flipped, or stretched or turned away from the comb beyond the bounds. Charts may overlap
//! in the texture because hair tiles repeat.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context as _, ensure};
use glam::DVec3;

use super::trimesh::{TriMesh, find};

/// Bounds that every triangle of a chart must satisfy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartParams {
    /// World length of one unit of texture coordinates, metres.
    pub metres_per_uv: f64,
    /// Least singular value of the map after scaling by `metres_per_uv`, 0..1.
    pub least_stretch: f64,
    /// Greatest singular value of the map after scaling, > 1.
    pub greatest_stretch: f64,
    /// Cosine of the greatest angle between the comb and the v direction.
    pub least_comb_cosine: f64,
}

impl Default for ChartParams {
    fn default() -> Self {
        Self { metres_per_uv: 0.1, least_stretch: 0.55, greatest_stretch: 1.8, least_comb_cosine: 0.8 }
    }
}

/// A vertex of the charted mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartVertex {
    /// Index into the mesh's positions.
    pub position: u32,
    /// Texture coordinates.
    pub uv: [f64; 2],
}

/// Mesh whose vertices are split along chart borders.
#[derive(Clone, Debug, Default)]
pub struct Atlas {
    /// Vertices.
    pub vertices: Vec<ChartVertex>,
    /// Triangles in the mesh's order.
    pub triangles: Vec<[u32; 3]>,
    /// Chart of each triangle.
    pub chart_of: Vec<u32>,
    /// Number of charts.
    pub charts: usize,
}

/// Computes the charts of the closed manifold `mesh`, combed by `comb` (any length, not necessarily in the surface's
/// plane).
pub fn make(mesh: &TriMesh, comb: &dyn Fn(DVec3) -> DVec3, params: &ChartParams) -> anyhow::Result<Atlas> {
    let neighbours = mesh.neighbours().map_err(|(a, b)| {
        anyhow::anyhow!("edge ({a}, {b}) is not shared by exactly two triangles; charts need a closed mesh")
    })?;
    let faces = faces(mesh, &neighbours, comb);
    ensure!(faces.iter().all(|f| f.area > 0.0), "a triangle has no area; charts need a remeshed surface");
    let mut charter = Charter {
        mesh,
        neighbours,
        uv: faces.iter().map(|f| f.own_uv(params.metres_per_uv)).collect(),
        faces,
        params: *params,
        members: Vec::new(),
        chart_of: (0..mesh.triangles.len() as u32).collect(),
        local: vec![u32::MAX; mesh.triangles.len()],
    };
    charter.members = charter.chart_of.iter().map(|&f| vec![f]).collect();
    for _ in 0..3 {
        charter.merge_all();
        charter.smooth_borders();
    }
    charter.align();
    charter.finish()
}

/// Per-triangle data for charting.
struct Face {
    area: f64,
    corners: [DVec3; 3],
    /// Gradients of the three hat functions of the corners, 1 / metres.
    hats: [DVec3; 3],
    normal: DVec3,
    /// Unit comb direction in the face's plane: the target direction of v.
    t: DVec3,
    /// Target direction of u, t x normal; unit length.
    s: DVec3,
}

impl Face {
    /// Returns the undistorted texture coordinates of this face alone.
    fn own_uv(&self, scale: f64) -> [[f64; 2]; 3] {
        self.corners.map(|p| [(p - self.corners[0]).dot(self.s) / scale, (p - self.corners[0]).dot(self.t) / scale])
    }

    /// Returns the rows of the scaled Jacobian in the basis (s, t): u along s, u along t, v along s, v along t.
    fn jacobian(&self, uv: &[[f64; 2]; 3], scale: f64) -> [f64; 4] {
        let gradient = |k: usize| (0..3).fold(DVec3::ZERO, |sum, i| sum + self.hats[i] * uv[i][k]) * scale;
        let (u, v) = (gradient(0), gradient(1));
        [u.dot(self.s), u.dot(self.t), v.dot(self.s), v.dot(self.t)]
    }
}

fn faces(mesh: &TriMesh, neighbours: &[[u32; 3]], comb: &dyn Fn(DVec3) -> DVec3) -> Vec<Face> {
    let mut faces: Vec<Face> = (0..mesh.triangles.len())
        .map(|t| {
            let corners = mesh.corners(t);
            let double = mesh.area_normal(t);
            let (area, normal) = (0.5 * double.length(), double.normalize_or_zero());
            let hats = [0, 1, 2].map(|i| normal.cross(corners[(i + 2) % 3] - corners[(i + 1) % 3]) / (2.0 * area));
            let wanted = comb((corners[0] + corners[1] + corners[2]) / 3.0).normalize_or_zero();
            // The length of `t` measures confidence: it is short where the comb is nearly perpendicular to the surface.
            Face { area, corners, hats, normal, t: wanted - normal * wanted.dot(normal), s: DVec3::ZERO }
        })
        .collect();
    // Diffuses the comb directions. Uncertain faces (nose, paws, rump) then follow their neighbours, and as few whirls
    // remain as the shape allows.
    let wanted: Vec<DVec3> = faces.iter().map(|f| f.t * f.t.length()).collect();
    for _ in 0..60 {
        let next: Vec<DVec3> = (0..faces.len())
            .map(|f| {
                let across = neighbours[f].iter().fold(DVec3::ZERO, |sum, &g| sum + faces[g as usize].t);
                let n = faces[f].normal;
                let sum = wanted[f] * 0.6 + across;
                (sum - n * sum.dot(n)).normalize_or(n.any_orthonormal_vector())
            })
            .collect();
        for (face, t) in faces.iter_mut().zip(next) {
            face.t = t;
        }
    }
    for face in &mut faces {
        face.s = face.t.cross(face.normal);
    }
    faces
}

struct Charter<'a> {
    mesh: &'a TriMesh,
    neighbours: Vec<[u32; 3]>,
    faces: Vec<Face>,
    params: ChartParams,
    /// Faces of each chart; empty for a chart that was merged into another.
    members: Vec<Vec<u32>>,
    chart_of: Vec<u32>,
    /// Texture coordinates of each face's corners.
    uv: Vec<[[f64; 2]; 3]>,
    /// Scratch buffer: index of a face within the chart being solved, else `u32::MAX`.
    local: Vec<u32>,
}

type CornerUvs = Vec<[[f64; 2]; 3]>;

impl Charter<'_> {
    fn edge_length(&self, f: u32, k: usize) -> f64 {
        let c = &self.faces[f as usize].corners;
        (c[(k + 1) % 3] - c[k]).length()
    }

    /// Returns the index of the edge of `g` that is shared with `f`: corner k of `f` coincides with corner `edge + 1`
    /// of `g`.
    fn edge_towards(&self, g: u32, f: u32, k: usize) -> usize {
        let start = self.mesh.triangles[f as usize][k];
        let corners = self.mesh.triangles[g as usize];
        (0..3).find(|&j| corners[(j + 1) % 3] == start && self.neighbours[g as usize][j] == f).unwrap_or(0)
    }

    /// Joins the corners of `chart` that meet across its interior edges. Returns the vertex index of each corner, and
    /// the number of vertices.
    fn chart_vertices(&mut self, chart: &[u32]) -> (Vec<[u32; 3]>, usize) {
        for (i, &f) in chart.iter().enumerate() {
            self.local[f as usize] = i as u32;
        }
        let mut root: Vec<u32> = (0..3 * chart.len() as u32).collect();
        for (i, &f) in chart.iter().enumerate() {
            for k in 0..3 {
                let g = self.neighbours[f as usize][k];
                let j = self.local[g as usize];
                if j == u32::MAX {
                    continue;
                }
                let e = self.edge_towards(g, f, k);
                let pairs = [(k, (e + 1) % 3), ((k + 1) % 3, e)];
                for (mine, theirs) in pairs {
                    let (a, b) = (find(&mut root, (3 * i + mine) as u32), find(&mut root, 3 * j + theirs as u32));
                    root[a.max(b) as usize] = a.min(b);
                }
            }
        }
        for &f in chart {
            self.local[f as usize] = u32::MAX;
        }
        let mut names = vec![u32::MAX; root.len()];
        let mut count = 0;
        let corners = (0..chart.len())
            .map(|i| {
                [0, 1, 2].map(|k| {
                    let r = find(&mut root, (3 * i + k) as u32) as usize;
                    if names[r] == u32::MAX {
                        names[r] = count;
                        count += 1;
                    }
                    names[r]
                })
            })
            .collect();
        (corners, count as usize)
    }

    /// Solves the least-squares problem of one connected chart, with `start` as the initial guess. Returns `None` if
    /// the solution violates a bound.
    fn solve(&mut self, chart: &[u32], start: &CornerUvs) -> Option<CornerUvs> {
        let (corners, count) = self.chart_vertices(chart);
        let scale = self.params.metres_per_uv;
        let mut columns = [vec![0.0; count], vec![0.0; count]];
        for (c, uv) in corners.iter().zip(start) {
            for i in 0..3 {
                columns[0][c[i] as usize] = uv[i][0];
                columns[1][c[i] as usize] = uv[i][1];
            }
        }
        let locals: Vec<[[f64; 3]; 3]> = chart
            .iter()
            .map(|&f| {
                let face = &self.faces[f as usize];
                face.hats.map(|a| face.hats.map(|b| a.dot(b) * face.area))
            })
            .collect();
        for (k, x) in columns.iter_mut().enumerate() {
            let mut rhs = vec![0.0; count];
            for (c, &f) in corners.iter().zip(chart) {
                let face = &self.faces[f as usize];
                let target = if k == 0 { face.s } else { face.t };
                for i in 0..3 {
                    rhs[c[i] as usize] += face.hats[i].dot(target) * face.area / scale;
                }
            }
            conjugate_gradients(&corners, &locals, &rhs, x);
        }
        let uvs: CornerUvs =
            corners.iter().map(|c| c.map(|i| [columns[0][i as usize], columns[1][i as usize]])).collect();
        let fits = chart.iter().zip(&uvs).all(|(&f, uv)| self.within_bounds(f, uv));
        fits.then_some(uvs)
    }

    fn within_bounds(&self, f: u32, uv: &[[f64; 2]; 3]) -> bool {
        let j = self.faces[f as usize].jacobian(uv, self.params.metres_per_uv);
        let (large, small) = singular_values(j);
        let comb_cosine = j[3] / (j[2] * j[2] + j[3] * j[3]).sqrt().max(1e-12);
        small >= self.params.least_stretch
            && large <= self.params.greatest_stretch
            && comb_cosine >= self.params.least_comb_cosine
            && j[0] * j[3] - j[1] * j[2] > 0.0
    }

    fn current(&self, chart: &[u32]) -> CornerUvs {
        chart.iter().map(|&f| self.uv[f as usize]).collect()
    }

    fn store(&mut self, chart: &[u32], uvs: CornerUvs) {
        for (&f, uv) in chart.iter().zip(uvs) {
            self.uv[f as usize] = uv;
        }
    }

    /// Returns, for each pair of adjacent charts, the total length of their border, and the mean jump of the texture
    /// coordinates across it. The jump is from the chart with the lower index to the other one.
    fn borders(&self) -> BTreeMap<(u32, u32), (f64, [f64; 2])> {
        let mut borders: BTreeMap<(u32, u32), (f64, [f64; 2])> = BTreeMap::new();
        for f in 0..self.faces.len() as u32 {
            for k in 0..3 {
                let g = self.neighbours[f as usize][k];
                let (a, b) = (self.chart_of[f as usize], self.chart_of[g as usize]);
                if a >= b {
                    continue;
                }
                let e = self.edge_towards(g, f, k);
                let length = self.edge_length(f, k);
                let border = borders.entry((a, b)).or_default();
                border.0 += length;
                for axis in 0..2 {
                    let mine = self.uv[f as usize][k][axis] + self.uv[f as usize][(k + 1) % 3][axis];
                    let theirs = self.uv[g as usize][(e + 1) % 3][axis] + self.uv[g as usize][e][axis];
                    border.1[axis] += 0.5 * (theirs - mine) * length;
                }
            }
        }
        for (length, jump) in borders.values_mut() {
            *jump = jump.map(|j| j / *length);
        }
        borders
    }

    fn merge_all(&mut self) {
        let mut refused = BTreeSet::new();
        loop {
            let borders = self.borders();
            let mut perimeter = vec![0.0; self.members.len()];
            for (&(a, b), &(length, _)) in &borders {
                perimeter[a as usize] += length;
                perimeter[b as usize] += length;
            }
            let score = |a: u32, b: u32, length: f64| {
                let flat = self.mean_normal(a).dot(self.mean_normal(b)).max(0.0);
                length / perimeter[a as usize].min(perimeter[b as usize]) * (0.25 + flat)
            };
            let mut queue: Vec<_> = borders
                .iter()
                .filter(|(pair, _)| !refused.contains(*pair))
                .map(|(&(a, b), &(length, jump))| (score(a, b, length), a, b, jump))
                .collect();
            queue.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
            let mut busy = vec![false; self.members.len()];
            let mut merged = 0;
            for (_, a, b, jump) in queue {
                if busy[a as usize] || busy[b as usize] {
                    continue;
                }
                let (first, second) = (self.members[a as usize].clone(), self.members[b as usize].clone());
                let mut start = self.current(&first);
                let shift = |uv: [f64; 2]| [uv[0] - jump[0], uv[1] - jump[1]];
                start.extend(self.current(&second).into_iter().map(|uv| uv.map(shift)));
                let both = [first, second].concat();
                let Some(uvs) = self.solve(&both, &start) else {
                    refused.insert((a, b));
                    continue;
                };
                // Gives the merged chart a new index, so that earlier refusals of its two parts do not apply to it.
                let id = self.members.len() as u32;
                for &f in &both {
                    self.chart_of[f as usize] = id;
                }
                self.store(&both, uvs);
                self.members[a as usize].clear();
                self.members[b as usize].clear();
                self.members.push(both);
                busy[a as usize] = true;
                busy[b as usize] = true;
                merged += 1;
            }
            if merged == 0 {
                return;
            }
        }
    }

    fn mean_normal(&self, chart: u32) -> DVec3 {
        let members = self.members[chart as usize].iter();
        members
            .fold(DVec3::ZERO, |sum, &f| sum + self.faces[f as usize].normal * self.faces[f as usize].area)
            .normalize_or_zero()
    }

    /// Moves border teeth (faces with two edges in another chart) to that chart, if the bounds allow it.
    fn smooth_borders(&mut self) {
        for _ in 0..4 {
            let mut moved = 0;
            for f in 0..self.faces.len() as u32 {
                let own = self.chart_of[f as usize];
                let around = self.neighbours[f as usize].map(|g| self.chart_of[g as usize]);
                let Some(&other) =
                    around.iter().find(|&&c| c != own && around.iter().filter(|&&d| d == c).count() >= 2)
                else {
                    continue;
                };
                let mut grown = self.members[other as usize].clone();
                grown.push(f);
                let mut start = self.current(&grown);
                // Extends a neighbour's coordinates to the new face as the initial guess for the solver.
                if let (Some(last), Some(k)) = (start.last_mut(), around.iter().position(|&c| c == other)) {
                    let g = self.neighbours[f as usize][k];
                    let e = self.edge_towards(g, f, k);
                    let (mine, theirs) = (self.uv[f as usize][k], self.uv[g as usize][(e + 1) % 3]);
                    *last = last.map(|uv| [uv[0] + theirs[0] - mine[0], uv[1] + theirs[1] - mine[1]]);
                }
                let Some(uvs) = self.solve(&grown, &start) else { continue };
                self.store(&grown, uvs);
                self.members[other as usize] = grown;
                self.members[own as usize].retain(|&x| x != f);
                self.chart_of[f as usize] = other;
                moved += 1;
            }
            if moved == 0 {
                break;
            }
        }
        // Charts that lost faces still have their old coordinates and are therefore solved again.
        for c in 0..self.members.len() {
            let members = self.members[c].clone();
            let start = self.current(&members);
            if let Some(uvs) = self.solve(&members, &start) {
                self.store(&members, uvs);
            }
        }
    }

    /// Shifts every chart so that its coordinates continue those of the neighbour with the longest shared border. Hair
    /// is continuous across such a seam.
    fn align(&mut self) {
        let mut borders: Vec<_> = self.borders().into_iter().collect();
        borders.sort_by(|x, y| y.1.0.total_cmp(&x.1.0).then(x.0.cmp(&y.0)));
        // Builds Kruskal's spanning tree; each chart's shift is stored relative to the root of its tree.
        let mut group: Vec<u32> = (0..self.members.len() as u32).collect();
        let mut shift = vec![[0.0; 2]; self.members.len()];
        for ((a, b), (_, jump)) in borders {
            let (ga, gb) = (group[a as usize], group[b as usize]);
            if ga == gb {
                continue;
            }
            let step = [0, 1].map(|k| shift[a as usize][k] - jump[k] - shift[b as usize][k]);
            for c in 0..group.len() {
                if group[c] == gb {
                    group[c] = ga;
                    shift[c] = [shift[c][0] + step[0], shift[c][1] + step[1]];
                }
            }
        }
        for (uv, &chart) in self.uv.iter_mut().zip(&self.chart_of) {
            let s = shift[chart as usize];
            *uv = uv.map(|c| [c[0] + s[0], c[1] + s[1]]);
        }
    }

    fn finish(mut self) -> anyhow::Result<Atlas> {
        let mut atlas = Atlas {
            triangles: vec![[0; 3]; self.faces.len()],
            chart_of: vec![0; self.faces.len()],
            ..Atlas::default()
        };
        for chart in std::mem::take(&mut self.members) {
            if chart.is_empty() {
                continue;
            }
            let (corners, count) = self.chart_vertices(&chart);
            let first = atlas.vertices.len() as u32;
            atlas.vertices.resize(first as usize + count, ChartVertex { position: u32::MAX, uv: [0.0; 2] });
            for (&f, c) in chart.iter().zip(&corners) {
                for (k, &corner) in c.iter().enumerate() {
                    let uv = self.uv[f as usize][k];
                    atlas.triangles[f as usize][k] = first + corner;
                    let slot =
                        atlas.vertices.get_mut((first + corner) as usize).context("chart vertex out of range")?;
                    *slot = ChartVertex { position: self.mesh.triangles[f as usize][k], uv };
                }
                atlas.chart_of[f as usize] = atlas.charts as u32;
            }
            atlas.charts += 1;
        }
        Ok(atlas)
    }
}

/// Solves the sum of the triangles' 3x3 systems by conjugate gradients, from the initial guess `x`. The preconditioner
/// is the diagonal.
///
/// The matrix is singular: constants are in its null space. The right-hand side sums to zero, so the iteration stays in
/// the solvable subspace.
fn conjugate_gradients(corners: &[[u32; 3]], locals: &[[[f64; 3]; 3]], rhs: &[f64], x: &mut [f64]) {
    let apply = |x: &[f64]| {
        let mut y = vec![0.0; x.len()];
        for (c, m) in corners.iter().zip(locals) {
            for i in 0..3 {
                y[c[i] as usize] += (0..3).map(|j| m[i][j] * x[c[j] as usize]).sum::<f64>();
            }
        }
        y
    };
    let mut diagonal = vec![0.0; x.len()];
    for (c, m) in corners.iter().zip(locals) {
        for i in 0..3 {
            diagonal[c[i] as usize] += m[i][i];
        }
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let precondition = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
    let mut r: Vec<f64> = rhs.iter().zip(apply(x)).map(|(b, ax)| b - ax).collect();
    let mut z = precondition(&r);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let enough = 1e-14 * dot(rhs, &precondition(rhs));
    for _ in 0..1000 {
        if rz <= enough {
            return;
        }
        let ap = apply(&p);
        let step = rz / dot(&p, &ap);
        for i in 0..x.len() {
            x[i] += step * p[i];
            r[i] -= step * ap[i];
        }
        z = precondition(&r);
        let next = dot(&r, &z);
        for i in 0..x.len() {
            p[i] = z[i] + p[i] * (next / rz);
        }
        rz = next;
    }
}

/// Returns the singular values of `[a b; c d]`, the larger first.
pub fn singular_values([a, b, c, d]: [f64; 4]) -> (f64, f64) {
    let (p, q) = ((a + d) * (a + d) + (c - b) * (c - b), (a - d) * (a - d) + (b + c) * (b + c));
    let (p, q) = (0.5 * p.sqrt(), 0.5 * q.sqrt());
    (p + q, (p - q).abs())
}

/// Quality measures of texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChartReport {
    /// Area-weighted mean of (σ1/σ2 + σ2/σ1)/2 − 1.
    pub angle_distortion: f64,
    /// Area-weighted mean of (σ1σ2 + 1/(σ1σ2))/2 − 1, after a global scaling that makes the total areas equal.
    pub area_distortion: f64,
    /// Number of triangles whose determinant is not positive.
    pub flipped_triangles: usize,
    /// Total length of the edges at which the coordinates of the two sides differ, each edge counted once. It is
    /// divided by the square root of the mesh's area.
    pub seam_length_ratio: f64,
    /// World length of one unit of texture coordinates, metres: the one at which the total areas on surface and texture
    /// are equal.
    pub metres_per_uv: f64,
    /// Least singular value at the scale `metres_per_uv`.
    pub least_stretch: f64,
    /// Greatest singular value at the scale `metres_per_uv`.
    pub greatest_stretch: f64,
}

/// Measures the texture coordinates `uvs[i]` of the vertices at `positions[i]`.
pub fn report(positions: &[DVec3], uvs: &[[f64; 2]], triangles: &[[u32; 3]]) -> ChartReport {
    let mut result = ChartReport { least_stretch: f64::MAX, ..ChartReport::default() };
    let (mut area, mut uv_area) = (0.0, 0.0);
    let mut maps = Vec::new();
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let [ua, ub, uc] = t.map(|v| uvs[v as usize]);
        let x = (b - a).normalize_or_zero();
        let (b1, c1) = ((b - a).length(), (c - a).dot(x));
        let c2 = ((c - a) - x * c1).length();
        // Columns of the map's Jacobian: along the first edge, and perpendicular to it, towards the third corner.
        let along = [(ub[0] - ua[0]) / b1, (ub[1] - ua[1]) / b1];
        let across = [0, 1].map(|k| (uc[k] - ua[k] - along[k] * c1) / c2);
        let determinant = along[0] * across[1] - along[1] * across[0];
        result.flipped_triangles += usize::from(determinant.is_nan() || determinant <= 0.0);
        let face_area = 0.5 * b1 * c2;
        area += face_area;
        uv_area += face_area * determinant.abs();
        maps.push((face_area, singular_values([along[0], across[0], along[1], across[1]])));
    }
    result.metres_per_uv = (area / uv_area).sqrt();
    for (face_area, (large, small)) in maps {
        let (large, small) = (large * result.metres_per_uv, small * result.metres_per_uv);
        result.angle_distortion += face_area / area * ((large / small + small / large) * 0.5 - 1.0);
        result.area_distortion += face_area / area * ((large * small + 1.0 / (large * small)) * 0.5 - 1.0);
        result.least_stretch = result.least_stretch.min(small);
        result.greatest_stretch = result.greatest_stretch.max(large);
    }
    result.seam_length_ratio = seam_length(positions, uvs, triangles) / area.sqrt();
    result
}

fn seam_length(positions: &[DVec3], uvs: &[[f64; 2]], triangles: &[[u32; 3]]) -> f64 {
    let key = |v: u32| positions[v as usize].to_array().map(f64::to_bits);
    let uv = |v: u32| uvs[v as usize].map(f64::to_bits);
    let mut sides = BTreeMap::new();
    for t in triangles {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            sides.insert((key(a), key(b)), (uv(a), uv(b), (positions[a as usize] - positions[b as usize]).length()));
        }
    }
    let one_sided = |from: [u64; 3], to: [u64; 3], a: [u64; 2], b: [u64; 2]| {
        from < to && sides.get(&(to, from)).is_none_or(|other| (other.1, other.0) != (a, b))
    };
    sides.iter().filter(|&(&(from, to), &(a, b, _))| one_sided(from, to, a, b)).map(|(_, side)| side.2).sum()
}
