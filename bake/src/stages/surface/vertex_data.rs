//! Conversion from faces to vertices: applies the repair, splits vertices where sides disagree, and computes tile
//! coordinates and tangents per vertex.

use super::frames;
use super::furred_mesh::FurredMesh;
use super::lapped::Lapped;
use super::repair::Repaired;
use super::topology::NONE;
use glam::{DVec3, Vec2, Vec3, Vec4};
use pelage_formats::Animation;
use pelage_import::mesh::{Mesh, RestPose};
use std::collections::HashMap;

/// Per-vertex results for the split mesh.
pub(super) struct SplitVertices {
    pub(super) tile_uvs: Vec<Vec2>,
    pub(super) tangents: Vec<Vec4>,
}

/// Keeps the triangles that the repair kept, with their repaired windings. Normals of flipped triangles are recomputed.
pub(super) fn apply_repair(mesh: &mut Mesh, animation: Option<&Animation>, repaired: &Repaired) {
    let mut kept = vec![false; mesh.triangles.len()];
    repaired.triangles.iter().for_each(|t| kept[*t as usize] = true);
    for part in &mut mesh.parts {
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        let before = kept[..range.start].iter().filter(|k| **k).count();
        part.triangle_count = kept[range].iter().filter(|k| **k).count();
        part.first_triangle = before;
    }
    let turned = repaired.triangles.iter().zip(&repaired.flipped);
    let triangles = turned.map(|(t, flipped)| {
        let [a, b, c] = mesh.triangles[*t as usize];
        if *flipped { [a, c, b] } else { [a, b, c] }
    });
    mesh.triangles = triangles.collect();
    if repaired.flipped.contains(&true) {
        recompute_normals(mesh, animation, &repaired.flipped);
    }
}

/// Recomputes the normals at flipped triangles. They were computed from the wrong side of the triangle, or averaged
/// with such a normal.
fn recompute_normals(mesh: &mut Mesh, animation: Option<&Animation>, flipped: &[bool]) {
    let mut touched = vec![false; mesh.positions.len()];
    for (triangle, _) in mesh.triangles.iter().zip(flipped).filter(|(_, f)| **f) {
        triangle.iter().for_each(|v| touched[*v as usize] = true);
    }
    let rest = RestPose::of(mesh, animation).positions;
    let (mut own, mut posed) = (vec![Vec3::ZERO; touched.len()], vec![Vec3::ZERO; touched.len()]);
    for triangle in &mesh.triangles {
        let cross = |p: &[Vec3]| {
            let [a, b, c] = triangle.map(|v| p[v as usize]);
            (b - a).cross(c - a)
        };
        for v in triangle.iter().map(|v| *v as usize).filter(|v| touched[*v]) {
            own[v] += cross(&mesh.positions);
            posed[v] += cross(&rest);
        }
    }
    for v in (0..touched.len()).filter(|v| touched[*v]) {
        if let Some(normal) = own[v].try_normalize() {
            mesh.normals[v] = normal;
        }
    }
    // Windings are correct in the posed state. A joint that mirrors reverses the winding in the mesh's own space.
    let turned = RestPose::of(mesh, animation).normals;
    for v in (0..touched.len()).filter(|v| touched[*v] && turned[*v].dot(posed[*v]) < 0.0) {
        mesh.normals[v] = -mesh.normals[v];
    }
}

