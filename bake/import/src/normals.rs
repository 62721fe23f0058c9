//! Normals where the file has none, or none that can be used.
//!
//! glTF 2.0 asks for flat normals on a primitive without any. Shells of fur grow along the normals, so a crease would tear the
//! coat open along every edge: the importer computes smooth ones instead, from all triangles that meet in a position (also
//! across primitives of a mesh), each weighted by its angle there (Thürmer and Wüthrich, "Computing Vertex Normals from Polygonal
//! Facets", Journal of Graphics Tools 3(1), 1998), so that it does not matter how a polygon was cut into triangles; and never any
//! creases.

use super::notes::Notes;
use crate::angle::between;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Normals of the file may be this far from unit length (quantised to 8 bits) without a warning.
const ROUNDING: f64 = 0.02;

/// A part of a mesh whose normals are to be completed.
pub(super) struct Shape<'m> {
    /// For messages.
    pub label: &'m str,
    pub positions: &'m [Vec3],
    pub triangles: &'m [[u32; 3]],
    /// As the file has them, or empty; afterwards one of unit length per position. Zero stands for one that is missing.
    pub normals: &'m mut Vec<Vec3>,
}

/// Gives every vertex of a mesh a unit normal.
pub(super) fn complete(notes: &mut Notes, shapes: &mut [Shape<'_>]) {
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
            notes.warn(format!("{label}: {off} normals are not of unit length; normalised"));
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
    // Only looked up, never walked: the order of a hash map cannot reach the result.
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
        // Where the sum vanishes (both sides of a sheet meet in one position), the widest corner at the vertex itself decides.
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
            // A vertex of degenerate triangles only has no direction of its own; it covers no area either.
            *normal = sum.try_normalize().unwrap_or(DVec3::Y).as_vec3();
        }
    }
}

/// The normal of a triangle at each of its corners, as long as the angle there; zero where the triangle has no area. Double precision:
/// animals stored a hundred times too small have triangles whose squared lengths come close to the end of single.
fn corner_normals(positions: &[Vec3], triangle: &[u32; 3]) -> [DVec3; 3] {
    let p = triangle.map(|i| positions[i as usize].as_dvec3());
    let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { return [DVec3::ZERO; 3] };
    [0, 1, 2].map(|k| {
        let angle = between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        if angle.is_finite() { normal * angle } else { DVec3::ZERO }
    })
}

/// Bits of a position, the same for 0 and −0.
fn key(position: Vec3) -> [u32; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}
