//! Slicing of existing strands again, with other settings for layers, tile, filter, formats or fins.
//!
//! [`reslice`] works on a package, without the model from which it was baked. Mesh, materials and motion stay the same,
//! byte for byte. The strands are simulated again from the recorded recipe, and the pipeline continues from
//! `visibility`.
//!
//! A [`Slicer`] has the model and keeps the outputs of a bake.

use crate::pipeline::{BakeInput, Output, Outputs, run};
use crate::progress::StageProgress;
use crate::recipe::Recipe;
use crate::stages::assemble::{Content, copied_sections, copied_texture};
use crate::stages::groom::MapImages;
use crate::stages::hair_groups::GuidedHair;
use crate::stages::ink::{self, InkFiles, VertexInk};
use crate::stages::pack::{ModelFins, ModelPart, simplified};
use crate::stages::simulate::Strands;
use crate::strands::tile_hair;
use pelage_formats::{FormatError, InkInfo, Manifest, Package, Tag};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use std::sync::Arc;

/// Returns the mesh data of the package. All of it is copied except the simplified index lists, which are made again or
/// left out, as `recipe` says.
fn skin<'a>(package: &Package<'a>, recipe: &Recipe) -> Result<ModelPart<'a>, FormatError> {
    let mut manifest = package.manifest().clone();
    // Textures of materials are copied. Several materials may share one, which is stored once in the package.
    let mut images = Vec::new();
    for material in &mut manifest.materials {
        for index in [&mut material.base_color_texture, &mut material.groom_texture] {
            let Some(old) = *index else { continue };
            *index = Some(images.len() as u32);
            images.push(copied_texture(package, old)?);
        }
    }
    let look = [Tag::TEXTURE, Tag::FINS, Tag::INK, Tag::STROKES, Tag::CONTOURS, Tag::VISIBILITY, Tag::SIMPLIFIED];
    let hair = [Tag::STRANDS, Tag::HAIR, Tag::FIBRES, Tag::MEDULLAE];
    let mut sections = copied_sections(package, |tag| !look.contains(&tag) && !hair.contains(&tag))?;
    if let Some(mesh) = package.mesh()?.filter(|_| recipe.detail.has_lists()) {
        let lists = simplified(&mesh.to_data(), &manifest, package.animation()?.as_deref());
        let after = sections.iter().position(|s| matches!(s, Content::Bytes(Tag::MESH, _))).map_or(0, |at| at + 1);
        sections.splice(after..after, lists);
    }
    Ok(ModelPart { manifest, sections, images, ..ModelPart::default() })
}

/// Returns the textures of the ink style. They are painted again if the format in `recipe` differs from that of the
/// package; otherwise, they are copied. Textures that need a scan are always copied, because the package does not
/// contain the scan.
fn ink_files<'a>(
    file: &str,
    package: &Package<'a>,
    info: &InkInfo,
    recipe: &Recipe,
    strands: &Strands,
) -> Result<InkFiles<'a>, BakeError> {
    let own = Recipe::parse_recorded(file, &package.manifest().recipe)?;
    let format = |recipe: &Recipe| (recipe.pack.shell_format, recipe.pack.bc_quality);
    let scanned = own.ink.stroke_image.is_some() || own.ink.wash_image.is_some();
    if !scanned && format(&own) != format(recipe) {
        let strands = info.fur_texture.and(Some(strands));
        return ink::textures(&own.ink, &recipe.pack, &MapImages::default(), strands, StageProgress::ignored());
    }
    let keep = |index| copied_texture(package, index).map_err(|source| fault(file, source));
    Ok(InkFiles {
        stroke: keep(info.stroke_texture)?,
        wash: keep(info.wash_texture)?,
        paper: keep(info.paper_texture)?,
        fur: info.fur_texture.map(keep).transpose()?,
    })
}

fn fault(file: &str, source: FormatError) -> BakeError {
    BakeError::Package { file: file.to_owned(), source }
}

