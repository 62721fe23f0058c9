//! `pack` stage: converts the stages' results to the data of a package, and assembles the package.

use super::assemble::{Content, NamedTexture, Textures, assemble, borrowed_texture, copied_sections};
use crate::memo::Memo;
use crate::progress::StageProgress;
use crate::recipe::{HairColors, Recipe};
use crate::stages::fins::EdgeFins;
use crate::stages::groom::{Colors, Lengths, VertexGroom, cornea_normals};
use crate::stages::hair_groups::GuidedHair;
use crate::stages::ink::{InkFiles, VertexInk};
use crate::stages::openness::openness;
use crate::stages::scatter::FibreTables;
use crate::stages::slice::{FIN_SLICES, FinTextures, ShellTextures, VisibilityTexture};
use crate::stages::surface::Surface;
use crate::stages::{detail, hair_motion, morphs, simplify};
use pelage_formats::meaning::openness::Openness;
use pelage_formats::meaning::{encode_bare_normal, groom_bytes, tile_frame, to_tile};
use pelage_formats::{
    Animation, AttributeVertex, Bounds, Choice, ContourMesh, FORMAT_VERSION, FinData, FinInfo, FurInfo, GeometryVertex,
    Gloss, HairMotion, InkData, InkInfo, InputRecord, Limits, Manifest, Material, MeshData, Package, Part,
    QualityFigure, RootsInfo, Shading, SimplifiedLevel, StrandsData, StrokePool, Tag, VisibilityInfo,
};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use std::sync::Arc;

/// Model part of a package, without hair.
#[derive(Clone, Debug, Default)]
pub struct ModelPart<'a> {
    /// Manifest, as far as the model determines it. Textures of materials are indices into `images`. Its fur part
    /// contains only the tile's size, the height, and the numbers of strands and patches.
    pub manifest: Manifest,
    /// Sections before the textures: mesh, skeleton and clips, and sections added by other programs.
    pub sections: Vec<Content<'a>>,
    /// Textures of the materials.
    pub images: Vec<NamedTexture<'a>>,
    /// Lengths derived for settings that the recipe leaves open; `None` if the recipe gives all of them.
    pub lengths: Option<Lengths>,
    /// Colours of the hair; `None` if the recipe gives them.
    pub hair_colors: Option<HairColors>,
    /// Width of the pattern, metres; `None` if the recipe gives it.
    pub pattern_size_m: Option<f32>,
    /// Names of the bare materials; `None` if the recipe gives them.
    pub bare: Option<Vec<String>>,
    /// Distance from bare materials at which hair has its full length, metres; `None` if the recipe gives it.
    pub bare_margin_m: Option<f32>,
    /// Recipe with hair and patches in units of the tile, if it gave them in other units.
    pub filled: Option<Box<Recipe>>,
}

/// Fins of a model, without their textures.
#[derive(Clone, Debug, Default)]
pub struct ModelFins<'a> {
    /// Section of the fins; `None` for a model without fins.
    pub section: Option<Content<'a>>,
    /// Default depth of the layer of hair that a fin shows, tile widths; `None` if the recipe gives it.
    pub depth: Option<f32>,
}

/// Results of the stages that go into the model part of a package.
#[derive(Clone, Copy, Debug)]
pub struct ModelResults<'a> {
    /// Model name, for the manifest.
    pub name: &'a str,
    /// Counter of the simplified triangle lists.
    pub progress: &'a StageProgress,
    /// Model with its materials and motions.
    pub model: &'a Model,
    /// Files that the recipe names, besides the model.
    pub inputs: &'a [InputRecord],
    /// Mesh with tile coordinates and frames.
    pub surface: &'a Surface,
    /// Whether each material is furred.
    pub furred: &'a [bool],
    /// Value of `model.bare`, or an equivalent value if the recipe does not set it.
    pub bare: &'a [String],
    /// Distance from bare materials at which hair has its full length, metres.
    pub bare_margin_m: Option<f32>,
    /// Per-vertex properties of the fur.
    pub coat: &'a VertexGroom,
    /// Colours of materials and vertices.
    pub colors: &'a Colors,
    /// Bounding box and sphere in the rest pose.
    pub bounds: Bounds,
    /// Lengths of hair and tile.
    pub lengths: Lengths,
    /// Recipe with its hair in units of the tile.
    pub filled: &'a Recipe,
    /// Colours of the hair.
    pub hair_colors: HairColors,
    /// Height of the fur, metres.
    pub height_m: f32,
    /// Number of strands per tile.
    pub strands: u32,
    /// Width of the pattern, metres, if there is one.
    pub pattern_size_m: Option<f32>,
    /// Lateral offsets of hair from its root; `None` unless hair has the colour of its root.
    pub roots: Option<&'a RootsInfo>,
    /// Base-colour textures: one .ktx2 file per image of `colors`.
    pub base_colors: &'a [Vec<u8>],
    /// Groom textures: .ktx2 files.
    pub groom_textures: &'a [Vec<u8>],
    /// Index into `groom_textures` for each material.
    pub groom_of_material: &'a [Option<usize>],
    /// Gloss of the bare surface of each material; empty if all is matt.
    pub gloss: &'a [Option<Gloss>],
    /// Whether simplified triangle lists are added to the mesh.
    pub simplified: bool,
    /// Warnings of earlier stages.
    pub warnings: &'a [String],
}

