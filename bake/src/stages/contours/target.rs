//! Input of the stage.

use crate::stages::groom::Colors;
use pelage_formats::{Animation, InkVertex, StrokePool};
use pelage_import::mesh::{Mesh, RestPose};

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
    /// Ink of each vertex by the recipe, whose line is a factor; empty for lines everywhere.
    pub ink: &'a [InkVertex],
    /// Strokes with which the model is painted.
    pub painting: Option<&'a StrokePool>,
}
