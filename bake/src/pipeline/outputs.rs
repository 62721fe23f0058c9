//! Outputs of the steps, and results cached between runs.

use super::layout::Layout;
use crate::decision::Decision;
use crate::memo::Memo;
use crate::recipe::{InkParams, PackParams};
use crate::stages::groom::{Colors, GroomTextures, VertexGroom};
use crate::stages::hair_groups::GuidedHair;
use crate::stages::ink::{InkFiles, PaintedTextures, VertexInk};
use crate::stages::pack::{ModelFins, ModelMemo, ModelPart};
use crate::stages::scatter::FibreTables;
use crate::stages::simulate::TileHair;
use crate::stages::slice::{self, FinTextures, ShellTextures};
use crate::stages::surface::Surface;
use crate::stages::visibility::Visibility;
use pelage_formats::{ContourMesh, RootsInfo, StrandsData, StrokePool};
use pelage_import::BakeError;
use pelage_import::mesh::Model;
use std::sync::{Arc, OnceLock};

/// Declares the outputs of the steps: a field of [`Outputs`] and its name in [`Output`].
macro_rules! outputs {
    ($($(#[doc = $doc:literal])+ $name:ident $field:ident: $type:ty,)+) => {
        /// Name of a step's output.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Output {
            $($(#[doc = $doc])+ $name,)+
        }

        /// Outputs made so far; empty if not made yet.
        #[derive(Clone, Debug, Default)]
        pub struct Outputs<'a> {
            $($(#[doc = $doc])+ pub $field: OnceLock<$type>,)+
            /// Results cached between runs, for steps whose inputs may stay the same.
            pub kept: CachedStages,
        }

        impl Output {
            /// All outputs, in the order in which they are made.
            pub const ALL: &'static [Self] = &[$(Self::$name),+];
        }

        impl<'a> Outputs<'a> {
            /// Returns the outputs before a bake of `model`.
            pub fn of_model(model: &'a Model) -> Self {
                Self { model: model.into(), ..Self::default() }
            }

            /// Returns the same outputs, for use with data that live shorter, such as another recipe. For cells, the
            /// compiler cannot do this by itself.
            pub fn shortened<'b>(self) -> Outputs<'b>
            where
                'a: 'b,
            {
                let Self { $($field,)+ kept } = self;
                Outputs { $($field: $field.into_inner().map(OnceLock::from).unwrap_or_default(),)+ kept }
            }

            /// Whether the output exists.
            pub fn has(&self, output: Output) -> bool {
                match output {
                    $(Output::$name => self.$field.get().is_some(),)+
                }
            }

            /// Drops the output, but nothing derived from it.
            pub fn clear(&mut self, output: Output) {
                match output {
                    $(Output::$name => drop(self.$field.take()),)+
                }
            }
        }
    };
}

outputs! {
    /// Imported model, an input that no step makes.
    Model model: &'a Model,
    /// Model with the hair tile laid out on it.
    Layout laid: Layout<'a>,
    /// Strands of the tile.
    Hair hair: TileHair,
    /// Light that reaches the strands; `None` if the package is not to store it.
    StrandVisibility visible: Option<StrandVisibility>,
    /// Strands sliced into layers.
    Shells shells: Shells,
    /// Strands in the package's format; `None` if the package is to have no strands.
    Single single: Option<StrandsData>,
    /// Groomed model: the laid-out model with the groom values that vary over it.
    Groomed groomed: Arc<Groomed>,
    /// Guided hair, with its warnings.
    Guided guided: GuidedHair,
    /// Positions of the fins.
    Fins fins: ModelFins<'a>,
    /// Textures of the fins; `None` if the package is to have no fins.
    FinTextures fin_textures: Option<FinTextures>,
    /// Per-vertex data of the ink style; `None` without the style.
    Ink ink: Option<VertexInk>,
    /// Strokes with which the model is painted; `None` without the ink style.
    Painting painting: Option<Arc<StrokePool>>,
    /// Textures of the ink style; `None` without the style.
    InkTextures ink_textures: Option<InkFiles<'a>>,
    /// Contour mesh of the ink style; `None` without the style.
    Contours contours: Option<Arc<ContourMesh>>,
    /// Mesh with its textures in the package's formats.
    Skin skin: ModelPart<'a>,
    /// Scattering of light by the hair's fibres; `None` if the shading model does not use it.
    Fibres fibres: Option<FibreTables>,
    /// Package.
    Package package: PackageBytes,
}

/// Expensive intermediate results that often stay the same when the hair changes.
#[derive(Clone, Debug, Default)]
pub struct CachedStages {
    /// Textures of the ink style except those of the fur.
    pub(super) painting: Memo<(InkParams, PackParams), PaintedTextures>,
    /// Textures of the mesh surface.
    pub(super) skin: Memo<SkinImages, Arc<SkinFiles>>,
    /// Simplified index lists and openness of the mesh.
    pub(super) of_skin: ModelMemo,
}

/// Images of the mesh surface and their encoding.
#[derive(Clone, Debug)]
pub(super) struct SkinImages {
    pub(super) groomed: Arc<Groomed>,
    pub(super) pack: PackParams,
}

impl PartialEq for SkinImages {
    fn eq(&self, other: &Self) -> bool {
        let (this, that) = (&self.groomed, &other.groomed);
        self.pack == other.pack && this.colors.images == that.colors.images && this.grooms.images == that.grooms.images
    }
}

/// Images of [`SkinImages`], encoded as .ktx2 files.
#[derive(Clone, Debug)]
pub(super) struct SkinFiles {
    pub(super) base_colors: Vec<Vec<u8>>,
    pub(super) grooms: Vec<Vec<u8>>,
}

impl SkinFiles {
    pub(super) fn encode(SkinImages { groomed, pack }: &SkinImages) -> Result<Arc<Self>, BakeError> {
        let (colors, grooms) = (&groomed.colors.images, &groomed.grooms.images);
        Ok(Arc::new(Self {
            base_colors: colors.iter().map(|image| slice::encode_base_color(image, pack)).collect::<Result<_, _>>()?,
            grooms: grooms.iter().map(|image| slice::encode_groom(image, pack)).collect::<Result<_, _>>()?,
        }))
    }
}

/// Light that reaches the strands.
#[derive(Clone, Debug)]
pub struct StrandVisibility {
    /// Dry strands.
    pub dry: Visibility,
    /// Wet strands, if dry and wet hair mix.
    pub wet: Option<Visibility>,
}

/// Shell textures.
#[derive(Clone, Debug)]
pub struct Shells {
    /// Textures of the strands.
    pub dry: ShellTextures,
    /// Textures of the same strands when wet, if dry and wet hair mix.
    pub wet: Option<ShellTextures>,
}

/// Output of the `groom` stage.
#[derive(Clone, Debug)]
pub struct Groomed {
    /// Laid-out surface. With a pattern, it is cut along the borders of the pattern's charts.
    pub surface: Surface,
    /// Groom values at the vertices of the surface.
    pub coat: VertexGroom,
    /// Colours of the surface's materials and vertices.
    pub colors: Colors,
    /// Groom textures.
    pub grooms: GroomTextures,
    /// Width of the pattern, metres, if there is one.
    pub pattern_size_m: Option<f32>,
    /// Lookup of the colour at a hair's root, if it may differ from the colour below the hair.
    pub roots: Option<RootsInfo>,
    /// Distance from bare materials at which hair reaches its full length, metres; `None` if no hair is near such a
    /// material.
    pub bare_margin_m: Option<f32>,
    /// Values that the recipe left open and the bake chose.
    pub decisions: Vec<Decision>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Result of the `pack` stage.
#[derive(Clone, Debug)]
pub struct PackageBytes {
    /// Contents of the package.
    pub bytes: Vec<u8>,
    /// Warnings of all stages.
    pub warnings: Vec<String>,
}

fn missing(what: Output) -> BakeError {
    BakeError::Internal(format!("{what:?} is missing, expected an earlier step to make it"))
}

/// Returns an output of an earlier step.
pub(super) fn required<T>(output: &OnceLock<T>, what: Output) -> Result<&T, BakeError> {
    output.get().ok_or_else(|| missing(what))
}

/// Stores an output.
pub(super) fn store<T>(output: &OnceLock<T>, what: Output, value: T) -> Result<(), BakeError> {
    let twice = |_| BakeError::Internal(format!("{what:?} is made twice, expected one step to make it"));
    output.set(value).map_err(twice)
}
