//! Everything together into one package: the `pack` stage.

use crate::BakeError;
use crate::mesh::Model;
use crate::surface::Surface;
use pelage_formats::{
    AttributeVertex, Bounds, FurInfo, GeometryVertex, Manifest, Material, MeshData, PackageWriter, Part, QualityFigure,
    Shading, TextureEntry,
};

/// What the stages made, ready to be packed.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<'a> {
    /// Name of the model, for the manifest.
    pub name: &'a str,
    /// The model: materials, motions, inputs.
    pub model: &'a Model,
    /// Its mesh with tile coordinates and frames.
    pub surface: &'a Surface,
    /// One per material.
    pub furred: &'a [bool],
    /// One per vertex of the surface's mesh, metres.
    pub fur_heights: &'a [f32],
    /// Box and sphere of the rest pose.
    pub bounds: Bounds,
    /// The shell volume; its texture indices are filled in here.
    pub fur: FurInfo,
    /// Constants of the lighting equation.
    pub shading: Shading,
    /// Whether the model's own colours multiply the hair's.
    pub base_color: bool,
    /// The recipe as resolved, TOML.
    pub recipe: &'a str,
    /// The shell colour texture, a .ktx2 file.
    pub shell_color: &'a [u8],
    /// The direction texture, a .ktx2 file.
    pub shell_direction: &'a [u8],
    /// One .ktx2 file per image of the model.
    pub base_colors: &'a [Vec<u8>],
    /// What all stages had to say.
    pub warnings: &'a [String],
}

/// Writes the package; what comes back opens and validates.
pub fn pack(pieces: &Pieces<'_>) -> Result<Vec<u8>, BakeError> {
    let Pieces { model, surface, .. } = pieces;
    let mut textures = vec![named("shell_color"), named("shell_direction")];
    textures.extend((0..pieces.base_colors.len()).map(|i| named(&format!("base_color_{i}"))));
    let manifest = Manifest {
        generator: concat!("pelage ", env!("CARGO_PKG_VERSION")).into(),
        model: pieces.name.into(),
        recipe: pieces.recipe.into(),
        inputs: model.inputs.clone(),
        bounds: pieces.bounds,
        fur: FurInfo { color_texture: 0, direction_texture: 1, ..pieces.fur },
        shading: pieces.shading,
        materials: materials(pieces),
        parts: parts(surface),
        textures,
        quality: quality(surface),
        warnings: pieces.warnings.to_vec(),
    };
    let mut writer = PackageWriter::new(manifest).mesh(&mesh_data(pieces));
    if let Some(animation) = &model.animation {
        writer = writer.animation(animation);
    }
    writer = writer.texture(pieces.shell_color).texture(pieces.shell_direction);
    for texture in pieces.base_colors {
        writer = writer.texture(texture.as_slice());
    }
    // The stages before have checked everything that comes from the user, so a fault here is ours.
    writer.finish().map_err(|fault| BakeError::Internal(format!("the package does not read back: {fault}")))
}

fn named(name: &str) -> TextureEntry {
    TextureEntry { name: name.into() }
}

fn materials(pieces: &Pieces<'_>) -> Vec<Material> {
    let furred = |i: usize| pieces.furred.get(i).copied().unwrap_or(false);
    let convert = |(i, m): (usize, &crate::mesh::Material)| {
        let colored = pieces.base_color || !furred(i);
        Material {
            name: m.name.clone(),
            base_color: if colored { m.base_color } else { [1.0; 4] },
            base_color_texture: m.base_color_image.filter(|_| colored).map(|image| 2 + image as u32),
            groom_texture: None,
            alpha_cutoff: m.alpha_cutoff,
            furred: furred(i),
            double_sided: m.double_sided,
        }
    };
    pieces.model.materials.iter().enumerate().map(convert).collect()
}

/// Index ranges: neighbouring parts of one material become one draw.
fn parts(surface: &Surface) -> Vec<Part> {
    let mut out: Vec<Part> = Vec::new();
    for part in surface.mesh.parts.iter().filter(|p| p.triangle_count > 0) {
        let (material, count) = (part.material as u32, 3 * part.triangle_count as u32);
        match out.last_mut().filter(|last| last.material == material) {
            Some(last) => last.index_count += count,
            None => out.push(Part { material, first_index: 3 * part.first_triangle as u32, index_count: count }),
        }
    }
    out
}

fn mesh_data(pieces: &Pieces<'_>) -> MeshData {
    let Pieces { surface, fur_heights, .. } = *pieces;
    let mesh = &surface.mesh;
    let colored = |i: usize| pieces.base_color || fur_heights[i] == 0.0;
    let geometry = (0..mesh.positions.len()).map(|i| GeometryVertex {
        position: mesh.positions[i].into(),
        fur_height: fur_heights[i],
        normal: mesh.normals[i].into(),
        lean: 0.0,
        tangent: surface.tangents[i].into(),
    });
    let attributes = (0..mesh.positions.len()).map(|i| AttributeVertex {
        tile_uv: surface.tile_uvs[i].into(),
        base_uv: mesh.uvs[i].into(),
        color: if colored(i) { mesh.colors[i] } else { [255; 4] },
        groom: [0; 4],
    });
    MeshData {
        geometry: geometry.collect(),
        attributes: attributes.collect(),
        skin: mesh.skin.clone(),
        indices: mesh.triangles.iter().flatten().copied().collect(),
    }
}

fn quality(surface: &Surface) -> Vec<QualityFigure> {
    let m = &surface.measures;
    let figure = |name: &str, value: f64, unit: &str| QualityFigure { name: name.into(), value, unit: unit.into() };
    let mut figures = vec![
        figure("flipped_triangles", f64::from(m.flipped_triangles), "triangles"),
        figure("angle_distortion", m.angle_distortion, "1"),
        figure("area_distortion", m.area_distortion, "1"),
        figure("stretch_l2", m.stretch_l2, "1"),
        figure("seam_length_ratio", m.seam_length_ratio, "1"),
        figure("collapsed_area", m.collapsed_area, "1"),
        figure("singularities", f64::from(m.singularities), "points"),
    ];
    figures.extend(m.comb_misalignment_deg.map(|angle| figure("comb_misalignment_deg", angle, "degrees")));
    figures
}
