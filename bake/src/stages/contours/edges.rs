//! Edges and faces of the welded mesh, and the number of edges that contours cross.

use super::weld::Weld;
use glam::Vec3;
use pelage_formats::{ContourEdge, ContourFace, ContourMesh};
use pelage_import::mesh::{Mesh, RestPose};
use rayon::prelude::*;

/// Factor on the largest number of crossed edges found at rest, for other poses and near eyes.
const RESERVE: f32 = 1.5;

/// Edges and faces of the welded mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct FaceEdges {
    pub(super) edges: Vec<ContourEdge>,
    pub(super) faces: Vec<ContourFace>,
    /// Representatives of the corners of each triangle of the mesh.
    pub(super) of_triangle: Vec<[u32; 3]>,
}

impl FaceEdges {
    /// Triangles with two corners at the same position have no face.
    pub(super) fn new(mesh: &Mesh, weld: &Weld) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| weld.representatives[v as usize]);
        let of_triangle: Vec<[u32; 3]> = mesh.triangles.iter().map(corners).collect();
        let is_degenerate = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| weld.places[v as usize]);
            a == b || b == c || c == a
        };
        let kept: Vec<[u32; 3]> = of_triangle.iter().filter(|t| !is_degenerate(t)).copied().collect();
        // Sides of all faces, sorted by edge: its vertices, whether the side runs against it, number of the side.
        let mut sides: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(3 * kept.len());
        for (i, face) in kept.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                sides.push(([a.min(b), a.max(b)], a > b, (3 * i + k) as u32));
            }
        }
        sides.par_sort_unstable();
        let mut edges: Vec<ContourEdge> = Vec::with_capacity(sides.len() / 2 + 1);
        let mut faces = vec![ContourFace::default(); kept.len()];
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            let against = group.partition_point(|(_, against, _)| !against);
            let (first, copies) = (edges.len(), against.max(group.len() - against));
            edges.extend(std::iter::repeat_n(group[0].0, copies));
            for (n, (_, is_against, side)) in group.iter().enumerate() {
                let copy = if *is_against { n - against } else { n };
                let (face, k) = (&mut faces[*side as usize / 3], *side % 3);
                face.edges[k as usize] = (first + copy) as u32;
                face.flags |= u32::from(*is_against) << k;
            }
        }
        Self { edges, faces, of_triangle }
    }
}

/// Returns one of each pair of opposite directions among the 42 vertices of a subdivided icosahedron. Both directions
/// of a pair give the same contours.
fn directions() -> Vec<Vec3> {
    let golden = 0.5 + 0.5 * 5f32.sqrt();
    let mut corners = Vec::new();
    for (a, b) in [(1.0, golden), (1.0, -golden), (-1.0, golden), (-1.0, -golden)] {
        corners.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    let mut all = corners.clone();
    for (i, a) in corners.iter().enumerate() {
        // Edges of this icosahedron have length 2.
        all.extend(corners[..i].iter().filter(|b| a.distance(**b) < 2.1).map(|b| *a + *b));
    }
    let is_first = |d: &Vec3| d.to_array().into_iter().find(|x| x.abs() > 1e-4).is_some_and(|x| x > 0.0);
    all.retain(is_first);
    all
}

/// Returns the budget of crossed edges: the largest number over the directions, with a reserve.
pub(super) fn most_nodes(edges: &[ContourEdge], rest: &RestPose) -> u32 {
    let crossed = |towards: &Vec3| {
        let front: Vec<bool> = rest.normals.iter().map(|n| n.dot(*towards) > 0.0).collect();
        edges.iter().filter(|[a, b]| front[*a as usize] != front[*b as usize]).count()
    };
    let most = directions().par_iter().map(crossed).max().unwrap_or(0);
    let wanted = (RESERVE * most as f32) as u32;
    wanted.max(1).next_multiple_of(ContourMesh::NODE_STEP).min(ContourMesh::MOST_NODES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_half_of_42() {
        let all = directions();
        assert_eq!(all.len(), 21);
        let near = |a: &Vec3, b: &Vec3| a.normalize().dot(b.normalize()).abs() > 0.99;
        assert!(all.iter().enumerate().all(|(i, a)| !all[..i].iter().any(|b| near(a, b))));
    }
}
