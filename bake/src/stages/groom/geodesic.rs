//! Geodesic distances on the mesh surface, by fast marching over its faces.
//!
//! Depending on the triangulation, paths along edges alone are too long by a tenth or more. A circle becomes a polygon
//! on a coarse mesh. So distances also propagate across faces. The triangle is unfolded into a plane. There, distance
//! is measured straight from the virtual source of the two known corners (Kimmel and Sethian 1998; Novotni and Klein
//! 2002).

use super::body::WeldedMesh;
use glam::Vec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Returns the geodesic distances of all vertices, in mesh units; infinite beyond `reach` and where no seed is
/// connected.
///
/// * `seeds`: vertices with their initial distances, at least 0
pub(super) fn geodesic_distances(skin: &WeldedMesh, seeds: &[(u32, f32)], reach: f32) -> Vec<f32> {
    let faces_of = VertexFaces::new(skin);
    let mut ways = vec![f32::INFINITY; skin.len()];
    // For non-negative floats the bit patterns sort like the values.
    let mut front: BinaryHeap<Reverse<(u32, u32)>> = BinaryHeap::new();
    let shorten = |ways: &mut [f32], front: &mut BinaryHeap<_>, place: u32, way: f32| {
        if way <= reach && way < ways[place as usize] {
            ways[place as usize] = way;
            front.push(Reverse((way.to_bits(), place)));
        }
    };
    seeds.iter().for_each(|(place, way)| shorten(&mut ways, &mut front, *place, way.max(0.0)));
    while let Some(Reverse((bits, place))) = front.pop() {
        let here = f32::from_bits(bits);
        if here > ways[place as usize] {
            continue;
        }
        for face in faces_of.of(place) {
            let corners = skin.faces[*face as usize];
            let Some(k) = corners.iter().position(|corner| *corner == place) else { continue };
            for (to, by) in [(corners[(k + 1) % 3], corners[(k + 2) % 3]), (corners[(k + 2) % 3], corners[(k + 1) % 3])]
            {
                let [a, b, c] = [place, by, to].map(|p| skin.positions[p as usize]);
                let along_edge = here + a.distance(c);
                let over_face = distance_across(a, b, c, here, ways[by as usize]);
                shorten(&mut ways, &mut front, to, over_face.map_or(along_edge, |way| way.min(along_edge)));
            }
        }
    }
    ways
}

/// Returns the distance of corner `c`, measured through the side from `a` to `b`, from the virtual source of the
/// distances at `a` and `b`. Returns `None` if the straight path does not cross that side.
fn distance_across(a: Vec3, b: Vec3, c: Vec3, way_a: f32, way_b: f32) -> Option<f32> {
    let side = a.distance(b);
    if !(side > 0.0 && way_b.is_finite()) {
        return None;
    }
    // In the triangle's plane, a is at the origin and b on the x axis; c is above that axis and the virtual source
    // below.
    let along = (b - a) / side;
    let x_c = (c - a).dot(along);
    let y_c = ((c - a) - along * x_c).length();
    let x = (way_a * way_a - way_b * way_b + side * side) / (2.0 * side);
    let square = way_a * way_a - x * x;
    if square < 0.0 || y_c <= 0.0 {
        return None;
    }
    let y = square.sqrt();
    let crossing = x + (x_c - x) * y / (y + y_c);
    (0.0..=side).contains(&crossing).then(|| ((x_c - x) * (x_c - x) + (y + y_c) * (y + y_c)).sqrt())
}

/// Indices of the faces around each vertex.
struct VertexFaces {
    /// Start of the faces of each vertex: vertex `i` has `faces[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl VertexFaces {
    fn new(skin: &WeldedMesh) -> Self {
        let mut starts = vec![0; skin.len() + 1];
        skin.faces.iter().flatten().for_each(|place| starts[*place as usize + 1] += 1);
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut next = starts.clone();
        let mut faces = vec![0; 3 * skin.faces.len()];
        for (face, corners) in (0..).zip(&skin.faces) {
            for place in corners {
                let slot = &mut next[*place as usize];
                faces[*slot as usize] = face;
                *slot += 1;
            }
        }
        Self { starts, faces }
    }

    fn of(&self, place: u32) -> &[u32] {
        &self.faces[self.starts[place as usize] as usize..self.starts[place as usize + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_import::mesh::{Mesh, RestPose};

    /// Builds a flat sheet of squares of width 0.1, centred on the origin. All squares are cut along the same diagonal.
    fn sheet(squares: u32) -> WeldedMesh {
        let half = 0.05 * squares as f32;
        let points = (0..=squares).flat_map(|i| (0..=squares).map(move |j| Vec3::new(i as f32, j as f32, 0.0) * 0.1));
        let rest =
            RestPose { positions: points.map(|p| p - Vec3::new(half, half, 0.0)).collect(), normals: Vec::new() };
        let at = |i: u32, j: u32| i * (squares + 1) + j;
        let cells = (0..squares).flat_map(|i| (0..squares).map(move |j| (i, j)));
        let triangles = cells.flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        WeldedMesh::new(&Mesh { triangles: triangles.collect(), ..Mesh::default() }, &rest, Vec3::ZERO, 1.0)
    }

    #[test]
    fn geodesic_distances_on_a_sheet_are_straight_lines() {
        let skin = sheet(20);
        let middle = (0..skin.len() as u32).find(|p| skin.positions[*p as usize].length() < 1e-4).unwrap_or_default();
        let found = geodesic_distances(&skin, &[(middle, 0.0)], 0.8);
        for (p, way) in skin.positions.iter().zip(&found) {
            if p.length() < 0.799 {
                assert!((way - p.length()).abs() < 1e-3, "{p}: {way} instead of {}", p.length());
            } else if p.length() > 0.801 {
                assert_eq!(*way, f32::INFINITY, "{p}");
            }
        }
        // Distances along edges alone are too long by up to a tenth.
        let along = skin.distances([(middle, 0.0)].into_iter(), 0.8);
        let worst = skin.positions.iter().zip(&along).filter(|(_, w)| w.is_finite()).map(|(p, w)| w - p.length());
        assert!(worst.fold(0.0, f32::max) > 0.05);
    }

    #[test]
    fn degenerate_triangles_keep_distances_finite() {
        let mut skin = sheet(4);
        let [a, b, _] = skin.faces[0];
        skin.faces.extend([[a, a, b], [a, a, a]]);
        assert!(geodesic_distances(&skin, &[(a, 0.0)], 10.0).iter().all(|way| way.is_finite()));
    }
}