/// Input from which the simplified triangle lists are made, besides the model's skeleton. If the input is unchanged,
/// the lists are reused.
#[derive(Clone, Debug, PartialEq)]
pub struct SimplifyInput {
    mesh: Arc<MeshData>,
    parts: Vec<Part>,
    tile_size_m: f32,
}

/// Simplified triangle lists, by decreasing size.
pub type SimplifiedLists = Arc<[SimplifiedLevel]>;

/// Input from which the openness is computed, besides the model's skeleton. If the input is unchanged, the openness is
/// reused.
#[derive(Clone, Debug, PartialEq)]
pub struct OpennessInput {
    mesh: Arc<MeshData>,
    /// Whether each triangle occludes what is behind it.
    hides: Vec<bool>,
}

/// Openness of each vertex: share of all directions that the body leaves open to its hair.
pub type VertexOpenness = Arc<[Openness]>;

/// Intermediate results that can be reused for the same model.
#[derive(Clone, Debug, Default)]
pub struct ModelMemo {
    lists: Memo<SimplifyInput, SimplifiedLists>,
    opened: Memo<OpennessInput, VertexOpenness>,
}

/// Converts the model part to the data of a package. `kept`: reusable results from an earlier call with the same model.
pub fn model_part(pieces: &ModelResults<'_>, kept: &ModelMemo) -> ModelPart<'static> {
    let ModelResults { model, surface, .. } = *pieces;
    let mut textures = Vec::new();
    let mut add_all = |prefix: &str, files: &[Vec<u8>]| {
        let first = textures.len() as u32;
        let named = |(i, file): (usize, &Vec<u8>)| (format!("{prefix}_{i}").into(), file.clone().into());
        textures.extend(files.iter().enumerate().map(named));
        (first..textures.len() as u32).collect::<Vec<u32>>()
    };
    let base_colors = add_all("base_color", pieces.base_colors);
    let grooms = add_all("groom", pieces.groom_textures);
    let manifest = Manifest {
        generator: concat!("pelage ", env!("CARGO_PKG_VERSION")).into(),
        model: pieces.name.into(),
        inputs: [&model.inputs[..], pieces.inputs].concat(),
        bounds: pieces.bounds,
        fur: FurInfo {
            tile_size_m: pieces.lengths.tile_size_m,
            height_m: pieces.height_m,
            strands: pieces.strands,
            patches: surface.measures.patches,
            ..FurInfo::default()
        },
        materials: materials(pieces, &base_colors, &grooms),
        parts: parts(surface),
        quality: quality(surface),
        warnings: pieces.warnings.to_vec(),
        ..Manifest::default()
    };
    let mut mesh = Arc::new(mesh_data(pieces));
    // Materials with holes cut by a texture do not occlude: rays ignore textures.
    let solid = |part: &Part| manifest.materials.get(part.material as usize).is_none_or(|of| of.alpha_cutoff.is_none());
    let hides = |part: &Part| std::iter::repeat_n(solid(part), part.index_count as usize / 3);
    let hides = manifest.parts.iter().flat_map(hides).collect();
    let tile_size_m = manifest.fur.tile_size_m;
    let simplified = || {
        let input = SimplifyInput { mesh: mesh.clone(), parts: manifest.parts.clone(), tile_size_m };
        let levels = |of: &SimplifyInput| {
            simplify::levels(&of.mesh, &of.parts, model.animation.as_ref(), of.tile_size_m, pieces.progress)
        };
        in_section(kept.lists.of(input, |of| levels(of).into()))
    };
    let opened = || {
        let is_solid = |of: &OpennessInput, triangle: usize| of.hides.get(triangle).copied().unwrap_or(true);
        let openness = |of: &OpennessInput| openness(&of.mesh, model.animation.as_ref(), |i| is_solid(of, i));
        kept.opened.of(OpennessInput { mesh: mesh.clone(), hides }, |of| openness(of).into())
    };
    let (simplified, opened) = rayon::join(|| pieces.simplified.then(simplified).flatten(), opened);
    let morphs =
        morphs::mesh_morphs(&mesh, &surface.mesh.morph_rows, model).map(|morphs| Content::Morphs(Arc::new(morphs)));
    morphs::hidden(&mut mesh, &surface.mesh.morph_rows, model);
    let animation = model.animation.clone().map(|animation| Content::Animation(Arc::new(animation)));
    let roots = pieces.roots.map(|info| Content::Roots(info.clone()));
    let of_hair = &pieces.colors.hair;
    let of_hair = of_hair.iter().any(Option::is_some).then(|| Content::HairColors(of_hair.clone()));
    ModelPart {
        manifest,
        sections: [Content::Mesh(mesh)]
            .into_iter()
            .chain(simplified)
            .chain(animation)
            .chain(morphs)
            .chain(roots)
            .chain(of_hair)
            .chain([Content::Openness(opened)])
            .chain(bare_normals(surface, pieces.gloss).map(|normals| Content::BareNormals(normals.into())))
            .chain((!pieces.gloss.is_empty()).then(|| Content::Gloss(pieces.gloss.to_vec())))
            .collect(),
        images: textures,
        lengths: Some(pieces.lengths),
        filled: Some(Box::new(pieces.filled.clone())),
        hair_colors: Some(pieces.hair_colors),
        pattern_size_m: pieces.pattern_size_m,
        bare: Some(pieces.bare.to_vec()),
        bare_margin_m: pieces.bare_margin_m,
    }
}

/// Makes the simplified triangle lists of a mesh; `None` if there are none. Reads the parts and the tile size from the
/// manifest.
pub fn simplified(mesh: &MeshData, manifest: &Manifest, animation: Option<&Animation>) -> Option<Content<'static>> {
    let (tile_size_m, progress) = (manifest.fur.tile_size_m, StageProgress::ignored());
    in_section(simplify::levels(mesh, &manifest.parts, animation, tile_size_m, progress).into())
}

