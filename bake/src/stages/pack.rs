//! Everything together into one package: the `pack` stage.

use crate::BakeError;
use crate::mesh::Model;
use crate::stages::fins::EdgeFins;
use crate::stages::groom::{Coat, Colors};
use crate::stages::ink::Ink;
use crate::stages::surface::Surface;
use crate::stages::textures::{FinTextures, SLABS, ShellTextures};
use pelage_formats::meaning::groom_bytes;
use pelage_formats::{
    AttributeVertex, Bounds, Choice, DetailLevel, FinData, FinInfo, FurInfo, GeometryVertex, InkData, InkInfo,
    InputRecord, Limits, Manifest, Material, MeshData, Package, PackageWriter, Part, QualityFigure, Shading, Tag,
    TextureEntry,
};
use std::borrow::Cow;

/// What the stages made, ready to be packed.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<'a> {
    /// Name of the model, for the manifest.
    pub name: &'a str,
    /// The model: materials and motions.
    pub model: &'a Model,
    /// The files that were read.
    pub inputs: &'a [InputRecord],
    /// Its mesh with tile coordinates and frames.
    pub surface: &'a Surface,
    /// One per material.
    pub furred: &'a [bool],
    /// What varies over the vertices of the surface's mesh.
    pub coat: &'a Coat,
    /// Colours of its materials and vertices.
    pub colors: &'a Colors,
    /// Box and sphere of the rest pose.
    pub bounds: Bounds,
    /// The shell volume; its texture indices are filled in here.
    pub fur: FurInfo,
    /// Constants of the lighting equation.
    pub shading: Shading,
    /// The recipe as resolved, TOML.
    pub recipe: &'a str,
    /// The shell textures.
    pub shells: &'a ShellTextures,
    /// The shell textures of wet hair, where dry and wet mix.
    pub wet_shells: Option<&'a ShellTextures>,
    /// Fins and their textures, or none.
    pub fins: Option<(&'a EdgeFins, &'a FinTextures)>,
    /// One .ktx2 file per image of `colors`.
    pub base_colors: &'a [Vec<u8>],
    /// The groom textures, .ktx2 files.
    pub groom_textures: &'a [Vec<u8>],
    /// One per material: index into `groom_textures`.
    pub groom_of_material: &'a [Option<usize>],
    /// What the ink style needs, or none.
    pub ink: Option<&'a Ink>,
    /// Levels of detail, finest first.
    pub detail: &'a [DetailLevel],
    /// What all stages had to say.
    pub warnings: &'a [String],
}

/// The textures of a package that is being written, in their order.
#[derive(Default)]
pub(crate) struct Textures<'a> {
    /// For the manifest.
    pub(crate) entries: Vec<TextureEntry>,
    /// A .ktx2 file for each entry.
    pub(crate) files: Vec<Cow<'a, [u8]>>,
}

impl<'a> Textures<'a> {
    /// Adds a .ktx2 file and returns its index.
    pub(crate) fn add(&mut self, name: impl Into<String>, file: impl Into<Cow<'a, [u8]>>) -> u32 {
        self.entries.push(TextureEntry { name: name.into() });
        self.files.push(file.into());
        self.files.len() as u32 - 1
    }

    /// Adds the two textures of a shell volume, their names prefixed.
    pub(crate) fn add_shells(&mut self, prefix: &str, shells: &'a ShellTextures) -> pelage_formats::ShellTextures {
        pelage_formats::ShellTextures {
            color_texture: self.add(format!("{prefix}_color"), &shells.color),
            direction_texture: self.add(format!("{prefix}_direction"), &shells.direction),
        }
    }

    fn add_all(&mut self, prefix: &str, files: &'a [Vec<u8>]) -> Vec<u32> {
        files.iter().enumerate().map(|(i, file)| self.add(format!("{prefix}_{i}"), file)).collect()
    }
}

