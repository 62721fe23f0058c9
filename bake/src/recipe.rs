//! Recipes: everything that steers a bake, as TOML.
//!
//! A recipe has one table per stage and one key per parameter, which are declared here and nowhere else: [`pelage_params`] makes of the
//! declarations the structs, their defaults and checks, reading, writing, `--set key=value` and the reference page. What a recipe leaves
//! out keeps its default.
//!
//! ```
//! use pelage_bake::recipe::{Recipe, Style};
//! let mut recipe = Recipe::parse("fox.toml", "[hair]\nstyle = \"curly\"\nlength_m = 0.03\n")?;
//! recipe.set("hair.density=900")?;
//! assert_eq!((recipe.hair.style, recipe.hair.density), (Style::Curly, 900));
//! let error = Recipe::parse("fox.toml", "[hair]\ndensty = 900\n").unwrap_err().to_string();
//! assert!(error.contains("line 2") && error.contains("hair.density"), "{error}");
//! # Ok::<(), pelage_import::BakeError>(())
//! ```

mod coats;
mod comb_marks;
mod fibre;
mod hair_group;
mod ink;
mod joint_groom;
mod key_pictures;
mod maps;
mod material_groom;
mod named_table;
mod params;
mod style;

pub use coats::{Coat, coats_page};
pub use comb_marks::CombMarkParams;
pub use fibre::{FibreParams, OtherFibre};
pub use hair_group::{HairColliderParams, HairGroupParams, TuftParams};
pub use ink::{InkFill, InkParams, MaterialInk};
pub use joint_groom::JointGroom;
pub use key_pictures::{KEY_PICTURES, KeyPicture};
pub use maps::{Channel, ColorMap, FilePath, ScalarMap, VectorMap};
pub use material_groom::MaterialGroom;
pub use named_table::NamedTable;
pub use params::{
    BaseColorFormat, BcQuality, ColorParams, CombSource, DetailParams, DirectionFormat, FinParams, GroomCoordinates,
    GroomParams, HairColors, HairParams, JudgeParams, ModelParams, PackParams, PatternProjection, PatternWrap,
    ShadingModel, ShadingParams, ShellFormat, SliceParams, StrandParams, SurfaceParams, SurfaceSource, UnderfurParams,
    VisibilityParams,
};
pub use pelage_params::SrgbColor;
pub use style::Style;

use pelage_import::BakeError;
use pelage_params::{Knob, ParamError};

pelage_params::tables! {
    /// What steers a bake: one table per stage. `Recipe::default()` is the coat of an animal.
    pub struct Recipe, such as "hair.length_m=0.02" {
        /// How the model is read.
        model: ModelParams,
        /// How the tile of hair lies on the model.
        surface: SurfaceParams,
        /// The strands.
        hair: HairParams,
        /// A second, shorter coat below them.
        underfur: UnderfurParams,
        /// What varies over the model.
        groom: GroomParams,
        /// The strands' colour.
        color: ColorParams,
        /// How hair is lit.
        shading: ShadingParams,
        /// The fibres that it is made of.
        fibre: FibreParams,
        /// The shell textures.
        slice: SliceParams,
        /// How much light reaches the hair.
        visibility: VisibilityParams,
        /// The strands one by one.
        strands: StrandParams,
        /// The fins.
        fins: FinParams,
        /// The levels of detail.
        detail: DetailParams,
        /// The model as an ink-wash painting.
        ink: InkParams,
        /// Texture formats of the package.
        pack: PackParams,
        /// The pictures that a bake with limits is judged by.
        judge: JudgeParams,
    }
}

/// Every key of a recipe in order.
pub fn keys() -> impl Iterator<Item = &'static Knob> {
    pelage_params::knobs::<Recipe>()
}

/// Every key of a recipe as a page of Markdown: meaning, default, type and range, and a picture of those in [`KEY_PICTURES`].
pub fn reference_page() -> String {
    pelage_params::reference_page::<Recipe>("Recipe reference", &INTRODUCTION, |key| {
        KEY_PICTURES.iter().find(|picture| picture.key == key).map(KeyPicture::markdown)
    })
}

