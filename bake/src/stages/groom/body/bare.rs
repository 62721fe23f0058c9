//! Proximity to eyes, nose and mouth, which are small bare parts of the mesh.

use super::input::Body;
use super::welded_mesh::WeldedMesh;
use crate::noise::smooth_step;
use crate::stages::cells::{TriangleGrid, closest_barycentric};
use pelage_import::union_find::root;

/// Distance from bare parts within which hair is shortened, in body radii.
const REACH: f32 = 0.15;
/// Maximum gap between a bare part and the surrounding surface, such as around an eyeball in its socket, in body radii.
const GAP: f32 = 0.03;
/// Maximum share of the whole area for a bare part. Larger ones are garments or shells, beside which hair is not
/// shortened.
const LARGEST: f32 = 0.04;

/// Returns for each triangle of the body whether hair grows on it.
pub(in crate::stages::groom) fn furred_faces(body: &Body<'_>) -> Vec<bool> {
    let mut faces = vec![false; body.mesh.triangles.len()];
    for part in body.mesh.parts.iter().filter(|part| body.furred.get(part.material) == Some(&true)) {
        faces[part.first_triangle..part.first_triangle + part.triangle_count].fill(true);
    }
    faces
}

/// Returns for each welded vertex whether a furred triangle touches it.
pub(super) fn furred_places(body: &Body<'_>, skin: &WeldedMesh) -> Vec<bool> {
    let mut places = vec![false; skin.len()];
    let faces = skin.faces.iter().zip(furred_faces(body));
    faces.filter(|(_, furred)| *furred).flat_map(|(face, _)| face).for_each(|p| places[*p as usize] = true);
    places
}

/// Returns the proximity of each welded vertex to a small bare part, along the surface. It is 1 at the border of the
/// part, and 0 from [`REACH`] on.
pub(super) fn proximity(body: &Body<'_>, skin: &WeldedMesh) -> Vec<f32> {
    let furred = furred_faces(body);
    let bare: Vec<[u32; 3]> = skin.faces.iter().zip(&furred).filter(|(_, furred)| !**furred).map(|(f, _)| *f).collect();
    let small = small_parts(skin, &bare);
    if small.is_empty() {
        return vec![0.0; skin.len()];
    }
    let place = |p: u32| skin.positions[p as usize];
    let cells = TriangleGrid::new(&small, &place, GAP);
    let gap = |p: u32| {
        let at = place(p);
        let distance = |triangle: u32| {
            let corners = small[triangle as usize].map(place);
            let w = closest_barycentric(at, corners);
            at.distance(corners[0] * w.x + corners[1] * w.y + corners[2] * w.z)
        };
        cells.within(at, GAP).map(distance).fold(f32::INFINITY, f32::min)
    };
    let seeds = (0..skin.len() as u32).map(|p| (p, gap(p))).filter(|(_, gap)| *gap <= GAP);
    let distances = skin.distances(seeds, REACH);
    distances.into_iter().map(|distance| 1.0 - smooth_step(0.0, REACH, distance)).collect()
}

/// Returns the bare triangles whose connected part is small.
fn small_parts(skin: &WeldedMesh, bare: &[[u32; 3]]) -> Vec<[u32; 3]> {
    // The smallest vertex index represents each connected component.
    let mut least: Vec<u32> = (0..skin.len() as u32).collect();
    for face in bare {
        for other in &face[1..] {
            let (a, b) = (root(&mut least, face[0]), root(&mut least, *other));
            least[a.max(b) as usize] = a.min(b);
        }
    }
    let area = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|p| skin.positions[p as usize]);
        (b - a).cross(c - a).length() / 2.0
    };
    let mut areas = vec![0.0; skin.len()];
    for face in bare {
        areas[root(&mut least, face[0]) as usize] += area(face);
    }
    let whole: f32 = skin.areas.iter().sum();
    bare.iter().filter(|face| areas[root(&mut least, face[0]) as usize] <= LARGEST * whole).copied().collect()
}
