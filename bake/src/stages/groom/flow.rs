//! Directions of image axes on the mesh surface.

use glam::Vec3;
use pelage_import::mesh::{Mesh, RestPose};

/// Returns for each vertex the unit directions on the surface, at rest, that point right and up on the model's images.
/// They are the gradients of the texture coordinates, averaged over the vertex's triangles; zero if undefined.
pub(super) fn image_axes(mesh: &Mesh, rest: &RestPose) -> Vec<[Vec3; 2]> {
    let mut axes = vec![[Vec3::ZERO; 2]; mesh.positions.len()];
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| v as usize);
        let (p1, p2) = (rest.positions[b] - rest.positions[a], rest.positions[c] - rest.positions[a]);
        let (t1, t2) = (mesh.uvs[b] - mesh.uvs[a], mesh.uvs[c] - mesh.uvs[a]);
        let area = t1.perp_dot(t2);
        if area == 0.0 {
            continue;
        }
        // The v axis of images points down.
        let (right, down) = ((p1 * t2.y - p2 * t1.y) / area, (p2 * t1.x - p1 * t2.x) / area);
        for v in [a, b, c] {
            axes[v][0] += right.normalize_or_zero();
            axes[v][1] -= down.normalize_or_zero();
        }
    }
    axes.iter_mut().flatten().for_each(|axis| *axis = axis.normalize_or_zero());
    axes
}
