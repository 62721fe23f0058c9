//! What is looked over.

use pelage_formats::{Animation, Bounds};
use pelage_import::mesh::{Mesh, RestPose};

/// A body, as `import` hands it on.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its rest pose, metres.
    pub rest: &'a RestPose,
    /// Its skeleton.
    pub animation: Option<&'a Animation>,
    /// One per material: whether hair grows on it.
    pub furred: &'a [bool],
    /// Sphere about it.
    pub bounds: &'a Bounds,
}
