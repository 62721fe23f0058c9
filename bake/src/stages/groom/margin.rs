//! `groom.bare_margin_m`: hair grows short towards bare parts, so that none hangs over an eye.

use crate::mesh::{Mesh, RestPose};
use crate::stages::cells::{Cells, closest};
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

/// What lies below the skin by more than this, as the cosine of the angle from straight down, is no neighbour on it: teeth behind a cheek.
const BELOW: f32 = 0.5;
/// A bare part as near as this share of the margin lies at the skin, though it is not joined to it: an eye in its socket. What is below the skin by half of
/// that is seen from nowhere within this reach as lying beside it.
const BESIDE: f32 = 0.5;
/// Nearer than this share of the margin the directions of bare parts are noise.
const TOUCHING: f32 = 0.02;

/// Scales `length`, one per vertex, from 0 at the border of a bare part to itself at `margin_m` from it, smoothly.
///
/// * `furred`: one per material; the shorter list counts as bare at its end
/// * `rest`: of `mesh`, metres
///
/// The way begins where a bare part is joined to the skin or lies beside or above it within half the margin, and leads along the edges of the furred skin.
/// It is known at vertices: a bare part that lies in the middle of a large triangle shortens nothing.
pub fn fade_to_bare(length: &mut [f32], mesh: &Mesh, rest: &RestPose, furred: &[bool], margin_m: f32) {
    if margin_m <= 0.0 {
        return;
    }
    let is_furred = |material: usize| furred.get(material).copied().unwrap_or(false);
    let triangles = |wanted: bool| -> Vec<[u32; 3]> {
        let parts = mesh.parts.iter().filter(|part| is_furred(part.material) == wanted);
        let of = |first: usize, count: usize| mesh.triangles.iter().skip(first).take(count).copied();
        parts.flat_map(|part| of(part.first_triangle, part.triangle_count)).collect()
    };
    let (skin, bare) = (triangles(true), triangles(false));
    if bare.is_empty() {
        return;
    }
    let places = places(&skin, &rest.positions);
    let mut ways = straight(&places, &bare, rest, margin_m);
    along(&mut ways, &skin, &places, rest, margin_m);
    for (vertex, place) in &places.of_vertex {
        if let Some(length) = length.get_mut(*vertex as usize) {
            let t = (ways[*place] / margin_m).clamp(0.0, 1.0);
            *length *= t * t * (3.0 - 2.0 * t);
        }
    }
}

/// The distinct places of the furred skin.
struct Places {
    /// Of each vertex of the skin the number of its place.
    of_vertex: BTreeMap<u32, usize>,
    /// Of each place its first vertex.
    vertex: Vec<u32>,
}

fn places(skin: &[[u32; 3]], positions: &[Vec3]) -> Places {
    let mut seen: HashMap<[u32; 3], usize> = HashMap::new();
    let mut found = Places { of_vertex: BTreeMap::new(), vertex: Vec::new() };
    for vertex in skin.iter().flatten() {
        // Adding zero turns -0 into +0.
        let key = (positions[*vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        let place = *seen.entry(key).or_insert(found.vertex.len());
        if place == found.vertex.len() {
            found.vertex.push(*vertex);
        }
        found.of_vertex.insert(*vertex, place);
    }
    found
}

/// Of each place the straight way to the nearest bare triangle that is not below the skin there, metres; infinite where none is near.
fn straight(places: &Places, bare: &[[u32; 3]], rest: &RestPose, margin_m: f32) -> Vec<f32> {
    let place = |vertex: u32| rest.positions[vertex as usize];
    let reach = BESIDE * margin_m;
    let cells = Cells::new(bare, &place, reach);
    let way = |vertex: &u32| {
        let (from, normal) = (place(*vertex), rest.normals[*vertex as usize]);
        let mut least = f32::INFINITY;
        for triangle in cells.within(from, reach) {
            let corners = bare[triangle as usize].map(place);
            let weights = closest(from, corners);
            let to = (corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z) - from;
            let distance = to.length();
            let is_beside = distance <= TOUCHING * margin_m || to.dot(normal) >= -BELOW * distance;
            if is_beside && distance <= reach {
                least = least.min(distance);
            }
        }
        least
    };
    places.vertex.iter().map(way).collect()
}

/// A place on the way, the nearest first, then by its number.
#[derive(PartialEq)]
struct Step {
    way: f32,
    place: usize,
}

impl Eq for Step {}

impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Step {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.way.total_cmp(&other.way).then(self.place.cmp(&other.place))
    }
}

/// Shortens the ways to those along the edges of the skin (Dijkstra 1959), up to the margin.
fn along(ways: &mut [f32], skin: &[[u32; 3]], places: &Places, rest: &RestPose, margin_m: f32) {
    let mut neighbours: Vec<Vec<(usize, f32)>> = vec![Vec::new(); ways.len()];
    for triangle in skin {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let ends = [triangle[a], triangle[b]];
            let [p, q] = ends.map(|v| rest.positions[v as usize]);
            if let [Some(from), Some(to)] = ends.map(|v| places.of_vertex.get(&v).copied()) {
                neighbours[from].push((to, p.distance(q)));
                neighbours[to].push((from, p.distance(q)));
            }
        }
    }
    let starts = ways.iter().enumerate().filter(|(_, way)| way.is_finite());
    let mut open: BinaryHeap<Reverse<Step>> = starts.map(|(place, way)| Reverse(Step { way: *way, place })).collect();
    while let Some(Reverse(Step { way, place })) = open.pop() {
        if way > ways[place] {
            continue;
        }
        for (next, step) in &neighbours[place] {
            let through = way + step;
            if through < ways[*next] && through <= margin_m {
                ways[*next] = through;
                open.push(Reverse(Step { way: through, place: *next }));
            }
        }
    }
}

#[cfg(test)]
#[path = "margin_tests.rs"]
mod tests;
