//! `groom.bare_margin_m`: hair gets shorter towards bare parts, so that it does not cover an eye.

use crate::decision::{Decision, metres_in_words};
use crate::noise::smooth_step;
use crate::stages::cells::{TriangleGrid, closest_barycentric};
use glam::Vec3;
use pelage_import::mesh::{Mesh, RestPose};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

/// Cosine of the half angle of a cone about the inward normal. A bare part in this cone counts as below the surface,
/// such as teeth behind a cheek.
const BELOW: f32 = 0.5;
/// Share of the reach within which an unconnected bare part counts as beside the surface, such as an eye in its socket.
/// A part that is deeper below the surface than half this distance never counts as beside it.
const BESIDE: f32 = 0.5;
/// Distance from a bare part below which the direction to it is ignored as noise, as a share of the reach.
const TOUCHING: f32 = 0.02;

/// Maximum ratio of hair length to the root's distance from a bare part. An eye at the side of a head is seen past the
/// hair in front of it, so upright hair covers part of it. The value was measured on ten animals from the front
/// (`eyes-covered` in `tests/src/bin/chores/`).
const STEEPEST: f32 = 0.12;
/// Number of iterations that determine the margin. Each measures the hair within the previous margin.
const ROUNDS: usize = 2;
/// Maximum of the chosen margin, in model radii. It is the reach of the automatic groom around bare parts.
const WIDEST: f32 = 0.15;

/// Distances of the furred surface from bare parts.
///
/// A path starts where a bare part is joined to the surface, or is beside or above the surface within half the reach.
/// It follows the edges of the furred surface. Distances are evaluated at vertices. A bare part in the middle of a
/// large triangle may therefore be too far from every vertex to count.
#[derive(Debug)]
pub struct BareDistances {
    places: WeldedVertices,
    /// Distance of each welded vertex, metres; infinite beyond the reach.
    ways: Vec<f32>,
    reach_m: f32,
}

impl BareDistances {
    /// Computes the distances from bare parts.
    ///
    /// * `rest`: rest pose of `mesh`, metres
    /// * `furred`: one per material; missing entries count as bare
    /// * `reach_m`: maximum distance, above 0
    pub fn new(mesh: &Mesh, rest: &RestPose, furred: &[bool], reach_m: f32) -> Self {
        let is_furred = |material: usize| furred.get(material).copied().unwrap_or(false);
        let triangles = |wanted: bool| -> Vec<[u32; 3]> {
            let parts = mesh.parts.iter().filter(|part| is_furred(part.material) == wanted);
            let of = |first: usize, count: usize| mesh.triangles.iter().skip(first).take(count).copied();
            parts.flat_map(|part| of(part.first_triangle, part.triangle_count)).collect()
        };
        let (skin, bare) = (triangles(true), triangles(false));
        if bare.is_empty() {
            return Self { places: WeldedVertices::default(), ways: Vec::new(), reach_m };
        }
        let places = places(&skin, &rest.positions);
        let mut ways = straight_distances(&places, &bare, rest, reach_m);
        relax_along_edges(&mut ways, &skin, &places, rest, reach_m);
        Self { places, ways, reach_m }
    }

    /// Multiplies `length`, one per vertex, by a smooth factor from 0 at the border of a bare part to 1 at the reach.
    pub fn shorten(&self, length: &mut [f32]) {
        for (vertex, place) in &self.places.of_vertex {
            if let Some(length) = length.get_mut(*vertex as usize) {
                *length *= smooth_step(0.0, 1.0, self.ways[*place] / self.reach_m);
            }
        }
    }

    /// Returns the mean length of the hair within `within_m` of bare parts, metres; `None` if no hair grows there.
    ///
    /// * `length`: one per vertex, share of the longest hair
    /// * `longest_m`: length of the longest hair, metres
    fn mean_m(&self, length: &[f32], longest_m: f32, within_m: f32) -> Option<f32> {
        let near = self.places.of_vertex.iter().filter(|(_, place)| self.ways[**place] <= within_m);
        let lengths = near.filter_map(|(vertex, _)| length.get(*vertex as usize)).filter(|length| **length > 0.0);
        let (sum, count) = lengths.fold((0.0, 0u32), |(sum, count), length| (sum + f64::from(*length), count + 1));
        (count > 0).then(|| (sum / f64::from(count)) as f32 * longest_m)
    }
}

