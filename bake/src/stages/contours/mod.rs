//! `contours`: connectivity of the final mesh, from which the ink style extracts contour lines in every frame.
//!
//! * `weld`: vertices at the same position with similar normals become one
//! * `edges`: edges and faces between them, and their budget in a frame
//! * `creases`: sharp edges and open boundaries, as lines of points
//! * `marks`: amount of lines, emphasis and darkness at each vertex

mod creases;
mod edges;
mod marks;
mod target;
mod weld;

use crate::stages::groom::are_joints_of_head;
use creases::crease_points;
use edges::{FaceEdges, most_nodes};
use marks::marks;
use pelage_formats::ContourMesh;
pub use target::ContourTarget;
use weld::Weld;

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
