//! `groom.bare_margin_m`: hair grows short towards bare parts, so that none hangs over an eye.

use crate::decision::{Decision, metres_in_words};
use crate::noise::smooth_step;
use crate::stages::cells::{Cells, closest};
use glam::Vec3;
use pelage_import::mesh::{Mesh, RestPose};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, HashMap};

/// What lies below the skin by more than this, as the cosine of the angle from straight down, is no neighbour on it: teeth behind a cheek.
const BELOW: f32 = 0.5;
/// A bare part as near as this share of the reach lies at the skin, though it is not joined to it: an eye in its socket. What is below the skin by half of
/// that is seen from nowhere within this reach as lying beside it.
const BESIDE: f32 = 0.5;
/// Nearer than this share of the reach the directions of bare parts are noise.
const TOUCHING: f32 = 0.02;

/// Longest hair over how far from a bare part it roots. An eye at the side of a head is seen past the hair before it, of which any that stands up hides some;
/// measured on ten animals from the front (`eyes-covered` in `tests/src/bin/chores/`).
const STEEPEST: f32 = 0.12;
/// How often the margin is chosen anew for the hair within it.
const ROUNDS: usize = 2;
/// Largest margin that is chosen, radii of the model: as far as the body's own groom looks.
const WIDEST: f32 = 0.15;

/// How far the furred skin is from bare parts.
///
/// A way begins where a bare part is joined to the skin or lies beside or above it within half the reach, and leads along the edges of the furred skin.
/// It is known at vertices: a bare part that lies in the middle of a large triangle is near nothing.
#[derive(Debug)]
pub struct BesideBare {
    places: Places,
    /// Of each place its way, metres; infinite from the reach on.
    ways: Vec<f32>,
    reach_m: f32,
}

impl BesideBare {
    /// Looks for bare parts.
    ///
    /// * `rest`: of `mesh`, metres
    /// * `furred`: one per material; the shorter list counts as bare at its end
    /// * `reach_m`: how far is looked, above 0
    pub fn new(mesh: &Mesh, rest: &RestPose, furred: &[bool], reach_m: f32) -> Self {
        let is_furred = |material: usize| furred.get(material).copied().unwrap_or(false);
        let triangles = |wanted: bool| -> Vec<[u32; 3]> {
            let parts = mesh.parts.iter().filter(|part| is_furred(part.material) == wanted);
            let of = |first: usize, count: usize| mesh.triangles.iter().skip(first).take(count).copied();
            parts.flat_map(|part| of(part.first_triangle, part.triangle_count)).collect()
        };
        let (skin, bare) = (triangles(true), triangles(false));
        if bare.is_empty() {
            return Self { places: Places::default(), ways: Vec::new(), reach_m };
        }
        let places = places(&skin, &rest.positions);
        let mut ways = straight(&places, &bare, rest, reach_m);
        along(&mut ways, &skin, &places, rest, reach_m);
        Self { places, ways, reach_m }
    }

    /// Scales `length`, one per vertex, from 0 at the border of a bare part to itself at the reach from it, smoothly.
    pub fn shorten(&self, length: &mut [f32]) {
        for (vertex, place) in &self.places.of_vertex {
            if let Some(length) = length.get_mut(*vertex as usize) {
                *length *= smooth_step(0.0, 1.0, self.ways[*place] / self.reach_m);
            }
        }
    }

    /// Mean length of the hair that is at most so far from bare parts, metres; `None` where there is none.
    ///
    /// * `length`: one per vertex, share of the longest hair
    /// * `longest_m`: that, metres
    fn mean_m(&self, length: &[f32], longest_m: f32, within_m: f32) -> Option<f32> {
        let near = self.places.of_vertex.iter().filter(|(_, place)| self.ways[**place] <= within_m);
        let lengths = near.filter_map(|(vertex, _)| length.get(*vertex as usize)).filter(|length| **length > 0.0);
        let (sum, count) = lengths.fold((0.0, 0u32), |(sum, count), length| (sum + f64::from(*length), count + 1));
        (count > 0).then(|| (sum / f64::from(count)) as f32 * longest_m)
    }
}

/// The margin for hair of a model, metres: what keeps hair as long as that beside bare parts from hiding them. `None` where none is beside any.
///
/// * `rest`: of `mesh`, metres
/// * `furred`: one per material
/// * `length`: one per vertex, share of the longest hair
/// * `longest_m`: that, metres
/// * `radius_m`: of the model, above 0
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
    let beside = BesideBare::new(mesh, rest, furred, widest_m);
    // The steepest way from the origin to the curve of lengths leads to 9/8 at three quarters. Hair grows longer away from bare parts, and with the
    // margin more of it counts.
    let mut margin_m = longest_m.min(widest_m);
    for _ in 0..ROUNDS {
        let length_m = beside.mean_m(length, longest_m, margin_m)?;
        margin_m = (1.125 * length_m / STEEPEST).min(widest_m);
    }
    Some(margin_m)
}

/// The choice of a margin, metres.
pub fn margin_decision(margin_m: f32) -> Decision {
    Decision {
        what: "margin of bare parts",
        chosen: format!("hair has its full length {} from them", metres_in_words(margin_m)),
        line: format!("groom.bare_margin_m = {margin_m}"),
    }
}

/// The distinct places of the furred skin.
#[derive(Debug, Default)]
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