fn in_section(lists: SimplifiedLists) -> Option<Content<'static>> {
    (!lists.is_empty()).then_some(Content::Simplified(lists))
}

/// Converts a model's fins to the data of a package.
pub fn model_fins(surface: &Surface, fins: &EdgeFins) -> ModelFins<'static> {
    let section = || Content::Fins(fin_data(fins, &parts(surface)));
    ModelFins { section: (!fins.fins.is_empty()).then(section), depth: Some(fins.depth) }
}

/// Parts of a package, in the data types of the bake.
#[derive(Clone, Copy, Debug)]
pub struct PackInput<'a> {
    /// Recipe; settings that it leaves open come from the other parts.
    pub recipe: &'a Recipe,
    /// Constants of the lighting equation.
    pub shading: Shading,
    /// Model part of the package.
    pub skin: &'a ModelPart<'a>,
    /// Shell textures.
    pub shells: &'a ShellTextures,
    /// Shell textures of wet hair, if dry and wet are mixed.
    pub wet_shells: Option<&'a ShellTextures>,
    /// Strands of the tile, if any.
    pub strands: Option<&'a StrandsData>,
    /// Guided hair, with its warnings.
    pub hair: &'a GuidedHair,
    /// Fins.
    pub fins: &'a ModelFins<'a>,
    /// Textures of the fins; without them, the package has no fins.
    pub fin_textures: Option<&'a FinTextures>,
    /// Scattering tables of the fibres, if any.
    pub fibres: Option<&'a FibreTables>,
    /// Data of the ink style, if any.
    pub ink: Option<(&'a VertexInk, &'a InkFiles<'a>)>,
    /// Strokes with which the model is painted, if any.
    pub painting: Option<&'a Arc<StrokePool>>,
    /// Contour mesh of the ink style, if any.
    pub contours: Option<&'a Arc<ContourMesh>>,
}