const INTRODUCTION: [&str; 4] = [
    "A recipe is a TOML file that says how a model becomes fur: `pelage bake fox.glb --recipe fox.toml -o fox.pelage`. It has a table for each \
     stage of the bake and a key for each parameter. What it leaves out keeps its default, so that an empty recipe is the coat of an animal; \
     `hair.coat` begins with another kind ([coats](coats.md)). \
     `--set hair.length_m=0.02` sets one key on the command line, after the recipe. A table or key that does not exist is an error, which names \
     the line and the nearest key that does.",
    "Lengths end in `_m` and are metres, angles end in `_deg`, widths on screen in `_px`. Where a default is \"left out\", the bake chooses the \
     value from the model. `pelage unpack` writes down the recipe that a package was baked with.",
    "The pictures show the hare of `assets/models`, which has no recipe, with three values of one key.",
    "This page is made from the declarations in `bake/src/recipe/` by `cargo run --bin chores write-docs`.",
];

/// The paths among those that keys may name, each once with the key that names it first.
fn each_once<'a>(named: impl IntoIterator<Item = (String, Option<&'a str>)>) -> Vec<(String, &'a str)> {
    let mut paths: Vec<(String, &str)> = Vec::new();
    for (key, path) in named {
        if let Some(path) = path.filter(|path| paths.iter().all(|(_, known)| known != path)) {
            paths.push((key, path));
        }
    }
    paths
}

/// A fault of a recipe, in a file or, where it has no line, on the command line.
fn input(file: &str, fault: ParamError) -> BakeError {
    BakeError::Input { file: file.to_owned(), place: fault.place(), reason: fault.reason }
}

impl DetailParams {
    /// Whether a package has index lists of fewer triangles.
    pub fn has_lists(&self) -> bool {
        self.enabled && self.simplified
    }
}

impl Recipe {
    /// Reads a recipe; `file` is its name for messages.
    ///
    /// # Errors
    /// [`BakeError::Input`] with the line and the key for broken TOML, an unknown table or key, a wrong type or a value outside
    /// its range.
    pub fn parse(file: &str, text: &str) -> Result<Self, BakeError> {
        let mut recipe = Self::default();
        recipe.read(file, text)?;
        Ok(recipe)
    }

    /// Reads the recipe that a package records; `file` is its name for messages. Packages of before there were coats leave keys out whose defaults were
    /// those of [`Coat::Natural`].
    ///
    /// # Errors
    /// As [`Recipe::parse`].
    pub fn recorded(file: &str, text: &str) -> Result<Self, BakeError> {
        let mut recipe = Self::of_coat(Coat::Natural)?;
        recipe.read(file, text)?;
        Ok(recipe)
    }

    /// What a recipe is that says no more than its coat.
    ///
    /// # Errors
    /// [`BakeError::Internal`] where the coat's file is broken.
    pub fn of_coat(coat: Coat) -> Result<Self, BakeError> {
        let mut recipe = Self::default();
        recipe.set(&format!("hair.coat={}", coat.word()))?;
        Ok(recipe)
    }

    /// Reads more of a recipe over this one, as [`Recipe::parse`] reads a whole one: what the text names is set, everything else stays. A text that
    /// names a coat changes the keys that have the value of the coat before, but for those that it names.
    ///
    /// # Errors
    /// As [`Recipe::parse`]; what stood before the fault is set then.
    pub fn read(&mut self, file: &str, text: &str) -> Result<(), BakeError> {
        self.dressed(file, |recipe| pelage_params::read(recipe, text))
    }

    /// Sets one value, as in `--set hair.length_m=0.02`. Strings need no quotes: `hair.style=curly`. `hair.coat=winter` changes the keys that have the
    /// value of the coat before, and no other.
    ///
    /// # Errors
    /// As [`Recipe::parse`], with `--set` for the file; nothing is changed then.
    pub fn set(&mut self, assignment: &str) -> Result<(), BakeError> {
        self.dressed("--set", |recipe| pelage_params::set(recipe, assignment))
    }

    /// Makes a change, after which keys that nobody named are those of its coat.
    fn dressed(&mut self, file: &str, change: impl Fn(&mut Self) -> Result<(), ParamError>) -> Result<(), BakeError> {
        let before = self.hair.coat;
        change(self).map_err(|fault| input(file, fault))?;
        let coat = self.hair.coat;
        if coat == before {
            return Ok(());
        }
        coats::change(self, before, coat)
            .map_err(|fault| BakeError::Internal(format!("the coat {:?}: {fault}", coat.word())))?;
        // Once more: a key that was named may have had the value of the coat before.
        change(self).map_err(|fault| input(file, fault))
    }

