//! Body from which a groom is derived.

use pelage_formats::{Animation, Bounds};
use pelage_import::mesh::{Mesh, RestPose};

/// Body from the `import` stage.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    /// Mesh of the body.
    pub mesh: &'a Mesh,
    /// Rest pose of the mesh, metres.
    pub rest: &'a RestPose,
    /// Skeleton.
    pub animation: Option<&'a Animation>,
    /// Whether hair grows on each material.
    pub furred: &'a [bool],
    /// Bounding sphere of the body.
    pub bounds: &'a Bounds,
}
