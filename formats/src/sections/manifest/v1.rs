//! Manifest of version 1: that of version 2 without wet hair, fins and groom textures. Kept permanently, so that
//! packages of version 1 stay readable. The order of the fields must not change.

use super::data::{Bounds, FurInfo, InputRecord, Manifest, Material, Part, QualityFigure, Shading, TextureEntry};
use super::v2;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
pub(super) struct ManifestV1 {
    generator: String,
    model: String,
    recipe: String,
    inputs: Vec<InputRecord>,
    bounds: Bounds,
    fur: FurInfoV1,
    shading: Shading,
    materials: Vec<MaterialV1>,
    parts: Vec<Part>,
    textures: Vec<TextureEntry>,
    quality: Vec<QualityFigure>,
    warnings: Vec<String>,
}

#[derive(Serialize, Deserialize)]
struct FurInfoV1 {
    layers: u32,
    tile_texels: u32,
    tile_size_m: f32,
    height_m: f32,
    strands: u32,
    patches: u32,
    color_texture: u32,
    direction_texture: u32,
}

#[derive(Serialize, Deserialize)]
struct MaterialV1 {
    name: String,
    base_color: [f32; 4],
    base_color_texture: Option<u32>,
    alpha_cutoff: Option<f32>,
    furred: bool,
    double_sided: bool,
}

impl From<ManifestV1> for Manifest {
    fn from(old: ManifestV1) -> Self {
        let fur = old.fur;
        Self {
            generator: old.generator,
            model: old.model,
            recipe: old.recipe,
            inputs: old.inputs,
            bounds: old.bounds,
            fur: FurInfo {
                layers: fur.layers,
                tile_texels: fur.tile_texels,
                tile_size_m: fur.tile_size_m,
                height_m: fur.height_m,
                strands: fur.strands,
                patches: fur.patches,
                color_texture: fur.color_texture,
                direction_texture: fur.direction_texture,
                ..FurInfo::default()
            },
            shading: old.shading,
            materials: old
                .materials
                .into_iter()
                .map(|m| Material {
                    name: m.name,
                    base_color: m.base_color,
                    base_color_texture: m.base_color_texture,
                    groom_texture: None,
                    alpha_cutoff: m.alpha_cutoff,
                    furred: m.furred,
                    double_sided: m.double_sided,
                })
                .collect(),
            parts: old.parts,
            textures: old.textures,
            quality: old.quality,
            warnings: old.warnings,
            ..Self::default()
        }
    }
}

impl TryFrom<&Manifest> for ManifestV1 {
    /// Message with the path of the field that version 1 cannot store.
    type Error = String;

    fn try_from(new: &Manifest) -> Result<Self, String> {
        let fur = &new.fur;
        let refuse = |what: &str| Err(format!("{what} is given, expected none in version 1 of the format"));
        if let Some(what) = v2::first_newer_field(new) {
            return refuse(what);
        }
        if fur.wet.is_some() {
            return refuse("fur.wet");
        }
        if fur.fins.is_some() {
            return refuse("fur.fins");
        }
        if let Some(i) = new.materials.iter().position(|m| m.groom_texture.is_some()) {
            return refuse(&format!("materials[{i}].groom_texture"));
        }
        let material = |m: &Material| MaterialV1 {
            name: m.name.clone(),
            base_color: m.base_color,
            base_color_texture: m.base_color_texture,
            alpha_cutoff: m.alpha_cutoff,
            furred: m.furred,
            double_sided: m.double_sided,
        };
        Ok(Self {
            generator: new.generator.clone(),
            model: new.model.clone(),
            recipe: new.recipe.clone(),
            inputs: new.inputs.clone(),
            bounds: new.bounds,
            fur: FurInfoV1 {
                layers: fur.layers,
                tile_texels: fur.tile_texels,
                tile_size_m: fur.tile_size_m,
                height_m: fur.height_m,
                strands: fur.strands,
                patches: fur.patches,
                color_texture: fur.color_texture,
                direction_texture: fur.direction_texture,
            },
            shading: new.shading,
            materials: new.materials.iter().map(material).collect(),
            parts: new.parts.clone(),
            textures: new.textures.clone(),
            quality: new.quality.clone(),
            warnings: new.warnings.clone(),
        })
    }
}
