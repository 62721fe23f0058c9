//! Joining of vertices that exporters split: vertices with equal attributes, and normals across seams.

use glam::Vec3;
use pelage_import::mesh::Mesh;
use std::collections::HashMap;

fn bits<const N: usize>(values: [f32; N]) -> [u32; N] {
    // Adding zero turns -0 into +0. A -0 would otherwise split a seam into every mirrored model.
    values.map(|v| (v + 0.0).to_bits())
}

/// Joins vertices of one material that are equal bit for bit in position, normal, texture coordinates, colour, skin and
/// morph targets.
///
/// Files without indices store each corner of each triangle separately, and only joined corners can share a tile frame.
/// The first of several equal vertices is kept, so the order does not depend on the hash map. Vertices without a
/// triangle are removed.
///
/// Returns the mesh, and for each of its vertices the first input vertex that it replaces.
pub(super) fn join_equal_vertices(mesh: &Mesh) -> (Mesh, Vec<u32>) {
    let mut out = Mesh { parts: mesh.parts.clone(), ..Mesh::default() };
    let (mut seen, mut origin) = (HashMap::new(), Vec::new());
    for part in &mesh.parts {
        for triangle in &mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count] {
            let joined = triangle.map(|corner| {
                let i = corner as usize;
                let skin = mesh.skin.get(i);
                let key = (
                    part.material,
                    bits(mesh.positions[i].to_array()),
                    bits(mesh.normals[i].to_array()),
                    bits(mesh.uvs[i].to_array()),
                    mesh.colors[i],
                    skin.map(|s| (s.joints, bits(s.weights))),
                    mesh.morph_rows.get(i),
                );
                *seen.entry(key).or_insert_with(|| {
                    out.positions.push(mesh.positions[i]);
                    out.normals.push(mesh.normals[i]);
                    out.uvs.push(mesh.uvs[i]);
                    out.colors.push(mesh.colors[i]);
                    out.skin.extend(skin);
                    out.morph_rows.extend(mesh.morph_rows.get(i));
                    origin.push(corner);
                    out.positions.len() as u32 - 1
                })
            });
            out.triangles.push(joined);
        }
    }
    (out, origin)
}

/// Returns the number of vertices that triangles use.
pub(super) fn used_vertices(mesh: &Mesh) -> usize {
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
    used.into_iter().filter(|u| *u).count()
}

/// Cosine of the angle between two normals below which an edge is hard: 2°. Surface with less is lit by the joined
/// normals.
const SAME_COSINE: f32 = 0.999_39;

/// Gives all furred vertices at one position the same normal, so that the shells above a seam or a hard edge stay
/// closed.
///
/// The mean is weighted by the angle of each triangle at the vertex, so it does not depend on the triangulation. Hair
/// has no creases, so flat-shaded input is smoothed as well. Bare parts keep their normals. If an edge is hard,
/// [`Mesh::bare_normals`] keeps the normals of the input.
///
/// `faces`: triangles of points at rest, with one index per position. Only vertices that also agree in the mesh's own
/// space are averaged, because two touching rigid parts have different spaces.
pub(super) fn smooth_normals_over_seams(mesh: &mut Mesh, faces: &[[u32; 3]], furred: &[bool]) {
    let mut sums: HashMap<(u32, [u32; 3]), Vec3> = HashMap::new();
    let mut corners = Vec::new();
    for ((triangle, face), _) in mesh.triangles.iter().zip(faces).zip(furred).filter(|(_, f)| **f) {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|j| triangle[(k + j) % 3] as usize);
            let (p, q, r) = (mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            let angle = if p == q || p == r { 0.0 } else { (q - p).angle_between(r - p) };
            let key = (face[k], bits(p.to_array()));
            *sums.entry(key).or_default() += mesh.normals[a] * if angle.is_finite() { angle } else { 0.0 };
            corners.push((a, key));
        }
    }
    let own = mesh.normals.clone();
    for (vertex, key) in corners {
        if let Some(normal) = sums.get(&key).and_then(|sum| sum.try_normalize()) {
            mesh.normals[vertex] = normal;
        }
    }
    if mesh.normals.iter().zip(&own).any(|(joined, own)| joined.dot(*own) < SAME_COSINE) {
        mesh.bare_normals = own;
    }
}
