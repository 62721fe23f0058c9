//! Orientation of the triangles in the rest pose: outward, as their normals point.

use super::notes::Notes;
use super::scene::mirrors;

use crate::mesh::{Mesh, RestPose};
use glam::DVec3;
use pelage_formats::Animation;
use pelage_formats::meaning::skin_matrix;

/// Flips parts that the skeleton's rest pose mirrors, then parts whose triangles still face against their normals.
///
/// In glTF 2.0 (section 3.5.2) the sign of the node's determinant flips the winding. The specification is silent about
/// joints; for a skin, the determinant of the blended matrix has the same role. `authored` says for each part whether
/// its normals come from the file. Computed normals follow the winding and cannot contradict it.
pub(super) fn face_outward(
    notes: &mut Notes,
    mesh: &mut Mesh,
    animation: Option<&Animation>,
    rest: &RestPose,
    authored: &[bool],
) {
    let pose = animation.map(RestPose::pose).unwrap_or_default();
    for (part, authored) in mesh.parts.iter().zip(authored) {
        let triangles = &mut mesh.triangles[part.first_triangle..part.first_triangle + part.triangle_count];
        if animation.is_some() {
            let corners = triangles.iter().flatten().filter_map(|v| mesh.skin.get(*v as usize));
            let (mut turned, mut total) = (0_usize, 0_usize);
            for vertex in corners {
                turned += usize::from(mirrors(&skin_matrix(&pose, vertex)));
                total += 1;
            }
            if 2 * turned > total {
                flip(triangles);
            }
        }
        if *authored && facing(triangles, rest) < AGAINST {
            flip(triangles);
            notes.warn(format!("{}: the triangles face against their normals; flipped", part.source));
        }
    }
}

/// Mean cosine between the normals of triangles and of their corners below which a part is flipped. For two-sided
/// sheets, the mean is near 0.
const AGAINST: f64 = -0.25;

fn flip(triangles: &mut [[u32; 3]]) {
    for [_, b, c] in triangles {
        std::mem::swap(b, c);
    }
}

/// Returns the area-weighted mean cosine between the normals of triangles and those of their corners: 1 if they agree,
/// -1 if opposite.
fn facing(triangles: &[[u32; 3]], rest: &RestPose) -> f64 {
    let (mut sum, mut area) = (0.0, 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| rest.positions[v as usize].as_dvec3());
        let face = (b - a).cross(c - a);
        let mean: DVec3 = triangle.iter().map(|v| rest.normals[*v as usize].as_dvec3()).sum();
        sum += face.dot(mean.try_normalize().unwrap_or_default());
        area += face.length();
    }
    if area > 0.0 { sum / area } else { 0.0 }
}
