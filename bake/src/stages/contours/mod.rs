//! `contours`: connectivity of the final mesh, from which the ink style extracts contour lines in every frame.
//!
//! * `weld`: vertices at the same position with similar normals become one
//! * `edges`: edges and faces between them, and their budget in a frame
//! * `creases`: sharp edges and open boundaries, as lines of points
//! * `marks`: amount of lines, emphasis and darkness at each vertex

mod creases;
mod edges;
mod marks;
mod weld;

use crate::stages::groom::{Colors, are_joints_of_head};
use creases::crease_points;
use edges::{FaceEdges, most_nodes};
use marks::marks;
use pelage_formats::{Animation, ContourMesh};
use pelage_import::mesh::{Mesh, RestPose};
use weld::Weld;

/// Model whose contour lines are drawn.
#[derive(Clone, Copy, Debug)]
pub struct ContourTarget<'a> {
    /// Mesh as stored in the package.
    pub mesh: &'a Mesh,
    /// Rest pose of `mesh`.
    pub rest: &'a RestPose,
    /// Radius of the bounding sphere, metres.
    pub radius: f32,
    /// Colours of materials and vertices.
    pub colors: &'a Colors,
    /// Whether hair grows on each material.
    pub furred: &'a [bool],
    /// Skeleton, whose joints tell where the head is.
    pub animation: Option<&'a Animation>,
}

/// Returns the contour mesh of a model. The result does not depend on the number of threads.
pub fn contour_mesh(target: &ContourTarget<'_>) -> ContourMesh {
    let ContourTarget { mesh, rest, radius, animation, .. } = *target;
    let weld = Weld::new(rest, radius);
    let FaceEdges { edges, faces, of_triangle } = FaceEdges::new(mesh, &weld);
    let most_nodes = most_nodes(&edges, rest);
    let creases = crease_points(target, &weld, &of_triangle);
    let heads = animation.map(are_joints_of_head).unwrap_or_default();
    let marks = marks(target, &weld, &edges, &heads);
    ContourMesh { edges, faces, creases, marks, most_nodes }
}

#[cfg(test)]
mod tests;