/// Writes the package; what comes back opens and validates.
pub fn pack(pieces: &Pieces<'_>) -> Result<Vec<u8>, BakeError> {
    let Pieces { model, surface, .. } = pieces;
    let mut textures = Textures::default();
    let shells = textures.add_shells("shell", pieces.shells);
    let base_colors = textures.add_all("base_color", pieces.base_colors);
    let grooms = textures.add_all("groom", pieces.groom_textures);
    let wet = pieces.wet_shells.map(|shells| textures.add_shells("wet_shell", shells));
    let fins = pieces.fins.map(|(_, fins)| {
        let indices = textures.add_shells("fin", &fins.textures);
        FinInfo {
            width: fins.width,
            height: fins.height,
            slabs: SLABS.len() as u32,
            color_texture: indices.color_texture,
            direction_texture: indices.direction_texture,
        }
    });
    let ink = pieces.ink.map(|ink| InkData {
        info: InkInfo {
            stroke_texture: textures.add("ink_stroke", &ink.textures.stroke),
            wash_texture: textures.add("ink_wash", &ink.textures.wash),
            paper_texture: textures.add("ink_paper", &ink.textures.paper),
            fur_texture: ink.textures.fur.as_ref().map(|fur| textures.add("ink_fur", fur)),
            grain_size_m: ink.grain_size_m,
            shading: ink.shading,
        },
        vertices: ink.vertices.vertices.clone(),
    });
    let parts = parts(surface);
    let manifest = Manifest {
        generator: concat!("pelage ", env!("CARGO_PKG_VERSION")).into(),
        model: pieces.name.into(),
        recipe: pieces.recipe.into(),
        inputs: pieces.inputs.to_vec(),
        bounds: pieces.bounds,
        fur: FurInfo {
            color_texture: shells.color_texture,
            direction_texture: shells.direction_texture,
            wet,
            fins,
            ..pieces.fur
        },
        shading: pieces.shading,
        materials: materials(pieces, &base_colors, &grooms),
        parts: parts.clone(),
        textures: textures.entries,
        quality: quality(surface),
        warnings: pieces.warnings.to_vec(),
        coat: pieces.shells.coat.as_ref().map(|coat| coat.info),
        detail: pieces.detail.to_vec(),
        choice: None,
    };
    let mut writer = PackageWriter::new(manifest).mesh(&mesh_data(pieces));
    if let Some(animation) = &model.animation {
        writer = writer.animation(animation);
    }
    for file in textures.files {
        writer = writer.texture(file);
    }
    if let Some((fins, _)) = pieces.fins {
        writer = writer.fins(&fin_data(fins, &parts));
    }
    if let Some(ink) = &ink {
        writer = writer.ink(ink);
    }
    // The stages before have checked everything that comes from the user, so a fault here is ours.
    writer.finish().map_err(|fault| BakeError::Internal(format!("the package does not read back: {fault}")))
}

/// The package with the evidence of how its settings were chosen.
///
/// # Errors
///
/// [`BakeError::Internal`] for a package that does not open: it was written just before.
pub fn with_choice(package: &[u8], choice: Choice) -> Result<Vec<u8>, BakeError> {
    let write = || {
        let opened = Package::open(package, &Limits::default())?;
        let manifest = Manifest { choice: Some(choice), ..opened.manifest().clone() };
        let mut writer = PackageWriter::new(manifest);
        for (index, section) in opened.sections().iter().enumerate() {
            if section.tag != Tag::MANIFEST {
                writer = writer.section(section.tag, opened.section_bytes(index)?);
            }
        }
        writer.finish()
    };
    write().map_err(|fault| BakeError::Internal(format!("the package with its evidence does not read back: {fault}")))
}

fn materials(pieces: &Pieces<'_>, base_colors: &[u32], grooms: &[u32]) -> Vec<Material> {
    let convert = |((i, m), color): ((usize, &crate::mesh::Material), &crate::stages::groom::MaterialColor)| Material {
        name: m.name.clone(),
        base_color: color.factor,
        base_color_texture: color.image.map(|image| base_colors[image]),
        groom_texture: pieces.groom_of_material.get(i).copied().flatten().map(|texture| grooms[texture]),
        alpha_cutoff: m.alpha_cutoff,
        furred: pieces.furred.get(i).copied().unwrap_or(false),
        double_sided: m.double_sided,
    };
    pieces.model.materials.iter().enumerate().zip(&pieces.colors.materials).map(convert).collect()
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

/// The fins with their number on each part.
fn fin_data(fins: &EdgeFins, parts: &[Part]) -> FinData {
    let end = |part: &Part| fins.triangles.partition_point(|t| 3 * t < part.first_index + part.index_count) as u32;
    let mut first = 0;
    let count = |part: &Part| end(part) - std::mem::replace(&mut first, end(part));
    FinData { part_counts: parts.iter().map(count).collect(), fins: fins.fins.clone() }
}

fn mesh_data(pieces: &Pieces<'_>) -> MeshData {
    let Pieces { surface, coat, colors, .. } = *pieces;
    let mesh = &surface.mesh;
    let geometry = (0..mesh.positions.len()).map(|i| GeometryVertex {
        position: mesh.positions[i].into(),
        fur_height: coat.length[i] * pieces.fur.height_m,
        normal: mesh.normals[i].into(),
        lean: coat.lean[i],
        tangent: surface.tangents[i].into(),
    });
    let attributes = (0..mesh.positions.len()).map(|i| AttributeVertex {
        tile_uv: surface.tile_uvs[i].into(),
        base_uv: mesh.uvs[i].into(),
        color: colors.vertices[i],
        groom: groom_bytes(coat.bareness[i], coat.wetness[i]),
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
