//! Gloss of bare surface: eyes have a wet cornea, noses a moist sheen, other bare materials the roughness and metalness
//! of the model's file.

use super::bare::is_named;
use super::names::{are_names_of_eyes, are_names_of_nose, words};
use super::pairs::{WeldedFaces, weld};
use crate::recipe::{MaterialGloss, ShadingParams};
use pelage_formats::Gloss;
use pelage_import::mesh::{Feature, Material, Model, RestPose};

/// Tear film on the cornea: index of refraction 1.37, slightly less at its edge.
const CORNEA: Gloss = Gloss { roughness: 0.06, reflectance: 0.025, metalness: 0.0, wet: true };
/// Moist skin of noses and around eyes.
const MOIST: Gloss = Gloss { roughness: 0.4, reflectance: 0.035, metalness: 0.0, wet: false };
/// Roughness and reflectance of a material whose gloss comes from the recipe alone: glTF's dielectric.
const PLAIN: Gloss = Gloss { roughness: 0.5, reflectance: 0.04, metalness: 0.0, wet: false };
/// Maximum metalness of another material, below which the file's metalness counts. Files that give all materials the
/// same metalness do not mean it.
const NOT_METAL: f32 = 0.3;

/// Returns the gloss of each material where its surface is bare; an empty list if there is none.
///
/// * `furred`: whether hair grows on each material; such a material has gloss only if the recipe says so
/// * `warnings`: receives the tables `[[shading.material]]` that match no material
pub fn gloss(model: &Model, furred: &[bool], params: &ShadingParams, warnings: &mut Vec<String>) -> Vec<Option<Gloss>> {
    let materials = &model.materials;
    for table in params.material.iter().filter(|table| !materials.iter().any(|of| is_named(&table.name, of))) {
        let names: Vec<_> = materials.iter().map(Material::full_name).collect();
        warnings.push(format!("shading.material: {:?} matches no material; the model has {names:?}", table.name));
    }
    if !params.gloss {
        return Vec::new();
    }
    let rest = RestPose::of(&model.mesh, model.animation.as_ref());
    let faces = WeldedFaces::new(&model.mesh, &rest.positions, &weld(&rest.positions), materials.len());
    let is_metal_rare = materials.iter().any(|of| of.metallic.is_some_and(|metallic| metallic <= NOT_METAL));
    let found = materials.iter().enumerate().map(|(m, material)| {
        let bare = furred.get(m) == Some(&false);
        let own = bare.then(|| of_part(model, m, &faces).or_else(|| of_file(material, is_metal_rare))).flatten();
        params.material.iter().filter(|table| is_named(&table.name, material)).fold(own, with_table)
    });
    let found: Vec<_> = found.collect();
    if found.iter().any(Option::is_some) { found } else { Vec::new() }
}

/// Returns the gloss of an eye or a nose; `None` for other bare parts.
fn of_part(model: &Model, m: usize, faces: &WeldedFaces) -> Option<Gloss> {
    let material = &model.materials[m];
    let mut names = vec![words(&material.name)];
    match &material.feature {
        Some(Feature::Eyes | Feature::InHead) => return Some(CORNEA),
        Some(Feature::Nose | Feature::EyeRims) => return Some(MOIST),
        Some(Feature::Claws) => return None,
        Some(Feature::Named(name) | Feature::Joint(name)) => names.push(words(name)),
        None => {
            let parts = model.mesh.parts.iter().filter(|part| part.material == m);
            names.extend(parts.flat_map(|part| &part.names).map(|name| words(name)));
        }
    }
    if names.iter().any(|name| are_names_of_eyes(name)) {
        return Some(CORNEA);
    }
    if names.iter().any(|name| are_names_of_nose(name)) {
        return Some(MOIST);
    }
    faces.are_round_pairs(m).then_some(CORNEA)
}

/// Returns the gloss that the model's file gives to a material; `None` if it gives none, or the default of glTF.
fn of_file(material: &Material, is_metal_rare: bool) -> Option<Gloss> {
    let roughness = material.roughness.filter(|roughness| *roughness < 1.0)?;
    let metalness = material.metallic.filter(|_| is_metal_rare).unwrap_or(0.0).clamp(0.0, 1.0);
    Some(Gloss { roughness: clamped(roughness), metalness, ..PLAIN })
}

/// Applies a table of the recipe. A reflectance of 0 removes the gloss.
fn with_table(own: Option<Gloss>, table: &MaterialGloss) -> Option<Gloss> {
    let before = own.unwrap_or(PLAIN);
    let roughness = table.roughness.map_or(before.roughness, clamped);
    let gloss = Gloss { roughness, reflectance: table.reflectance.unwrap_or(before.reflectance), ..before };
    (table.reflectance != Some(0.0)).then_some(gloss)
}

fn clamped(roughness: f32) -> f32 {
    roughness.clamp(*Gloss::ROUGHNESS.start(), *Gloss::ROUGHNESS.end())
}
