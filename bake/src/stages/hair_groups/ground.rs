//! What hair grows on.

use crate::recipe::SrgbColor;
use crate::stages::groom::MapImages;
use pelage_import::mesh::{Material, Mesh, MeshPart, NamedPlace, RestPose};
use pelage_params::glob;

/// What hair grows on.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The model as the user named it, for messages.
    pub file: &'a str,
    /// The mesh as the package has it.
    pub mesh: &'a Mesh,
    /// Its rest pose.
    pub rest: &'a RestPose,
    /// Radius of that, metres.
    pub radius_m: f32,
    /// Materials of the model.
    pub materials: &'a [Material],
    /// Named nodes of the model.
    pub nodes: &'a [NamedPlace],
    /// Images and files of strands that the recipe names.
    pub files: &'a MapImages,
}

/// The parts whose materials have that name; says where there is none.
pub(super) fn parts_of<'a>(pattern: &str, ground: &Ground<'a>) -> Result<Vec<&'a MeshPart>, String> {
    let named =
        |part: &&MeshPart| ground.materials.get(part.material).is_some_and(|material| glob(pattern, &material.name));
    let parts: Vec<_> = ground.mesh.parts.iter().filter(named).collect();
    if parts.is_empty() {
        let known: Vec<String> = ground.materials.iter().map(|material| format!("{:?}", material.name)).collect();
        return Err(format!("no triangle has a material named {pattern:?}, expected one of {}", known.join(", ")));
    }
    Ok(parts)
}

/// A colour of a recipe as a package stores it.
pub(super) fn bytes(color: SrgbColor) -> [u8; 3] {
    color.0.map(|x| (x * 255.0).round() as u8)
}
