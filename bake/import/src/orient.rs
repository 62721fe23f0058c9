//! Which way triangles face once posed: outward, as their normals say.

use super::notes::Notes;
use super::scene::mirrors;

use crate::mesh::{Mesh, RestPose};
use glam::DVec3;
use pelage_formats::meaning::skin_matrix;
use pelage_formats::{Animation, Pose};

/// Turns parts inside out that the skeleton's rest pose mirrors, then those whose triangles still face against their normals.
///
/// glTF 2.0 (section 3.5.2) turns the winding with the sign of the node's determinant; for joints it says nothing, and the
/// determinant of the blended matrix is the same thing for a skin. `authored` says for each part whether its normals come from
/// the file: computed ones follow the winding and cannot contradict it.
pub(super) fn face_outward(
    notes: &mut Notes,
    mesh: &mut Mesh,
    animation: Option<&Animation>,
    rest: &RestPose,
    authored: &[bool],
) {
    let mut pose = Pose::default();
    if let Some(animation) = animation {
        pose.sample(animation, None, 0.0);
    }
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
            notes.warn(format!("{}: the triangles face against their normals; turned around", part.source));
        }
    }
}

/// Parts facing against their normals by more than this share of their area are turned; sheets with two sides stay about 0.
const AGAINST: f64 = -0.25;

fn flip(triangles: &mut [[u32; 3]]) {
    for [_, b, c] in triangles {
        std::mem::swap(b, c);
    }
}

/// Area-weighted mean of the cosine between triangles and the normals of their corners: 1 agree, -1 against.
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
