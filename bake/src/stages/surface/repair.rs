//! Mesh repair: faults are corrected, and no mesh is rejected.
//!
//! Corners with equal positions are joined into points. Triangles without area and duplicates are removed. If an edge
//! has more than two triangles, the pair that bends least stays connected, and the edge is cut for the others. A
//! triangle wound against its neighbours is flipped.

use super::topology::{NONE, Topology};
use glam::DVec3;
use pelage_import::mesh::Mesh;
use pelage_import::union_find::root;
use rayon::prelude::*;
use std::collections::HashMap;

/// Largest distance at which positions are joined, as a share of the mesh's extent: a few rounding steps of an f32.
const JOIN_PER_EXTENT: f64 = 2e-7;
/// Height below which a triangle counts as flat, as a share of the extent. Its area is too small to be represented by
/// an f32.
const FLAT_PER_EXTENT: f64 = 4e-7;

/// Faults found in one component. A component consists of triangles connected by their points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Faults {
    /// Number of triangles before the repair.
    pub(super) triangles: u32,
    pub(super) first_triangle: u32,
    pub(super) zero_area: u32,
    pub(super) duplicate: u32,
    /// Number of edges with more than two triangles.
    pub(super) non_manifold_edges: u32,
    pub(super) flipped: u32,
    /// Number of edges that were cut because no winding suits both sides, as in a Möbius strip.
    pub(super) one_sided_edges: u32,
}

/// Repaired mesh, and its relation to the input.
#[derive(Clone, Debug, Default)]
pub(super) struct Repaired {
    pub(super) topology: Topology,
    /// Index of the input triangle of each face.
    pub(super) triangles: Vec<u32>,
    /// Whether each face's corners 1 and 2 were swapped.
    pub(super) flipped: Vec<bool>,
    /// Faults per component, in the order of their first triangles.
    pub(super) faults: Vec<Faults>,
}

/// Repairs the mesh of `triangles`, which are indices into `positions` (metres, at rest).
pub(super) fn repair(positions: &[DVec3], triangles: &[[u32; 3]]) -> Repaired {
    let (points, point_of, extent) = join_points(positions, triangles);
    let faces: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| point_of[v as usize])).collect();
    let (component_of, mut faults) = components(points.len(), &faces);

    let mut out = Repaired::default();
    let mut seen = HashMap::new();
    let mut sound = Vec::new();
    for (index, face) in faces.iter().enumerate() {
        let fault = &mut faults[component_of[index] as usize];
        if is_flat(face.map(|p| points[p as usize]), FLAT_PER_EXTENT * extent) {
            fault.zero_area += 1;
        } else if seen.insert(rotated(*face), ()).is_some() {
            fault.duplicate += 1;
        } else {
            sound.push(*face);
            out.triangles.push(index as u32);
        }
    }
    let component_of: Vec<u32> = out.triangles.iter().map(|t| component_of[*t as usize]).collect();
    let edges = sorted_edges(&sound);
    out.flipped = make_windings_agree(&points, &mut sound, &edges, &component_of, &mut faults);
    let edges = if out.flipped.contains(&true) { sorted_edges(&sound) } else { edges };
    let twins = pair(&points, &sound, &edges, |e| faults[component_of[e] as usize].non_manifold_edges += 1);
    out.topology = Topology::new(points, sound, twins);
    out.faults = faults;
    out
}

/// Number of components that are reported separately; one line sums up the rest.
const REPORTED: usize = 8;

/// Adds warnings about repairs, one per component. `mesh` is the mesh before the repair.
pub(super) fn report(mesh: &Mesh, faults: &[Faults], warnings: &mut Vec<String>) {
    let faulty: Vec<(usize, &Faults)> = faults.iter().enumerate().filter(|(_, f)| !f.summary().is_empty()).collect();
    for (index, fault) in faulty.iter().take(REPORTED) {
        let part = mesh.parts.iter().rev().find(|p| p.first_triangle <= fault.first_triangle as usize);
        let (source, of) = (part.map_or("", |p| &p.source), faults.len());
        let n = fault.triangles;
        warnings.push(format!(
            "surface: component {} of {of} ({source}, {n} triangles): {}",
            index + 1,
            fault.summary()
        ));
    }
    if let Some(rest) = faulty.get(REPORTED..).filter(|r| !r.is_empty()) {
        let sum = rest.iter().fold(Faults::default(), |sum, (_, f)| sum.plus(f));
        warnings.push(format!(
            "surface: {} more components, {} triangles: {}",
            rest.len(),
            sum.triangles,
            sum.summary()
        ));
    }
}

