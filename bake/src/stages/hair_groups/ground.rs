//! Input of the stage: the model that hair grows on.

use crate::recipe::SrgbColor;
use crate::stages::groom::MapImages;
use pelage_import::BakeError;
use pelage_import::mesh::{Material, Mesh, MeshPart, NamedPosition, RestPose};
use pelage_params::glob;

/// Model that hair grows on.
#[derive(Clone, Copy, Debug)]
pub struct GroomTarget<'a> {
    /// File name of the model as the user gave it, for messages.
    pub file: &'a str,
    /// Mesh as stored in the package.
    pub mesh: &'a Mesh,
    /// Rest pose of `mesh`.
    pub rest: &'a RestPose,
    /// Bounding radius in the rest pose, metres.
    pub radius_m: f32,
    /// Materials of the model.
    pub materials: &'a [Material],
    /// Named nodes of the model.
    pub nodes: &'a [NamedPosition],
    /// Images and strand files that the recipe names.
    pub files: &'a MapImages,
}

/// Reason why a group cannot be made: a message about the group, or any other error.
pub(super) enum GroupError {
    Here(String),
    Elsewhere(BakeError),
}

impl From<BakeError> for GroupError {
    fn from(error: BakeError) -> Self {
        Self::Elsewhere(error)
    }
}

/// Returns the parts whose material names match `pattern`, or an error message if there are none.
pub(super) fn parts_of<'a>(pattern: &str, ground: &GroomTarget<'a>) -> Result<Vec<&'a MeshPart>, String> {
    let named =
        |part: &&MeshPart| ground.materials.get(part.material).is_some_and(|material| glob(pattern, &material.name));
    let parts: Vec<_> = ground.mesh.parts.iter().filter(named).collect();
    if parts.is_empty() {
        let known: Vec<String> = ground.materials.iter().map(|material| format!("{:?}", material.name)).collect();
        return Err(format!("no triangle has a material named {pattern:?}, expected one of {}", known.join(", ")));
    }
    Ok(parts)
}

/// Converts a recipe's colour to the form that a package stores.
pub(super) fn bytes(color: SrgbColor) -> [u8; 3] {
    color.0.map(|x| (x * 255.0).round() as u8)
}
