//! Adjacency of the faces of a mesh surface, and the choice of edges that are lines from a viewpoint.

use super::line::{ContourForm, LineParams};
use super::visible::{Family, MeshLine};
use glam::DVec3;
use pelage_bake::strands::PosedMesh;
use pelage_truth::{SurfaceView, SurfaceVisibility};
use std::collections::HashMap;

/// Edges of a mesh whose vertices at the same position are merged.
pub(super) struct Topology {
    /// Unit normal of each triangle, computed from its corners; zero for a triangle without area.
    normals: Vec<DVec3>,
    edges: Vec<Edge>,
}

struct Edge {
    /// Vertex indices of the ends in the mesh surface.
    ends: [u32; 2],
    /// Adjacent faces; only one where the mesh ends.
    faces: (u32, Option<u32>),
}

/// Side of a face, to be matched with others at its edge.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    /// Position indices of the ends, the smaller one first.
    places: [u32; 2],
    /// Whether the face runs from the larger index to the smaller one.
    backward: bool,
    face: u32,
    ends: [u32; 2],
}

impl Topology {
    pub(super) fn new(skin: &PosedMesh) -> Self {
        let place_of = position_ids(skin);
        let corner = |v: u32| skin.vertices[v as usize].position_ws;
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = t.map(corner);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let mut sides = Vec::with_capacity(3 * skin.triangles.len());
        for (face, triangle) in skin.triangles.iter().enumerate() {
            let place = triangle.map(|v| place_of[v as usize]);
            if place[0] == place[1] || place[1] == place[2] || place[2] == place[0] {
                // The triangle is degenerate to an edge, at which its neighbours meet.
                continue;
            }
            for k in 0..3 {
                let (i, j) = (k, (k + 1) % 3);
                let places = [place[i].min(place[j]), place[i].max(place[j])];
                let ends = [triangle[i], triangle[j]];
                sides.push(Side { places, backward: place[i] > place[j], face: face as u32, ends });
            }
        }
        sides.sort_unstable();
        let normals: Vec<DVec3> = skin.triangles.iter().map(normal).collect();
        let edges = sides.chunk_by(|a, b| a.places == b.places).flat_map(|around| pair(around, &normals)).collect();
        Self { normals, edges }
    }

    /// Returns the edges that are lines from a viewpoint, whether hidden or not.
    pub(super) fn pieces(
        &self,
        sight: &SurfaceVisibility,
        look: &SurfaceView<'_>,
        params: &LineParams,
    ) -> Vec<MeshLine> {
        let skin = sight.skin();
        let corner = |v: u32| skin.vertices[v as usize].position_ws;
        let middle = |face: u32| skin.corners(face as usize).iter().map(|c| c.position_ws).sum::<DVec3>() / 3.0;
        // Positive values mean that a face is towards the eye.
        let facing: Vec<f64> = self
            .normals
            .iter()
            .enumerate()
            .map(|(face, normal)| -normal.dot(look.direction_to(corner(skin.triangles[face][0]))))
            .collect();
        let faces_eye = |face: u32| facing[face as usize] > 0.0;
        let shows = |face: u32| faces_eye(face) || skin.material(face as usize).double_sided;
        let least_alike = params.crease_deg.to_radians().cos();
        let family = |edge: &Edge| -> Option<(Family, u32)> {
            let (first, Some(second)) = edge.faces else {
                let face = edge.faces.0;
                return shows(face).then_some((Family::Border, face));
            };
            let flat = |face: u32| self.normals[face as usize] == DVec3::ZERO;
            if flat(first) || flat(second) {
                // A face without area has no orientation.
                return None;
            }
            if faces_eye(first) != faces_eye(second) {
                let front = if faces_eye(first) { first } else { second };
                return (params.contour == ContourForm::Edges).then_some((Family::Contour, front));
            }
            let alike = self.normals[first as usize].dot(self.normals[second as usize]);
            (alike < least_alike && shows(first)).then_some((Family::Crease, first))
        };
        let slack_floor = SLACK_RADII * sight.radius_m();
        let piece = |edge: &Edge| {
            let (family, face) = family(edge)?;
            let [from, to] = edge.ends.map(corner);
            let slack_m = slack_floor.max(SLACK_EDGES * from.distance(to));
            Some(MeshLine { from, to, family, inside: middle(face), slack_m })
        };
        self.edges.iter().filter_map(piece).collect()
    }
}

/// Depth tolerance of the visibility test, as a fraction of the mesh surface's radius. A surface hides an edge only if
/// it is nearer to the eye by more than this. The ray meets the faces at the edge itself, up to rounding. Rays are in
/// f64, so a small value is enough; a larger one would show lines that a fold hides.
const SLACK_RADII: f64 = 1e-6;
/// Depth tolerance of the visibility test, in lengths of the edge. A ray meets a face seen edge-on up to this distance
/// in front of or behind the face's own border.
const SLACK_EDGES: f64 = 1e-3;

/// Returns an identifier for each vertex, which is the same for all vertices at the same position.
fn position_ids(skin: &PosedMesh) -> Vec<u32> {
    let mut first_at = HashMap::new();
    let place = |(i, v): (usize, &pelage_bake::strands::PosedVertex)| {
        // Adding zero turns −0 into +0.
        let key = (v.position_ws + 0.0).to_array().map(f64::to_bits);
        *first_at.entry(key).or_insert(i as u32)
    };
    skin.vertices.iter().enumerate().map(place).collect()
}

/// Returns the edges formed by the faces at one pair of positions. Where more than two faces meet, consistently wound
/// faces with the most similar normals are paired. Two touching sheets therefore remain two sheets. A face without a
/// partner has a border there.
fn pair(around: &[Side], normals: &[DVec3]) -> Vec<Edge> {
    let turn = around.partition_point(|side| !side.backward);
    let (forward, backward) = around.split_at(turn);
    let mut out = Vec::new();
    let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
    for (i, a) in forward.iter().enumerate() {
        for (j, b) in backward.iter().enumerate() {
            candidates.push((normals[a.face as usize].dot(normals[b.face as usize]), i, j));
        }
    }
    // The sort is stable, so equally similar faces keep their order in the mesh.
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut taken, mut used) = (vec![false; forward.len()], vec![false; backward.len()]);
    for (_, i, j) in candidates {
        if !taken[i] && !used[j] {
            (taken[i], used[j]) = (true, true);
            out.push(Edge { ends: forward[i].ends, faces: (forward[i].face, Some(backward[j].face)) });
        }
    }
    let mut left = |sides: &[Side], taken: &[bool]| {
        let alone = sides.iter().zip(taken).filter(|(_, taken)| !**taken);
        out.extend(alone.map(|(side, _)| Edge { ends: side.ends, faces: (side.face, None) }));
    };
    left(forward, &taken);
    left(backward, &used);
    out
}
