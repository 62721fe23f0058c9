//! What the steps are told, what they make, and what they keep over being run again.

use super::lay::Laid;
use crate::decision::Decision;
use crate::recipe::{InkParams, PackParams, Recipe};
use crate::remade::Remade;
use crate::stages::groom::{Coat, Colors, GroomTextures, MapImages};
use crate::stages::hair::TileHair;
use crate::stages::hair_groups::GuidedHair;
use crate::stages::ink::{InkFiles, Painting, SkinInk};
use crate::stages::pack::{KeptOfSkin, Skin, SkinFins};
use crate::stages::scatter::FibreTables;
use crate::stages::surface::Surface;
use crate::stages::textures::{self, FinTextures, ShellTextures};
use crate::stages::visibility::Visibility;
use crate::steps::Steps;
use pelage_formats::{RootsInfo, StrandsData};
use pelage_import::BakeError;
use pelage_import::mesh::{Image, Model};
use std::sync::Arc;

/// What a bake is told: the same for all its steps.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// The model, or the package, as the user named it, for messages.
    pub file: &'a str,
    /// Its name in the package.
    pub name: &'a str,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// The images that the recipe names.
    pub images: &'a MapImages,
    /// Where long stages count their steps.
    pub steps: &'a Steps,
}

impl<'a> Told<'a> {
    /// What nobody waits for. Arguments as the fields.
    pub fn new(file: &'a str, name: &'a str, recipe: &'a Recipe, images: &'a MapImages) -> Self {
        Self { file, name, recipe, images, steps: Steps::unseen() }
    }
}

/// Declares what is kept of the steps: a field of [`Outputs`] and its name in [`Output`].
macro_rules! outputs {
    ($($(#[doc = $doc:literal])+ $name:ident $field:ident: $type:ty,)+) => {
        /// The name of something that a step makes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Output {
            $($(#[doc = $doc])+ $name,)+
        }

        /// What the steps have made so far; `None` is not made yet.
        #[derive(Clone, Debug, Default)]
        pub struct Outputs<'a> {
            $($(#[doc = $doc])+ pub $field: Option<$type>,)+
            /// What steps keep over their being run again, where what decides about it may stay the same.
            pub kept: Kept,
        }

        impl Output {
            /// All of them, in the order in which they are made.
            pub const ALL: &'static [Self] = &[$(Self::$name),+];
        }

        impl Outputs<'_> {
            /// Whether it is there.
            pub fn has(&self, output: Output) -> bool {
                match output {
                    $(Output::$name => self.$field.is_some(),)+
                }
            }

            /// Drops it, and nothing that was made of it.
            pub fn clear(&mut self, output: Output) {
                match output {
                    $(Output::$name => self.$field = None,)+
                }
            }
        }
    };
}

outputs! {
    /// What `import` made: nothing here makes it.
    Model model: &'a Model,
    /// The model with the hair's tile laid on it.
    Laid laid: Laid<'a>,
    /// The strands of the tile.
    Hair hair: TileHair,
    /// How much light reaches the strands; none where the package is not to know.
    Visible visible: Option<Visible>,
    /// The strands in layers.
    Shells shells: Shells,
    /// The strands as the package has them; none where it is to have no strands.
    Single single: Option<StrandsData>,
    /// The laid model with what varies over it.
    Groomed groomed: Arc<Groomed>,
    /// Hair on guides, and what there was to say of it.
    Guided guided: GuidedHair,
    /// Where fins stand.
    Fins fins: SkinFins<'a>,
    /// What fins show; none where the package is to have no fins.
    FinTextures fin_textures: Option<FinTextures>,
    /// What vertices take of the ink style; none without the style.
    Ink ink: Option<SkinInk>,
    /// What the ink style is painted with; none without the style.
    InkTextures ink_textures: Option<InkFiles<'a>>,
    /// The skin, with its textures in the package's formats.
    Skin skin: Skin<'a>,
    /// How the hair's fibres scatter light; none where it is lit without.
    Fibres fibres: Option<FibreTables>,
    /// The package.
    Package package: Packed,
}

/// What is dear to make, and often made of the same although hair changed.
#[derive(Clone, Debug, Default)]
pub struct Kept {
    /// Textures of the ink style without its fur.
    pub(super) painting: Remade<(InkParams, PackParams), Painting>,
    /// Textures of the skin.
    pub(super) skin: Remade<SkinImages, Arc<SkinFiles>>,
    /// Lists of fewer triangles, and what the body leaves open.
    pub(super) of_skin: KeptOfSkin,
}

/// The images of a skin, and how they are encoded.
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

/// Those images as .ktx2 files.
#[derive(Clone, Debug)]
pub(super) struct SkinFiles {
    pub(super) base_colors: Vec<Vec<u8>>,
    pub(super) grooms: Vec<Vec<u8>>,
}

impl SkinFiles {
    pub(super) fn encode(SkinImages { groomed, pack }: &SkinImages) -> Result<Arc<Self>, BakeError> {
        let all = |images: &[Image], encode: fn(&Image, &PackParams) -> Result<Vec<u8>, BakeError>| {
            images.iter().map(|image| encode(image, pack)).collect::<Result<Vec<_>, _>>()
        };
        Ok(Arc::new(Self {
            base_colors: all(&groomed.colors.images, textures::encode_base_color)?,
            grooms: all(&groomed.grooms.images, textures::encode_groom)?,
        }))
    }
}

/// How much light reaches the strands.
#[derive(Clone, Debug)]
pub struct Visible {
    /// As they are dry.
    pub dry: Visibility,
    /// As they are wet, where dry and wet mix.
    pub wet: Option<Visibility>,
}

/// The shell textures.
#[derive(Clone, Debug)]
pub struct Shells {
    /// Of the strands.
    pub dry: ShellTextures,
    /// Of the same strands when wet, where dry and wet mix.
    pub wet: Option<ShellTextures>,
}

/// What the `groom` stage leaves behind.
#[derive(Clone, Debug)]
pub struct Groomed {
    /// The laid surface; where there is a pattern, cut along the borders of its charts.
    pub surface: Surface,
    /// What varies over its vertices.
    pub coat: Coat,
    /// Colours of its materials and vertices.
    pub colors: Colors,
    /// The groom textures.
    pub grooms: GroomTextures,
    /// Width of the pattern, metres, where there is one.
    pub pattern_size_m: Option<f32>,
    /// How hair finds the colour of its root, where that is another than the colour below it.
    pub roots: Option<RootsInfo>,
    /// How far from bare materials hair has its full length, metres; `None` where no hair is near one.
    pub bare_margin_m: Option<f32>,
    /// What the recipe left open and was chosen.
    pub decisions: Vec<Decision>,
    /// What there was to say.
    pub warnings: Vec<String>,
}

/// A finished package.
#[derive(Clone, Debug)]
pub struct Packed {
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// What all stages had to say.
    pub warnings: Vec<String>,
}

fn missing(what: Output) -> BakeError {
    BakeError::Internal(format!("{what:?} is not there, expected a step before to make it"))
}

/// What a step needs of the steps before it.
pub(super) fn made<T>(output: &Option<T>, what: Output) -> Result<&T, BakeError> {
    output.as_ref().ok_or_else(|| missing(what))
}
