//! Normals where the file has none, or none that can be used.
//!
//! glTF 2.0 asks for flat normals on a primitive without any. Shells of fur grow along the normals, so a crease would tear the
//! coat open along every edge: the importer computes smooth ones instead, from the area-weighted normals of all triangles that
//! meet in a position (also across primitives of a mesh), and never any creases.

use super::primitive::Primitive;
use super::source::Source;
use glam::{DVec3, Vec3};
use std::collections::HashMap;

/// Normals of the file may be this far from unit length (quantised to 8 bits) without a warning.
const ROUNDING: f64 = 0.02;

/// Gives every vertex of a mesh a unit normal.
pub(super) fn complete(source: &mut Source<'_, '_>, primitives: &mut [Primitive<'_>]) {
    let mut wanted = Vec::new();
    for (i, primitive) in primitives.iter_mut().enumerate() {
        let (mut off, mut bad) = (0, 0);
        for normal in &mut primitive.normals {
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
        let label = &primitive.label;
        if off > 0 {
            source.warn(format!("{label}: {off} normals are not of unit length; normalised"));
        }
        if bad > 0 {
            source.warn(format!("{label}: {bad} normals are zero or not finite; computed from the triangles"));
        }
        if bad > 0 || !primitive.has_normals {
            primitive.normals.resize(primitive.positions.len(), Vec3::ZERO);
            wanted.push(i);
        }
    }
    if wanted.is_empty() {
        return;
    }
    // Only looked up, never walked: the order of a hash map cannot reach the result.
    let mut welded: HashMap<[u32; 3], DVec3> = HashMap::new();
    for i in &wanted {
        let primitive = &primitives[*i];
        for triangle in &primitive.triangles {
            let normal = area_normal(&primitive.positions, triangle);
            for corner in triangle {
                *welded.entry(key(primitive.positions[*corner as usize])).or_default() += normal;
            }
        }
    }
    for i in &wanted {
        let primitive = &mut primitives[*i];
        // Where the sum vanishes (both sides of a sheet meet in one position), a triangle of the vertex itself decides.
        let mut own = vec![DVec3::ZERO; primitive.positions.len()];
        for triangle in &primitive.triangles {
            let normal = area_normal(&primitive.positions, triangle);
            for corner in triangle {
                let slot = &mut own[*corner as usize];
                if normal.length_squared() > slot.length_squared() {
                    *slot = normal;
                }
            }
        }
        for (v, normal) in primitive.normals.iter_mut().enumerate().filter(|(_, n)| **n == Vec3::ZERO) {
            let sum = welded.get(&key(primitive.positions[v])).copied().unwrap_or_default();
            let sum = if sum.length() > 1e-6 * own[v].length() { sum } else { own[v] };
            // A vertex of degenerate triangles only has no direction of its own; it covers no area either.
            *normal = sum.try_normalize().unwrap_or(DVec3::Y).as_vec3();
        }
    }
}

/// Twice the area of a triangle, along its normal. Double precision: animals stored a hundred times too small have triangles
/// whose squared lengths come close to the end of single.
fn area_normal(positions: &[Vec3], triangle: &[u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|i| positions[i as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Bits of a position, the same for 0 and −0.
fn key(position: Vec3) -> [u32; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}
