//! Computation of normals that are missing or unusable in the file.
//!
//! The importer first computes smooth normals without any creases, as hair grows. The normal at a position is the sum
//! of the normals of all triangles that share the position, even in different primitives of a mesh. Each triangle is
//! weighted by its angle at the position, so the result does not depend on the triangulation of polygons. Source:
//! Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal Facets", Journal of Graphics Tools 3(1), 1998.
//!
//! glTF 2.0 requires flat normals on a primitive without any: [`flatten`] makes them where the difference shows.

use super::notes::Notes;
use crate::angle::between;
use crate::mesh::Mesh;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Maximum deviation of a normal's length from 1 without a warning: the rounding of 8-bit normals.
const ROUNDING: f64 = 0.02;

/// Part of a mesh whose normals are to be completed.
pub(super) struct NormalInput<'m> {
    /// Name in messages.
    pub label: &'m str,
    pub positions: &'m [Vec3],
    pub triangles: &'m [[u32; 3]],
    /// Input: normals of the file, possibly empty; zero marks a missing one. Output: one unit normal per position.
    pub normals: &'m mut Vec<Vec3>,
}

/// Gives every vertex of a mesh a unit normal.
pub(super) fn complete_normals(notes: &mut Notes, shapes: &mut [NormalInput<'_>]) {
    let mut wanted = Vec::new();
    for (i, shape) in shapes.iter_mut().enumerate() {
        let (mut off, mut bad) = (0, 0);
        for normal in shape.normals.iter_mut() {
            let n = normal.as_dvec3();
            let length = n.length();
            if length.is_finite() && length > 1e-6 {
                off += usize::from((length - 1.0).abs() > ROUNDING);
                *normal = (n / length).as_vec3();
            } else {
                *normal = Vec3::ZERO;
                bad += 1;
            }
        }
        let label = shape.label;
        if off > 0 {
            notes.warn(format!("{label}: {off} normals do not have unit length; normalised"));
        }
        if bad > 0 {
            notes.warn(format!("{label}: {bad} normals are missing, zero or not finite; computed from the triangles"));
        }
        if bad > 0 || shape.normals.len() < shape.positions.len() {
            shape.normals.resize(shape.positions.len(), Vec3::ZERO);
            wanted.push(i);
        }
    }
    if wanted.is_empty() {
        return;
    }
    // The map is only looked up, never iterated: its order cannot affect the result.
    let mut welded: HashMap<[u32; 3], DVec3> = HashMap::new();
    for i in &wanted {
        let shape = &shapes[*i];
        for triangle in shape.triangles {
            for (corner, normal) in triangle.iter().zip(corner_normals(shape.positions, triangle)) {
                *welded.entry(key(shape.positions[*corner as usize])).or_default() += normal;
            }
        }
    }
    for i in &wanted {
        let shape = &mut shapes[*i];
        // The sum vanishes if both sides of a sheet share a position. Then the normal of one triangle is used: the one
        // with the widest corner at the vertex itself.
        let mut own = vec![DVec3::ZERO; shape.positions.len()];
        for triangle in shape.triangles {
            for (corner, normal) in triangle.iter().zip(corner_normals(shape.positions, triangle)) {
                let slot = &mut own[*corner as usize];
                if normal.length_squared() > slot.length_squared() {
                    *slot = normal;
                }
            }
        }
        for (v, normal) in shape.normals.iter_mut().enumerate().filter(|(_, n)| **n == Vec3::ZERO) {
            let sum = welded.get(&key(shape.positions[v])).copied().unwrap_or_default();
            let sum = if sum.length() > 1e-6 * own[v].length() { sum } else { own[v] };
            // A vertex whose triangles are all degenerate has no direction of its own, and covers no area.
            *normal = sum.try_normalize().unwrap_or(DVec3::Y).as_vec3();
        }
    }
}

/// Mean angle between triangles and the smooth normals at their corners above which a part without normals has flat
/// ones, radians: 4°. Below it, nobody sees the difference.
const FLAT_FROM: f64 = 0.07;
/// Maximum number of triangles with flat normals in a part. More would triple the size of a large model.
const MOST_FLAT: usize = 1 << 16;

/// Gives flat normals to the parts whose normals were computed, as glTF 2.0 (section 3.7.2.1) requires. `authored` says
/// for each part whether its normals come from the file. Vertices where flat triangles meet are split.
///
/// Parts that look smooth keep smooth normals, and so do parts of more than 65 536 triangles.
pub(super) fn flatten(mesh: &mut Mesh, authored: &[bool]) {
    let smooth = mesh.normals.clone();
    let mut faces = vec![None; smooth.len()];
    for number in (0..mesh.parts.len()).filter(|number| !authored[*number]) {
        let part = &mesh.parts[number];
        let range = part.first_triangle..part.first_triangle + part.triangle_count;
        let (mut sum, mut total) = (0.0, 0.0);
        for triangle in &mesh.triangles[range.clone()] {
            for (v, normal) in triangle.iter().zip(corner_normals(&mesh.positions, triangle)) {
                let weight = normal.length();
                sum += if weight > 0.0 { weight * crease(normal, mesh.normals[*v as usize]) } else { 0.0 };
                total += weight;
            }
        }
        if part.triangle_count > MOST_FLAT || sum <= FLAT_FROM * total {
            continue;
        }
        for t in range {
            let triangle = mesh.triangles[t];
            let Some(face) = corner_normals(&mesh.positions, &triangle).iter().find_map(|n| n.try_normalize()) else {
                continue;
            };
            for (k, v) in triangle.into_iter().enumerate() {
                // Parts mirrored by their joints are wound against their normals in their own space.
                let normal = (if face.dot(smooth[v as usize].as_dvec3()) < 0.0 { -face } else { face }).as_vec3();
                match faces[v as usize] {
                    Some(other) if other != normal => {
                        let copy = mesh.copy_vertex(v as usize);
                        mesh.normals[copy as usize] = normal;
                        mesh.triangles[t][k] = copy;
                    }
                    _ => {
                        mesh.normals[v as usize] = normal;
                        faces[v as usize] = Some(normal);
                    }
                }
            }
        }
    }
}

/// Returns the angle between a triangle's normal of any length and a vertex normal, on the nearer side.
fn crease(face: DVec3, normal: Vec3) -> f64 {
    let angle = between(face, normal.as_dvec3());
    angle.min(std::f64::consts::PI - angle)
}

/// Returns the normal of a triangle at each of its corners, scaled by the angle there. Zero if the triangle has no
/// area.
///
/// Computes in f64: if an animal is stored at a hundredth of its size, squared lengths approach the limit of f32.
fn corner_normals(positions: &[Vec3], triangle: &[u32; 3]) -> [DVec3; 3] {
    let p = triangle.map(|i| positions[i as usize].as_dvec3());
    let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { return [DVec3::ZERO; 3] };
    [0, 1, 2].map(|k| {
        let angle = between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        if angle.is_finite() { normal * angle } else { DVec3::ZERO }
    })
}

/// Returns the bits of a position; 0 and −0 give the same bits.
fn key(position: Vec3) -> [u32; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}