/// Assembles and validates the package, and returns it with the warnings of all stages.
///
/// Fails with [`BakeError::Params`] if a value derived from the model's size is outside the range of a recipe. All
/// other errors are [`BakeError::Internal`], because earlier stages have checked all user input.
pub fn pack<'a>(pieces: &PackInput<'a>) -> Result<(Vec<u8>, Vec<String>), BakeError> {
    let PackInput { recipe, skin, .. } = *pieces;
    let mut textures = Textures::default();
    let shells = textures.add_shells("shell", pieces.shells);
    let images: Vec<u32> = skin.images.iter().map(|image| textures.add(borrowed_texture(image))).collect();
    let wet = pieces.wet_shells.map(|shells| textures.add_shells("wet_shell", shells));
    let fins = pieces.fin_textures.zip(pieces.fins.section.clone()).map(|(made, section)| {
        let indices = textures.add_shells("fin", &made.textures);
        let info = FinInfo {
            width: made.width,
            height: made.height,
            slabs: FIN_SLICES.len() as u32,
            color_texture: indices.color_texture,
            direction_texture: indices.direction_texture,
        };
        (info, section)
    });
    let ink = pieces.ink.map(|(ink, files)| InkData {
        info: InkInfo {
            stroke_texture: textures.add(borrowed_texture(&files.stroke)),
            wash_texture: textures.add(borrowed_texture(&files.wash)),
            paper_texture: textures.add(borrowed_texture(&files.paper)),
            fur_texture: files.fur.as_ref().map(|fur| textures.add(borrowed_texture(fur))),
            grain_size_m: ink.grain_size_m,
            shading: ink.shading,
        },
        vertices: ink.vertices.clone(),
    });
    let mut add = |name: &'static str, found: &'a VisibilityTexture| textures.add((name.into(), (&found.file).into()));
    let visibility = pieces.shells.visibility.as_ref().map(|found| VisibilityInfo {
        texture: add("shell_visibility", found),
        wet_texture: pieces.wet_shells.and_then(|s| s.visibility.as_ref()).map(|f| add("wet_shell_visibility", f)),
        horizon: found.horizon,
    });
    let fibres = pieces.fibres.map(|made| made.info(textures.add(("fibres".into(), (&made.file).into()))));
    let coat = pieces.shells.coat.as_ref();
    let mut materials = skin.manifest.materials.clone();
    for material in &mut materials {
        for index in [&mut material.base_color_texture, &mut material.groom_texture] {
            *index = index.map(|image| images[image as usize]);
        }
    }
    let mut warnings = skin.manifest.warnings.clone();
    warnings.extend(pieces.hair.warnings.iter().cloned());
    // If the package is sliced again, it already contains these warnings.
    let of_fibres = pieces.fibres.iter().flat_map(|made| &made.warnings).filter(|text| !warnings.contains(text));
    warnings.extend(of_fibres.cloned().collect::<Vec<_>>());
    warnings.extend(pieces.ink.iter().flat_map(|(ink, _)| ink.warnings.iter().cloned()));
    let (names, files) = textures.finish();
    // Values derived from the model's size may be outside the range of a recipe.
    let recorded = resolved(pieces);
    recorded.validate()?;
    let moves = hair_motion(pieces);
    warnings.extend(moves.iter().flat_map(|(_, fitted)| fitted.warnings.iter().cloned()));
    // A package that is sliced again may have the warning of its previous layers.
    warnings.retain(|text| !text.starts_with(detail::GAP_WARNING));
    if skin.manifest.materials.iter().any(|material| material.furred) {
        warnings.extend(detail::gap_warning(recipe, skin.manifest.fur.height_m, &skin.manifest.bounds));
    }
    let mut quality = skin.manifest.quality.clone();
    quality.extend(moves.iter().flat_map(|(_, fitted)| {
        let figure = |name: &str, value, unit: &str| QualityFigure { name: name.into(), value, unit: unit.into() };
        let count = fitted.colliders.len() as f64;
        [figure("hair_colliders", count, "capsules"), figure("hair_collider_gap", fitted.gap_m.into(), "m")]
    }));
    let manifest = Manifest {
        recipe: recorded.to_toml(),
        quality,
        shading: pieces.shading,
        fur: FurInfo {
            layers: recipe.slice.layers,
            tile_texels: recipe.slice.tile_texels,
            color_texture: shells.color_texture,
            direction_texture: shells.direction_texture,
            wet,
            fins: fins.as_ref().map(|(info, _)| *info),
            ..skin.manifest.fur
        },
        materials,
        textures: names,
        warnings: warnings.clone(),
        coat: coat.map(|coat| coat.info),
        detail: detail::levels(&recipe.detail, recipe.slice.layers, coat),
        choice: None,
        ..skin.manifest.clone()
    };
    let fins = fins.map(|(_, section)| section);
    // A hair motion section copied from an earlier package must come after the hair.
    let is_motion = |section: &&Content<'_>| matches!(section, Content::Bytes(Tag::HAIR_MOTION, _));
    let kept_motion = skin.sections.iter().filter(is_motion).cloned();
    let sections = skin.sections.iter().filter(|section| !is_motion(section)).cloned();
    let sections = sections.chain(files).chain(fins).chain(ink.map(Content::Ink));
    let sections = sections.chain(pieces.painting.cloned().map(Content::Strokes));
    let sections = sections.chain(pieces.contours.cloned().map(Content::Contours));
    let strands = pieces.strands.cloned().map(Content::Strands);
    let hair = (!pieces.hair.groups.is_empty()).then(|| Content::Hair(pieces.hair.groups.clone()));
    let motion = moves.map(|(motion, _)| Content::HairMotion(Arc::new(motion)));
    let sections =
        sections.chain(visibility.map(Content::Visibility)).chain(strands).chain(hair).chain(motion).chain(kept_motion);
    let sections = sections.chain(fibres.map(Content::Fibres));
    let fault = |fault| BakeError::Internal(format!("the package cannot be read back: {fault}"));
    Ok((assemble(FORMAT_VERSION, manifest, sections).map_err(fault)?, warnings))
}

