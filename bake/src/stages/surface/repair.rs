//! What is wrong with a mesh, put right: never a reason to reject it.
//!
//! Corners are joined into points by place; what is left without area, or there twice, is dropped; an edge of more than two
//! triangles keeps the pair that bends least and is cut for the others; a triangle wound against its neighbours is turned.

use super::topology::{NONE, Topology};
use glam::DVec3;
use pelage_import::mesh::Mesh;
use std::collections::HashMap;

/// Two places are one where they differ by less than this share of the mesh's extent: a few steps of an f32.
const JOIN_PER_EXTENT: f64 = 2e-7;
/// A triangle flatter than this share of the extent has no area that an f32 could hold.
const FLAT_PER_EXTENT: f64 = 4e-7;

/// What was found in one component: triangles that hang together by their points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Faults {
    /// Triangles of the component as they came.
    pub(super) triangles: u32,
    pub(super) first_triangle: u32,
    pub(super) zero_area: u32,
    pub(super) duplicate: u32,
    /// Edges with more than two triangles.
    pub(super) non_manifold_edges: u32,
    pub(super) flipped: u32,
    /// Edges cut because no winding suits both sides (a Möbius strip).
    pub(super) one_sided_edges: u32,
}

/// A sound mesh, and how it came from the one that was given.
#[derive(Clone, Debug, Default)]
pub(super) struct Repaired {
    pub(super) topology: Topology,
    /// For each face the triangle it came from.
    pub(super) triangles: Vec<u32>,
    /// For each face whether its corners 1 and 2 were exchanged.
    pub(super) flipped: Vec<bool>,
    /// One per component, in the order of their first triangles.
    pub(super) faults: Vec<Faults>,
}

/// Repairs the mesh of `triangles`, indices into `positions` (metres, at rest).
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
    out.flipped = make_windings_agree(&points, &mut sound, &component_of, &mut faults);
    let twins = pair(&points, &sound, |e| faults[component_of[e] as usize].non_manifold_edges += 1);
    out.topology = Topology::new(points, sound, twins);
    out.faults = faults;
    out
}

/// Components that get a line of their own; the rest is summed up in one.
const REPORTED: usize = 8;

/// Says what was repaired, component by component. `mesh` is the mesh before its repair.
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

    /// Empty where there is nothing to say.
    fn summary(&self) -> String {
        let said = [
            (self.zero_area, "triangles without area dropped"),
            (self.duplicate, "duplicate triangles dropped"),
            (self.non_manifold_edges, "edges of more than two triangles split"),
            (self.flipped, "triangles wound against their neighbours turned"),
            (self.one_sided_edges, "edges cut where no winding suits both sides"),
        ];
        let said: Vec<String> = said.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        said.join(", ")
    }
}

/// Joins the used vertices by place. Returns places, the place of each vertex, and the extent of the whole.
fn join_points(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Vec<DVec3>, Vec<u32>, f64) {
    let used = || triangles.iter().flatten().map(|v| positions[*v as usize]);
    let (min, max) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
    let extent = if min.x <= max.x { (max - min).max_element() } else { 0.0 };
    // Rounding to a grid can part two points that straddle a line of it; they then meet in a seam, which is what they would be.
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

/// Component of each face by shared points, and the faults to be counted in each.
fn components(points: usize, faces: &[[u32; 3]]) -> (Vec<u32>, Vec<Faults>) {
    let mut parent: Vec<u32> = (0..points as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
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
    // NaN where all three are one.
    height.is_nan() || height <= least_height
}

/// The face from its smallest point on: equal for equal triangles that are wound alike.
fn rotated([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// All half-edges, those of one edge next to each other, in a fixed order. An entry is the edge's points, smaller first, and the half-edge.
fn sorted_edges(faces: &[[u32; 3]]) -> Vec<([u32; 2], u32)> {
    let mut edges = Vec::with_capacity(3 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], (3 * f + k) as u32));
        }
    }
    edges.sort_unstable();
    edges
}

fn start_of(faces: &[[u32; 3]], h: u32) -> u32 {
    faces[h as usize / 3][h as usize % 3]
}

fn face_normal(points: &[DVec3], face: [u32; 3]) -> DVec3 {
    let [a, b, c] = face.map(|p| points[p as usize]);
    (b - a).cross(c - a).normalize_or_zero()
}

/// Turns triangles until neighbours agree; in each component the side with less area turns. Returns which faces turned.
fn make_windings_agree(
    points: &[DVec3],
    faces: &mut [[u32; 3]],
    component_of: &[u32],
    faults: &mut [Faults],
) -> Vec<bool> {
    // Only edges of two triangles tell: at others any winding finds a partner.
    let mut links: Vec<Vec<(u32, bool)>> = vec![Vec::new(); faces.len()];
    let mut any = false;
    for pair in sorted_edges(faces).chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2) {
        let [h, g] = [pair[0].1, pair[1].1];
        let against = start_of(faces, h) == start_of(faces, g);
        any |= against;
        links[h as usize / 3].push((g / 3, against));
        links[g as usize / 3].push((h / 3, against));
    }
    let mut flipped = vec![false; faces.len()];
    if !any {
        return flipped;
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

/// Twins of all half-edges. Of more than two on an edge, those pair first that bend least; `on_fault` gets a face of such edges.
fn pair(points: &[DVec3], faces: &[[u32; 3]], mut on_fault: impl FnMut(usize)) -> Vec<u32> {
    let mut twins = vec![NONE; 3 * faces.len()];
    for group in sorted_edges(faces).chunk_by(|a, b| a.0 == b.0) {
        if let [(_, h), (_, g)] = group {
            if start_of(faces, *h) != start_of(faces, *g) {
                (twins[*h as usize], twins[*g as usize]) = (*g, *h);
            }
            continue;
        }
        if group.len() > 2 {
            on_fault(group[0].1 as usize / 3);
        }
        // Cosine of the bend for each pair that is wound alike, flattest first.
        let normal = |h: u32| face_normal(points, faces[h as usize / 3]);
        let mut pairs = Vec::new();
        for (i, (_, h)) in group.iter().enumerate() {
            for (_, g) in &group[i + 1..] {
                if start_of(faces, *h) != start_of(faces, *g) {
                    // Two faces back to back have opposite normals too, but lie on the same side of the edge.
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
