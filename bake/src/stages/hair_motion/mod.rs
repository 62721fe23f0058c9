//! Motion of guided hair, and the parts of the body that it must not enter: the recipe's settings, and capsules
//! fitted to the mesh.

mod colliders;
mod recipe_colliders;

pub use colliders::{FittedColliders, fit};

use crate::recipe::{HairGroupParams, StrandParams};
use crate::stages::hair_groups::GuidedHair;
use glam::{Mat4, Vec3};
use pelage_formats::meaning::hair_groups::triangle_frame;
use pelage_formats::meaning::{posed, skin_matrix};
use pelage_formats::{Animation, GroupMotion, HairGroup, HairMotion, MeshData, Pose, TrianglePoint};
use pelage_import::mesh::RestPose;

/// Returns the motion of a recipe's groups, derived from its settings and the body; `None` if no group moves.
///
/// * `hair`: groups of the recipe in order, then its tufts, which are stiff
pub fn group_motion(
    params: &StrandParams,
    hair: &GuidedHair,
    mesh: &MeshData,
    animation: Option<&Animation>,
) -> Option<(HairMotion, FittedColliders)> {
    let motions: Vec<GroupMotion> =
        hair.groups.iter().enumerate().map(|(i, _)| params.group.get(i).map_or(GroupMotion::STIFF, motion)).collect();
    if motions.iter().all(|motion| motion.held >= 1.0) {
        return None;
    }
    let mut pose = animation.map(RestPose::pose).unwrap_or_default();
    if pose.joints.is_empty() {
        pose.joints.push(Mat4::IDENTITY);
    }
    let mut found = HairMotion { groups: motions, freedom: hair.freedom.clone(), colliders: Vec::new() };
    let guides: Vec<Vec<Vec3>> = (0..hair.groups.len())
        .flat_map(|number| rest_points(&hair.groups[number], number, &found, mesh, &pose))
        .collect();
    let fitted = if params.colliders { fit(mesh, &pose, &guides) } else { FittedColliders::default() };
    let fitted = recipe_colliders::merge(fitted, &params.collider, animation, &pose);
    found.colliders.clone_from(&fitted.colliders);
    Some((found, fitted))
}

fn motion(group: &HairGroupParams) -> GroupMotion {
    GroupMotion {
        held: group.held(),
        free: group.free().max(group.held()),
        drag_per_s: group.drag_per_s(),
        shape_hz: group.swing_hz(),
        bend_hz: group.bend_hz(),
        friction: group.friction(),
    }
}

/// Returns the rest positions of a group's movable guide points, in model space.
fn rest_points(group: &HairGroup, number: usize, motion: &HairMotion, mesh: &MeshData, pose: &Pose) -> Vec<Vec<Vec3>> {
    let of_group = motion.groups[number];
    if of_group.held >= 1.0 {
        return Vec::new();
    }
    let place = |vertex: u32| {
        let (stored, skin) = (&mesh.geometry[vertex as usize], mesh.skin.get(vertex as usize));
        skin.map_or(stored.position, |skin| posed(stored, skin_matrix(pose, skin)).position).into()
    };
    let guide = |(guide, root): (usize, TrianglePoint)| {
        let first = 3 * root.triangle as usize;
        let corners: [Vec3; 3] = [0, 1, 2].map(|k| place(mesh.indices[first + k]));
        let (at, frame) = (root.position(corners), triangle_frame(corners));
        let points = group.guide(guide);
        let last = (points.len() - 1) as f32;
        let free = points.iter().enumerate().filter(|(k, _)| of_group.freedom(*k as f32 / last) > 0.0);
        free.map(|(_, point)| at + frame * *point).collect()
    };
    group.roots().enumerate().filter(|(guide, _)| motion.guide_freedom(number, *guide) > 0.0).map(guide).collect()
}

#[cfg(test)]
mod tests;