/// Returns the motion of guided hair. The result is `None` if no hair moves, or if the model part is copied from a
/// package that already contains the section.
fn hair_motion(pieces: &PackInput<'_>) -> Option<(HairMotion, hair_motion::FittedColliders)> {
    let sections = &pieces.skin.sections;
    let mesh = sections.iter().find_map(|s| if let Content::Mesh(mesh) = s { Some(mesh) } else { None })?;
    let animation = sections.iter().find_map(|s| if let Content::Animation(a) = s { Some(&**a) } else { None });
    let morphs = sections.iter().find_map(|s| if let Content::Morphs(morphs) = s { Some(morphs) } else { None });
    let moving = morphs.zip(animation).filter(|_| !pieces.hair.groups.is_empty());
    let shown = moving.map(|(morphs, animation)| morphs::shown_mesh(mesh, morphs, animation));
    hair_motion::group_motion(&pieces.recipe.strands, pieces.hair, shown.as_ref().unwrap_or(mesh), animation)
}

/// Returns the recipe with all open settings filled in.
fn resolved(pieces: &PackInput<'_>) -> Recipe {
    let mut recipe = pieces.recipe.clone();
    if let Some(filled) = &pieces.skin.filled {
        (recipe.hair, recipe.underfur) = (filled.hair.clone(), filled.underfur.clone());
        recipe.surface = filled.surface.clone();
    }
    recipe.model.bare = recipe.model.bare.or_else(|| pieces.skin.bare.clone());
    recipe.groom.bare_margin_m = recipe.groom.bare_margin_m.or(pieces.skin.bare_margin_m);
    if let Some(lengths) = pieces.skin.lengths {
        recipe.hair.length_m = Some(lengths.length_m);
        recipe.surface.tile_size_m = Some(lengths.tile_size_m);
    }
    if let Some(HairColors { gain, root, tip }) = pieces.skin.hair_colors {
        (recipe.color.gain, recipe.color.root, recipe.color.tip) = (Some(gain), Some(root), Some(tip));
    }
    recipe.fins.depth = recipe.fins.depth.or(pieces.fins.depth);
    recipe.color.pattern_size_m = pieces.skin.pattern_size_m.or(recipe.color.pattern_size_m);
    if let Some((ink, center)) = pieces.ink.and_then(|(ink, _)| Some((ink, ink.center?))) {
        recipe.ink.center = Some(center);
        recipe.ink.grain_size_m = Some(ink.grain_size_m);
        recipe.ink.fur = Some(ink.shading.fur);
    }
    recipe
}