impl Faults {
    fn plus(&self, other: &Self) -> Self {
        Self {
            first_triangle: self.first_triangle,
            triangles: self.triangles + other.triangles,
            zero_area: self.zero_area + other.zero_area,
            duplicate: self.duplicate + other.duplicate,
            non_manifold_edges: self.non_manifold_edges + other.non_manifold_edges,
            flipped: self.flipped + other.flipped,
            one_sided_edges: self.one_sided_edges + other.one_sided_edges,
        }
    }

    /// Describes the faults; the text is empty if there are none.
    fn summary(&self) -> String {
        let said = [
            (self.zero_area, "triangles without area dropped"),
            (self.duplicate, "duplicate triangles dropped"),
            (self.non_manifold_edges, "edges with more than two triangles split"),
            (self.flipped, "inconsistently wound triangles flipped"),
            (self.one_sided_edges, "edges cut because no winding suits both sides"),
        ];
        let said: Vec<String> = said.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        said.join(", ")
    }
}

/// Joins used vertices that have nearly equal positions. Returns the points, the point of each vertex, and the extent
/// of the mesh.
fn join_points(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<u32>, f64) {
    let used = || triangles.iter().flatten().map(|v| positions[*v as usize]);
    let (min, max) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let extent = if min.x <= max.x { (max - min).max_element() } else { 0.0 };
    // Rounding to a grid can separate two close points if a grid line is between them. They then meet in a seam, as
    // they would without joining.
    let cell = (JOIN_PER_EXTENT * extent).max(f64::MIN_POSITIVE);
    let (mut points, mut point_of) = (Vec::new(), vec![NONE; positions.len()]);
    let mut seen = HashMap::new();
    for v in triangles.iter().flatten().map(|v| *v as usize) {
        if point_of[v] == NONE {
            let key = ((positions[v] - min) / cell).round().to_array().map(|x| x as i64);
            point_of[v] = *seen.entry(key).or_insert_with(|| {
                points.push(positions[v]);
                points.len() as u32 - 1
            });
        }
    }
    (points, point_of, extent)
}

/// Returns the component of each face, and a fault counter for each component. Faces of a component are connected by
/// shared points.
fn components(points: usize, faces: &[[u32; 3]]) -> (Vec<u32>, Vec<Faults>) {
    let mut parent: Vec<u32> = (0..points as u32).collect();
    for [a, b, c] in faces {
        let a = root(&mut parent, *a);
        for other in [*b, *c] {
            let other = root(&mut parent, other);
            parent[other as usize] = a;
        }
    }
    let mut number = vec![NONE; points];
    let mut faults: Vec<Faults> = Vec::new();
    let of = faces.iter().enumerate().map(|(index, face)| {
        let r = root(&mut parent, face[0]) as usize;
        if number[r] == NONE {
            number[r] = faults.len() as u32;
            faults.push(Faults { first_triangle: index as u32, ..Faults::default() });
        }
        faults[number[r] as usize].triangles += 1;
        number[r]
    });
    let of = of.collect();
    (of, faults)
}

fn is_flat([a, b, c]: [DVec3; 3], least_height: f64) -> bool {
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let height = (b - a).cross(c - a).length() / longest;
    // The height is NaN if all three points are equal.
    height.is_nan() || height <= least_height
}

/// Rotates the face so that its smallest point is first. The result is equal for equal triangles with the same winding.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Returns all half-edges in a fixed order, with those of one edge adjacent. Each entry consists of the edge's points,
/// smaller first, and the half-edge.
fn sorted_edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let mut edges = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], (3 * f + k) as u32));
        }
    }
    edges.par_sort_unstable();
    edges
}

