//! Static lines of the ink style: sharp edges and open boundaries, joined into lines of evenly spaced points.

use super::target::ContourTarget;
use super::weld::Weld;
use glam::Vec3;
use pelage_formats::{ContourMesh, CreasePoint};
use rayon::prelude::*;
use std::cmp::Reverse;

/// Cosine of the angle between the normals of two faces below which their edge is sharp: 60°.
const SHARP_COSINE: f32 = 0.5;
/// Maximum distance of points, as a share of the radius of the bounding sphere.
const SPACING: f32 = 0.02;
/// Minimum length of a line, as a share of the radius.
const SHORTEST: f32 = 0.04;

/// Sharp edge or boundary between two places.
#[derive(Clone, Copy, Debug)]
struct Crease {
    places: [u32; 2],
    /// Mesh vertices at these places.
    vertices: [u32; 2],
    kind: u16,
}

/// Returns the points of all lines, the longest line first. Lines beyond the limit of the format are left out.
///
/// * `corners`: representatives of the corners of each triangle
pub(super) fn crease_points(target: &ContourTarget<'_>, weld: &Weld, corners: &[[u32; 3]]) -> Vec<CreasePoint> {
    let positions = &target.rest.positions;
    let creases = creases(target, weld, corners);
    let length = |crease: &Crease| {
        let [a, b] = crease.vertices.map(|v| positions[v as usize]);
        a.distance(b)
    };
    let mut lines: Vec<(f32, Vec<Crease>, bool)> = lines(&creases, weld.place_count)
        .into_iter()
        .map(|(line, is_closed)| (line.iter().map(length).sum(), line, is_closed))
        .filter(|(total, ..)| *total >= SHORTEST * target.radius)
        .collect();
    lines.sort_by_key(|(total, ..)| Reverse(total.to_bits()));
    let mut points = Vec::new();
    for (_, line, is_closed) in lines {
        let first = points.len();
        for crease in &line {
            let parts = (length(crease) / (SPACING * target.radius)).ceil().clamp(1.0, 255.0) as u32;
            let share = |part: u32| (65_535 * part / parts) as u16;
            points.extend((0..parts).map(|part| CreasePoint {
                vertices: crease.vertices,
                share: share(part),
                kind: crease.kind,
                next: 0,
            }));
        }
        if let Some(last) = line.last().filter(|_| !is_closed) {
            let [_, end] = last.vertices;
            points.push(CreasePoint { vertices: [end, end], share: 0, kind: last.kind, next: 0 });
        }
        if points.len() > ContourMesh::MOST_NODES as usize {
            points.truncate(first);
            break;
        }
        let end = points.len();
        for (i, point) in points[first..].iter_mut().enumerate() {
            let next = first + i + 1;
            point.next = match (next < end, is_closed) {
                (true, _) => next as u32,
                (false, true) => first as u32,
                (false, false) => CreasePoint::NONE,
            };
        }
    }
    points
}

/// Returns the sharp edges and boundaries of the mesh, ordered by their places.
fn creases(target: &ContourTarget<'_>, weld: &Weld, corners: &[[u32; 3]]) -> Vec<Crease> {
    let (mesh, positions) = (target.mesh, &target.rest.positions);
    let mut is_furred = vec![false; corners.len()];
    for part in mesh.parts.iter().filter(|part| target.furred.get(part.material) == Some(&true)) {
        is_furred[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
    }
    // Sides of all triangles, sorted by the places at their ends.
    let mut sides: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * corners.len());
    for (t, triangle) in corners.iter().enumerate() {
        let places = triangle.map(|v| weld.places[v as usize]);
        for k in 0..3u8 {
            let (a, b) = (places[usize::from(k)], places[(usize::from(k) + 1) % 3]);
            if a != b && places[(usize::from(k) + 2) % 3] != a && places[(usize::from(k) + 2) % 3] != b {
                sides.push(([a.min(b), a.max(b)], t as u32, k));
            }
        }
    }
    sides.par_sort_unstable();
    // Vertices at both ends of a side, in the order of its places.
    let ends = |&(places, t, k): &([u32; 2], u32, u8)| {
        let triangle = corners[t as usize];
        let (a, b) = (triangle[usize::from(k)], triangle[(usize::from(k) + 1) % 3]);
        if weld.places[a as usize] == places[0] { [a, b] } else { [b, a] }
    };
    let normal = |t: u32| {
        let [a, b, c] = corners[t as usize].map(|v| positions[v as usize]);
        (b - a).cross(c - a).normalize_or(Vec3::ZERO)
    };
    let mut found = Vec::new();
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        let kind = match group {
            [_] => CreasePoint::BOUNDARY,
            [one, other] => {
                let (t, u) = (one.1, other.1);
                // Hair hides edges across which the normals are smooth.
                let is_hidden = is_furred[t as usize] && is_furred[u as usize] && ends(one) == ends(other);
                if is_hidden || normal(t).dot(normal(u)) >= SHARP_COSINE {
                    continue;
                }
                CreasePoint::SHARP
            }
            _ => continue,
        };
        found.push(Crease { places: group[0].0, vertices: ends(&group[0]), kind });
    }
    found
}

/// Joins creases into lines, which end where not exactly two creases meet. The second value is true for a closed line.
fn lines(creases: &[Crease], place_count: usize) -> Vec<(Vec<Crease>, bool)> {
    let mut degree = vec![0u32; place_count];
    creases.iter().flat_map(|crease| crease.places).for_each(|place| degree[place as usize] += 1);
    let mut at = vec![[u32::MAX; 2]; place_count];
    for (i, crease) in creases.iter().enumerate() {
        for place in crease.places {
            let slots = &mut at[place as usize];
            slots[usize::from(slots[0] != u32::MAX)] = i as u32;
        }
    }
    let is_end = |place: &u32| degree[*place as usize] != 2;
    let ends = creases.iter().enumerate();
    let ends = ends.filter_map(|(i, crease)| Some((i, *crease.places.iter().find(|place| is_end(place))?)));
    // Lines that remain after those with ends are closed.
    let starts = ends.chain(creases.iter().enumerate().map(|(i, crease)| (i, crease.places[0])));
    let (mut used, mut out) = (vec![false; creases.len()], Vec::new());
    for (first, start) in starts {
        let (mut line, mut from, mut next) = (Vec::new(), start, Some(first).filter(|i| !used[*i]));
        while let Some(i) = next {
            used[i] = true;
            let Crease { places: [a, b], vertices: [u, v], kind } = creases[i];
            let is_turned = from == b;
            line.push(if is_turned { Crease { places: [b, a], vertices: [v, u], kind } } else { creases[i] });
            from = if is_turned { a } else { b };
            let free = |n: &u32| *n != u32::MAX && !used[*n as usize];
            let goes_on = degree[from as usize] == 2 && from != start;
            next = at[from as usize].into_iter().find(free).filter(|_| goes_on).map(|n| n as usize);
        }
        if !line.is_empty() {
            out.push((line, from == start));
        }
    }
    out
}