/// Adds the record of how settings were chosen to a package.
///
/// Fails with [`BakeError::Internal`] if the package, which was just written, does not open.
pub fn with_choice(package: &[u8], choice: Choice) -> Result<Vec<u8>, BakeError> {
    let write = || {
        let opened = Package::open(package, &Limits::default())?;
        let manifest = Manifest { choice: Some(choice), ..opened.manifest().clone() };
        assemble(FORMAT_VERSION, manifest, copied_sections(&opened, |_| true)?)
    };
    write().map_err(|fault| {
        BakeError::Internal(format!(
            "the package with the record of its choice cannot be read \
         back: {fault}"
        ))
    })
}

/// Replaces the recipe recorded in a package, as if the package had been baked from the new one. The new recipe must
/// state exactly what the earlier bake was given or chose. The record of how settings were chosen is removed, because
/// no setting is left to choose.
///
/// * `file`: name of the recipe, for messages
/// * `text`: recipe
/// * `inputs`: files that such a bake reads, in the order of reading
///
/// Fails with errors of [`Recipe::parse`] for the text; [`BakeError::Internal`] if the package, which was just written,
/// does not open.
pub fn with_recipe(package: &[u8], file: &str, text: &str, inputs: Vec<InputRecord>) -> Result<Vec<u8>, BakeError> {
    let fault = |fault| BakeError::Internal(format!("the package with its recipe cannot be read back: {fault}"));
    let opened = Package::open(package, &Limits::default()).map_err(fault)?;
    let recipe = Recipe::parse(file, text)?.to_toml();
    let manifest = Manifest { recipe, inputs, choice: None, ..opened.manifest().clone() };
    let sections = copied_sections(&opened, |_| true).map_err(fault)?;
    assemble(FORMAT_VERSION, manifest, sections).map_err(fault)
}

fn materials(pieces: &ModelResults<'_>, base_colors: &[u32], grooms: &[u32]) -> Vec<Material> {
    let convert =
        |((i, m), color): ((usize, &pelage_import::mesh::Material), &crate::stages::groom::MaterialColor)| Material {
            name: m.full_name(),
            base_color: color.factor,
            base_color_texture: color.image.map(|image| base_colors[image]),
            groom_texture: pieces.groom_of_material.get(i).copied().flatten().map(|texture| grooms[texture]),
            alpha_cutoff: m.alpha_cutoff,
            furred: pieces.furred.get(i).copied().unwrap_or(false),
            double_sided: m.double_sided,
        };
    pieces.model.materials.iter().enumerate().zip(&pieces.colors.materials).map(convert).collect()
}

/// Returns index ranges, one per draw call. Neighbouring parts with the same material are merged.
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

/// Converts the fins, and counts those of each part.
fn fin_data(fins: &EdgeFins, parts: &[Part]) -> FinData {
    let end = |part: &Part| fins.triangles.partition_point(|t| 3 * t < part.first_index + part.index_count) as u32;
    let mut first = 0;
    let count = |part: &Part| end(part) - std::mem::replace(&mut first, end(part));
    FinData { part_counts: parts.iter().map(count).collect(), fins: fins.fins.clone() }
}

fn mesh_data(pieces: &ModelResults<'_>) -> MeshData {
    let ModelResults { surface, coat, colors, .. } = *pieces;
    let mesh = &surface.mesh;
    let geometry = (0..mesh.positions.len()).map(|i| GeometryVertex {
        position: mesh.positions[i].into(),
        fur_height: coat.length[i] * pieces.height_m,
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

/// Returns the stored normals of bare surface; `None` if they are those of the hair.
fn bare_normals(surface: &Surface, gloss: &[Option<Gloss>]) -> Option<Vec<[i16; 2]>> {
    let (mesh, tangents) = (&surface.mesh, &surface.tangents);
    let of_corneas = cornea_normals(mesh, gloss);
    let bare_normals = of_corneas.as_ref().unwrap_or(&mesh.bare_normals);
    let stored = bare_normals.iter().zip(&mesh.normals).zip(tangents).map(|((bare, normal), tangent)| {
        encode_bare_normal(to_tile(tile_frame(*normal, tangent.truncate(), tangent.w), *bare))
    });
    (!bare_normals.is_empty()).then(|| stored.collect())
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