    /// The recipe as TOML with every key that has a value, in the order of [`keys`]. Parsing it gives an equal recipe.
    pub fn to_toml(&self) -> String {
        pelage_params::to_toml(self)
    }

    /// As [`Recipe::to_toml`], with each key's meaning, type and range as comments, and keys without a value commented out.
    pub fn to_documented_toml(&self) -> String {
        pelage_params::to_documented_toml(self)
    }

    /// As [`Recipe::to_documented_toml`], with what `note` has to say of a key as further comments right above it.
    pub fn to_noted_toml(&self, note: impl Fn(&Knob) -> Vec<String>) -> String {
        pelage_params::to_noted_toml(self, note)
    }

    /// The images that it names, each path once with the key that names it first.
    pub fn images(&self) -> Vec<(String, &str)> {
        let g = &self.groom;
        let scalars = [
            ("length", &g.length),
            ("density", &g.density),
            ("lean", &g.lean),
            ("wetness", &g.wetness),
            ("bare", &g.bare),
        ];
        let mut named: Vec<(String, Option<&str>)> =
            scalars.iter().map(|(key, map)| (format!("groom.{key}"), map.image())).collect();
        named.push(("groom.comb".into(), g.comb.as_ref().and_then(VectorMap::image)));
        named.push(("groom.color".into(), g.color.as_ref().and_then(ColorMap::image)));
        for (i, m) in g.material.iter().enumerate() {
            let scalars = [
                ("length", &m.length),
                ("density", &m.density),
                ("lean", &m.lean),
                ("wetness", &m.wetness),
                ("bare", &m.bare),
            ];
            let key = |key: &str| format!("groom.material, table {i}, {key}");
            named.extend(scalars.iter().map(|(k, map)| (key(k), map.as_ref().and_then(ScalarMap::image))));
            named.push((key("comb"), m.comb.as_ref().and_then(VectorMap::image)));
            named.push((key("color"), m.color.as_ref().and_then(ColorMap::image)));
        }
        named.push(("color.pattern".into(), self.color.pattern.as_ref().map(|path| path.0.as_str())));
        let ink = &self.ink;
        for (key, map) in [("wash", &ink.wash), ("solid", &ink.solid), ("lines", &ink.lines)] {
            named.push((format!("ink.{key}"), map.image()));
        }
        for (i, m) in ink.material.iter().enumerate() {
            for (key, map) in [("amount", &m.amount), ("line", &m.line)] {
                named.push((format!("ink.material, table {i}, {key}"), map.as_ref().and_then(ScalarMap::image)));
            }
        }
        for (key, path) in [("stroke_image", &ink.stroke_image), ("wash_image", &ink.wash_image)] {
            named.push((format!("ink.{key}"), path.as_ref().map(|path| path.0.as_str())));
        }
        for (i, group) in self.strands.group.iter().enumerate() {
            for (key, map) in [("mask", &group.mask), ("freedom", &group.freedom)] {
                named.push((format!("strands.group, table {i}, {key}"), map.as_ref().and_then(ScalarMap::image)));
            }
        }
        each_once(named)
    }

    /// The files of strands that it names, each path once with the key that names it first.
    pub fn strand_files(&self) -> Vec<(String, &str)> {
        fn path((i, group): (usize, &HairGroupParams)) -> (String, Option<&str>) {
            (format!("strands.group, table {i}, file"), group.file.as_ref().map(|path| path.0.as_str()))
        }
        each_once(self.strands.group.iter().enumerate().map(path))
    }

    /// Strands in the tile: guard hair and underfur.
    pub fn strands_in_tile(&self) -> u32 {
        self.hair.density + self.underfur.density
    }

    /// Checks every value against its range.
    ///
    /// # Errors
    /// [`BakeError::Params`] naming the key, what was found and what was expected.
    pub fn validate(&self) -> Result<(), BakeError> {
        Ok(pelage_params::validate(self)?)
    }
}

/// The coat `natural`, for tests: one kind of strands, few and thick.
#[doc(hidden)]
pub fn natural() -> Recipe {
    Recipe::of_coat(Coat::Natural).unwrap_or_else(|error| panic!("{error}"))
}

#[cfg(test)]
mod tests;
