//! Tile scale and tile frames: directions of the hair tile's +u and +v on the mesh surface.

use glam::{Vec2, Vec3, Vec4};
use pelage_import::mesh::{Mesh, RestPose};

/// Returns twice the signed area of a triangle in texture coordinates.
pub(super) fn uv_det(uvs: &[Vec2], triangle: &[u32; 3]) -> f32 {
    let [a, b, c] = triangle.map(|i| uvs[i as usize]);
    (b - a).perp_dot(c - a)
}

/// Returns twice the area of a triangle on the mesh surface, square metres.
pub(super) fn area2(positions: &[Vec3], triangle: &[u32; 3]) -> f32 {
    let [a, b, c] = triangle.map(|i| positions[i as usize]);
    (b - a).cross(c - a).length()
}

/// Returns the factors from texture coordinates to tile coordinates. They are the same for the whole model, so that
/// charts with equal texel density have equal hair density.
///
/// The factor of u is negative if most of the furred surface is unwrapped mirrored as seen from outside. This is normal
/// in glTF, whose v points down. With this sign, +v of the tile follows the hair of an animal painted upright, and
/// frames are right-handed.
pub(super) fn tile_scale(
    mesh: &Mesh,
    rest: &RestPose,
    furred: &[bool],
    tile_size_m: f32,
    warnings: &mut Vec<String>,
) -> Vec2 {
    let (mut skin, mut texture, mut turned) = (0f64, 0f64, 0f64);
    let mut collapsed = 0usize;
    for (triangle, _) in mesh.triangles.iter().zip(furred).filter(|(_, f)| **f) {
        let (area, det) = (f64::from(area2(&rest.positions, triangle)), f64::from(uv_det(&mesh.uvs, triangle)));
        collapsed += usize::from(det == 0.0 && area > 0.0);
        skin += area;
        texture += det.abs();
        turned += area * if det < 0.0 { 1.0 } else { -1.0 };
    }
    if collapsed > 0 {
        warnings
            .push(format!("{collapsed} furred triangles have no area in texture coordinates; their hair is stretched"));
    }
    // All charts are collapsed to points or lines, so no scale is better than another, and hair will appear as streaks.
    // A scale of one tile per texture keeps the coordinates finite.
    let metres_per_uv = if texture > 0.0 { (skin / texture).sqrt() as f32 } else { tile_size_m };
    let scale = metres_per_uv / tile_size_m;
    Vec2::new(if turned > 0.0 { -scale } else { scale }, scale)
}

/// Returns the unit tangent along +u of each vertex, in the mesh's own space, and the handedness in the posed rest
/// state. Vertices whose triangles are all degenerate get an arbitrary tangent.
pub(super) fn tangents(mesh: &Mesh, tile_uvs: &[Vec2]) -> Vec<Vec4> {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    let mut hands = vec![0f32; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let det = uv_det(tile_uvs, triangle);
        if det == 0.0 {
            continue;
        }
        let [a, b, c] = triangle.map(|i| i as usize);
        let (e1, e2) = (mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
        let (d1, d2) = (tile_uvs[b] - tile_uvs[a], tile_uvs[c] - tile_uvs[a]);
        // Derivative dP/du from the two edges, weighted by area so that slivers do not turn the frame.
        let along_u = ((e1 * d2.y - e2 * d1.y) / det).normalize_or_zero() * e1.cross(e2).length();
        for i in [a, b, c] {
            sums[i] += along_u;
            hands[i] = det.signum();
        }
    }
    let frames = mesh.normals.iter().zip(sums).zip(hands);
    frames
        .map(|((normal, sum), hand)| {
            let tangent = sum.reject_from_normalized(*normal).try_normalize();
            let tangent = tangent.unwrap_or_else(|| normal.any_orthonormal_vector());
            tangent.extend(if hand < 0.0 { -1.0 } else { 1.0 })
        })
        .collect()
}

/// Gives mirrored triangles separate vertices: appends copies to `mesh` and `tile_uvs`, and returns the index of each
/// copy's original.
pub(super) fn split_by_handedness(
    mesh: &mut Mesh,
    rest: &RestPose,
    tile_uvs: &mut Vec<Vec2>,
    warnings: &mut Vec<String>,
) -> Vec<u32> {
    let mirrored: Vec<bool> = mesh.triangles.iter().map(|t| uv_det(tile_uvs, t) < 0.0).collect();
    let mut upright = vec![false; mesh.positions.len()];
    for (triangle, _) in mesh.triangles.iter().zip(&mirrored).filter(|(_, m)| !**m) {
        triangle.iter().for_each(|i| upright[*i as usize] = true);
    }
    let mut copies = vec![u32::MAX; mesh.positions.len()];
    let before = mesh.positions.len();
    let mut originals = Vec::new();
    for t in (0..mirrored.len()).filter(|t| mirrored[*t]) {
        for k in 0..3 {
            let i = mesh.triangles[t][k] as usize;
            if !upright[i] {
                continue;
            }
            if copies[i] == u32::MAX {
                copies[i] = mesh.copy_vertex(i);
                tile_uvs.push(tile_uvs[i]);
                originals.push(i as u32);
            }
            mesh.triangles[t][k] = copies[i];
        }
    }
    let area = |wanted: bool| -> f64 {
        let chosen = mesh.triangles.iter().zip(&mirrored).filter(|(_, m)| **m == wanted);
        // Copies have the positions of their originals, so the rest pose of the originals can be used.
        let original = |i: u32| (i as usize).checked_sub(before).map_or(i, |copy| originals[copy]);
        chosen.map(|(t, _)| f64::from(area2(&rest.positions, &t.map(original)))).sum()
    };
    let (mirrored_area, upright_area) = (area(true), area(false));
    if mirrored_area > 0.0 {
        let share = 100.0 * mirrored_area / (mirrored_area + upright_area).max(f64::MIN_POSITIVE);
        warnings.push(format!(
            "{share:.0} % of the skin has mirrored texture coordinates: its hair leans in the mirrored direction; {} \
             vertices were split",
            originals.len()
        ));
    }
    originals
}