fn start_of(faces: &[[u32; 3]], h: u32) -> u32 {
    faces[h as usize / 3][h as usize % 3]
}

fn face_normal(points: &[DVec3], face: [u32; 3]) -> DVec3 {
    let [a, b, c] = face.map(|p| points[p as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// Flips triangles until neighbours have consistent windings. In each component, the side with less area is flipped.
/// Returns whether each face was flipped.
fn make_windings_agree(
    points: &[DVec3],
    faces: &mut [[u32; 3]],
    edges: &[([u32; 2], u32)],
    component_of: &[u32],
    faults: &mut [Faults],
) -> Vec<bool> {
    // Only edges of exactly two triangles determine the winding; at other edges, any winding finds a partner.
    let pairs = edges.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2).map(|pair| [pair[0].1, pair[1].1]);
    let is_against = |[h, g]: [u32; 2]| start_of(faces, h) == start_of(faces, g);
    let mut flipped = vec![false; faces.len()];
    if !pairs.clone().any(is_against) {
        return flipped;
    }
    let mut links: Vec<Vec<(u32, bool)>> = vec![Vec::new(); faces.len()];
    for [h, g] in pairs {
        links[h as usize / 3].push((g / 3, is_against([h, g])));
        links[g as usize / 3].push((h / 3, is_against([h, g])));
    }
    let area = |face: [u32; 3]| {
        let [a, b, c] = face.map(|p| points[p as usize]);
        (b - a).cross(c - a).length()
    };
    let mut visited = vec![false; faces.len()];
    for first in 0..faces.len() {
        if visited[first] {
            continue;
        }
        visited[first] = true;
        let (mut island, mut turned, mut total) = (vec![first], 0.0, 0.0);
        let mut at = 0;
        while let Some(&f) = island.get(at) {
            at += 1;
            total += area(faces[f]);
            turned += if flipped[f] { area(faces[f]) } else { 0.0 };
            for (g, against) in &links[f] {
                let g = *g as usize;
                if !visited[g] {
                    visited[g] = true;
                    flipped[g] = flipped[f] != *against;
                    island.push(g);
                } else if (flipped[g] != flipped[f]) != *against && g < f {
                    faults[component_of[f] as usize].one_sided_edges += 1;
                }
            }
        }
        if 2.0 * turned > total {
            island.iter().for_each(|f| flipped[*f] = !flipped[*f]);
        }
    }
    for (f, face) in faces.iter_mut().enumerate().filter(|(f, _)| flipped[*f]) {
        face.swap(1, 2);
        faults[component_of[f] as usize].flipped += 1;
    }
    flipped
}

/// Returns the twins of all half-edges. If an edge has more than two half-edges, the pairs that bend least are joined
/// first, and `on_fault` is called with a face of the edge.
fn pair(points: &[DVec3], faces: &[[u32; 3]], edges: &[([u32; 2], u32)], mut on_fault: impl FnMut(usize)) -> Vec<u32> {
    let mut twins = vec![NONE; 3 * faces.len()];
    for group in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, h), (_, g)] = group {
            if start_of(faces, *h) != start_of(faces, *g) {
                (twins[*h as usize], twins[*g as usize]) = (*g, *h);
            }
            continue;
        }
        if group.len() > 2 {
            on_fault(group[0].1 as usize / 3);
        }
        // Cosine of the bend for each pair with consistent winding, flattest first.
        let normal = |h: u32| face_normal(points, faces[h as usize / 3]);
        let mut pairs = Vec::new();
        for (i, (_, h)) in group.iter().enumerate() {
            for (_, g) in &group[i + 1..] {
                if start_of(faces, *h) != start_of(faces, *g) {
                    // Faces folded back to back have opposite normals and come last.
                    pairs.push((normal(*h).dot(normal(*g)), *h, *g));
                }
            }
        }
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, h, g) in pairs {
            if twins[h as usize] == NONE && twins[g as usize] == NONE {
                (twins[h as usize], twins[g as usize]) = (g, h);
            }
        }
    }
    twins
}