/// Returns the margin for the hair of a model, metres. It is just wide enough that hair beside bare parts does not hide
/// them. Returns `None` if no hair is beside a bare part.
///
/// * `rest`: rest pose of `mesh`, metres
/// * `furred`: one per material
/// * `length`: one per vertex, share of the longest hair
/// * `longest_m`: length of the longest hair, metres
/// * `radius_m`: radius of the model, above 0
pub fn chosen_margin_m(
    (mesh, rest): (&Mesh, &RestPose),
    furred: &[bool],
    length: &[f32],
    longest_m: f32,
    radius_m: f32,
) -> Option<f32> {
    if longest_m <= 0.0 || radius_m <= 0.0 {
        return None;
    }
    let widest_m = WIDEST * radius_m;
    let beside = BareDistances::new(mesh, rest, furred, widest_m);
    // Hair length rises along a smoothstep curve over the margin. The steepest line from its origin to the curve has
    // slope 9/8, which limits the ratio of length to distance. A wider margin includes longer hair, so iterate.
    let mut margin_m = longest_m.min(widest_m);
    for _ in 0..ROUNDS {
        let length_m = beside.mean_m(length, longest_m, margin_m)?;
        margin_m = (1.125 * length_m / STEEPEST).min(widest_m);
    }
    Some(margin_m)
}

/// Describes the choice of a margin, metres.
pub fn margin_decision(margin_m: f32) -> Decision {
    Decision {
        what: "margin of bare parts",
        chosen: format!("hair reaches its full length {} away from them", metres_in_words(margin_m)),
        line: format!("groom.bare_margin_m = {margin_m}"),
    }
}

/// Welded vertices of the furred surface.
#[derive(Debug, Default)]
struct WeldedVertices {
    /// Welded vertex of each vertex.
    of_vertex: BTreeMap<u32, usize>,
    /// Index of the first vertex of each welded vertex.
    vertex: Vec<u32>,
}

fn places(skin: &[[u32; 3]], positions: &[Vec3]) -> WeldedVertices {
    let mut seen: HashMap<[u32; 3], usize> = HashMap::new();
    let mut found = WeldedVertices { of_vertex: BTreeMap::new(), vertex: Vec::new() };
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

/// Returns the straight distance of each welded vertex from the nearest bare triangle, metres. Triangles below the
/// surface at that vertex are ignored. The distance is infinite if no triangle is within half the margin.
fn straight_distances(places: &WeldedVertices, bare: &[[u32; 3]], rest: &RestPose, margin_m: f32) -> Vec<f32> {
    let place = |vertex: u32| rest.positions[vertex as usize];
    let reach = BESIDE * margin_m;
    let cells = TriangleGrid::new(bare, &place, reach);
    let way = |vertex: &u32| {
        let (from, normal) = (place(*vertex), rest.normals[*vertex as usize]);
        let mut least = f32::INFINITY;
        for triangle in cells.within(from, reach) {
            let corners = bare[triangle as usize].map(place);
            let weights = closest_barycentric(from, corners);
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

/// Dijkstra queue entry, ordered by distance, then by vertex index.
#[derive(PartialEq)]
struct QueueEntry {
    way: f32,
    place: usize,
}

impl Eq for QueueEntry {}

impl PartialOrd for QueueEntry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for QueueEntry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.way.total_cmp(&other.way).then(self.place.cmp(&other.place))
    }
}

/// Replaces each distance by the shortest path along the edges of the surface (Dijkstra 1959), if that is shorter.
/// Paths are at most as long as the margin.
fn relax_along_edges(ways: &mut [f32], skin: &[[u32; 3]], places: &WeldedVertices, rest: &RestPose, margin_m: f32) {
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
    let mut open: BinaryHeap<Reverse<QueueEntry>> =
        starts.map(|(place, way)| Reverse(QueueEntry { way: *way, place })).collect();
    while let Some(Reverse(QueueEntry { way, place })) = open.pop() {
        if way > ways[place] {
            continue;
        }
        for (next, step) in &neighbours[place] {
            let through = way + step;
            if through < ways[*next] && through <= margin_m {
                ways[*next] = through;
                open.push(Reverse(QueueEntry { way: through, place: *next }));
            }
        }
    }
}

#[cfg(test)]
#[path = "margin_tests.rs"]
mod tests;