/// Slices a package with the tables `[slice]`, `[strands]`, `[fins]`, `[detail]` and `[pack]` of `recipe`. Its other
/// tables should be those of the package. A package without fins gets none, because the edges are known only from the
/// model.
///
/// Fails with the errors of [`tile_hair`]; [`BakeError::Params`] for values out of range, [`BakeError::Input`] for a
/// package without fur.
pub fn reslice(file: &str, package: &Package<'_>, recipe: &Recipe) -> Result<Vec<u8>, BakeError> {
    recipe.validate()?;
    let fault = |source| fault(file, source);
    let manifest: &Manifest = package.manifest();
    let Some(hair) = tile_hair(file, manifest)? else {
        let reason = "there is none, expected a package with hair to slice".into();
        return Err(BakeError::Input { file: file.into(), place: "the manifest's fur".into(), reason });
    };
    // Fins are checked here and then copied unchanged.
    let fins = match package.fins().map_err(fault)? {
        Some(_) => copied_sections(package, |tag| tag == Tag::FINS).map_err(fault)?.pop(),
        None => None,
    };
    // Ink data depends on mesh and strands, which do not change. Only the format of its textures may change.
    let (mut ink, mut ink_textures) = (None, None);
    if let Some(view) = package.ink().map_err(fault)? {
        ink_textures = Some(ink_files(file, package, &view.info, recipe, &hair.strands)?);
        ink = Some(VertexInk {
            grain_size_m: view.info.grain_size_m,
            shading: view.info.shading,
            vertices: view.vertices().collect(),
            center: None,
            warnings: Vec::new(),
        });
    }
    let contours = package.contours().map_err(fault)?.map(|view| Arc::new(view.to_data()));
    // The motion of guided hair is not needed here, because its section is copied.
    let guided = GuidedHair { groups: package.hair_groups().map_err(fault)?.to_vec(), ..GuidedHair::default() };
    let mut outputs = Outputs {
        hair: hair.into(),
        guided: guided.into(),
        fins: ModelFins { section: fins, depth: None }.into(),
        ink: ink.into(),
        painting: package.stroke_pool().map_err(fault)?.into(),
        ink_textures: ink_textures.into(),
        contours: contours.into(),
        skin: skin(package, recipe).map_err(fault)?.into(),
        ..Outputs::default()
    };
    let images = MapImages::default();
    let input = BakeInput::new(file, &manifest.model, recipe, &images);
    run(&input, &mut outputs, &mut |_| ())?;
    finished(outputs)
}

fn finished(mut outputs: Outputs<'_>) -> Result<Vec<u8>, BakeError> {
    let packed = outputs.package.take().map(|packed| packed.bytes);
    packed.ok_or_else(|| BakeError::Internal("the pipeline ended without a package".into()))
}

/// Model that is baked once and sliced many times. Outputs that do not depend on layers, tile and fins are made once:
/// parameterization, strands, groom, positions of fins, ink and mesh.
#[derive(Clone, Debug)]
pub struct Slicer<'a> {
    input: BakeInput<'a>,
    /// Outputs of the steps before slicing.
    outputs: Outputs<'a>,
}

impl<'a> Slicer<'a> {
    /// Bakes the model like [`crate::pipeline::bake`], and keeps the outputs that slicing does not change.
    ///
    /// Fails with the errors of [`crate::pipeline::bake`].
    pub fn new(input: BakeInput<'a>, model: &'a Model) -> Result<Self, BakeError> {
        let mut outputs = Outputs::of_model(model);
        run(&input, &mut outputs, &mut |_| ())?;
        outputs.invalidate(Output::Shells);
        outputs.invalidate(Output::FinTextures);
        Ok(Self { input, outputs })
    }

    /// Returns a package identical, byte for byte, to that of a full bake with `recipe`. Outputs are reused only if
    /// `recipe` differs from the slicer's own in nothing but `[slice]` and `[fins]`. Other differences cause a full
    /// bake.
    ///
    /// Fails with the errors of [`crate::pipeline::bake`].
    pub fn slice(&self, recipe: &Recipe) -> Result<Vec<u8>, BakeError> {
        let own = self.input.recipe;
        let sliced = Recipe { slice: recipe.slice.clone(), fins: recipe.fins.clone(), ..own.clone() };
        let mut outputs = if sliced == *recipe {
            self.outputs.clone().shortened()
        } else {
            Outputs { model: self.outputs.model.clone(), ..Outputs::default() }.shortened()
        };
        run(&BakeInput { recipe, ..self.input }, &mut outputs, &mut |_| ())?;
        finished(outputs)
    }
}