/// Makes tile coordinates from lapped patches. `field` has one vector per face and determines the frames. Without it,
/// frames follow the coordinates of each patch.
pub(super) fn patches(
    mesh: &mut Mesh,
    input_vertex: &mut Vec<u32>,
    skin: &FurredMesh,
    lapped: &Lapped,
    field: Option<&[DVec3]>,
) -> SplitVertices {
    // First patch that uses each vertex; bare triangles count as one more patch.
    let bare = lapped.patches as u32;
    let mut face_of = vec![NONE; mesh.triangles.len()];
    skin.triangles.iter().enumerate().for_each(|(f, t)| face_of[*t as usize] = f as u32);
    let mut owner = vec![NONE; mesh.positions.len()];
    let mut copies = HashMap::new();
    let mut tile_uvs = vec![Vec2::ZERO; mesh.positions.len()];
    for t in 0..mesh.triangles.len() {
        let f = face_of[t];
        let patch = if f == NONE { bare } else { lapped.patch_of[f as usize] };
        for k in 0..3 {
            let v = mesh.triangles[t][k] as usize;
            if owner[v] == NONE {
                owner[v] = patch;
            } else if owner[v] != patch {
                mesh.triangles[t][k] = *copies.entry((v, patch)).or_insert_with(|| {
                    input_vertex.push(input_vertex[v]);
                    tile_uvs.push(Vec2::ZERO);
                    mesh.copy_vertex(v)
                });
            }
            if f != NONE {
                tile_uvs[mesh.triangles[t][k] as usize] = lapped.corners[f as usize][k].as_vec2();
            }
        }
    }
    let tangents = match field {
        Some(field) => field_tangents(mesh, skin, field, &tile_uvs),
        None => frames::tangents(mesh, &tile_uvs),
    };
    SplitVertices { tile_uvs, tangents }
}

/// Returns tangents along S = T × N, where T is the mean of the comb field around each point. This makes lighting
/// smooth across patch borders. Where the mean has no direction, the coordinates of the patch are used.
fn field_tangents(mesh: &Mesh, skin: &FurredMesh, field: &[DVec3], tile_uvs: &[Vec2]) -> Vec<Vec4> {
    let topology = &skin.topology;
    let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, 0.0); topology.points.len()];
    for (f, t) in field.iter().enumerate() {
        for p in topology.faces[f] {
            let (comb, normal, area) = &mut sums[p as usize];
            *comb += *t * topology.areas[f];
            *normal += topology.normals[f] * topology.areas[f];
            *area += topology.areas[f];
        }
    }
    let mut along_u = vec![Vec3::ZERO; mesh.positions.len()];
    for (f, triangle) in skin.triangles.iter().map(|t| mesh.triangles[*t as usize]).enumerate() {
        let p = topology.corners(f);
        let (e1, e2, n) = (p[1] - p[0], p[2] - p[0], topology.normals[f]);
        let [q0, q1, q2] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
        for (v, point) in triangle.into_iter().zip(topology.faces[f]) {
            let (comb, normal, area) = sums[point as usize];
            if comb.length() < 0.5 * area {
                continue;
            }
            // The vector is converted from rest to the mesh's own space, as the same linear combination of the edges
            // there.
            let s = comb.cross(normal).reject_from_normalized(n).normalize_or_zero();
            let (a, b) = (s.cross(e2).dot(n) / e1.cross(e2).dot(n), e1.cross(s).dot(n) / e1.cross(e2).dot(n));
            along_u[v as usize] += (((q1 - q0) * a + (q2 - q0) * b).normalize_or_zero() * topology.areas[f]).as_vec3();
        }
    }
    let own = frames::tangents(mesh, tile_uvs);
    let tangent = |(v, own): (usize, Vec4)| {
        let along = along_u[v].reject_from_normalized(mesh.normals[v]).try_normalize();
        along.map_or(own, |t| t.extend(1.0))
    };
    own.into_iter().enumerate().map(tangent).collect()
}

/// Makes tile coordinates from the model's own texture coordinates.
pub(super) fn model_uvs(
    mesh: &mut Mesh,
    input_vertex: &mut Vec<u32>,
    rest: &RestPose,
    furred: &[bool],
    tile_m: f32,
    warnings: &mut Vec<String>,
) -> SplitVertices {
    let scale = frames::tile_scale(mesh, rest, furred, tile_m, warnings);
    let mut tile_uvs: Vec<Vec2> = mesh.uvs.iter().map(|uv| *uv * scale).collect();
    for original in frames::split_by_handedness(mesh, rest, &mut tile_uvs, warnings) {
        input_vertex.push(input_vertex[original as usize]);
    }
    let tangents = frames::tangents(mesh, &tile_uvs);
    SplitVertices { tile_uvs, tangents }
}
