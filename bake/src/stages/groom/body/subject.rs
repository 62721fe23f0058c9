//! What is looked over.

use crate::mesh::{Mesh, RestPose};
use pelage_formats::{Animation, Bounds};

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
