//! Recipes: all parameters of a bake, as TOML.
//!
//! A recipe has one table per stage and one key per parameter. Both are declared only here. From the declarations,
//! [`pelage_params`] derives the structs, defaults, checks, parser, writer, `--set key=value` and reference page. Keys
//! that a recipe leaves out keep their defaults.
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
mod maps;
mod material_groom;
mod named_table;
mod params;
mod shading;
mod style;

pub use coats::Coat;
pub use comb_marks::CombMarkParams;
pub use fibre::{FibreKind, FibreParams, OtherFibre};
pub use hair_group::{HairColliderParams, HairGroupParams, TuftParams};
pub use ink::{InkFill, InkParams, MaterialInk};
pub use joint_groom::JointGroom;
pub use maps::{Channel, ColorMap, FilePath, ScalarMap, VectorMap};
pub use material_groom::{MaterialGloss, MaterialGroom};
pub use named_table::NamedTable;
pub use params::{
    BaseColorFormat, BcQuality, ColorParams, CombSource, DetailParams, DirectionFormat, FinParams, GroomCoordinates,
    GroomParams, HairColors, HairParams, JudgeParams, ModelParams, PackParams, PatternProjection, PatternWrap,
    ShellFormat, SliceParams, StrandParams, SurfaceParams, SurfaceSource, UnderfurParams, VisibilityParams,
};
pub use pelage_params::SrgbColor;
pub use shading::{ShadingModel, ShadingParams};
pub use style::Style;

use pelage_import::BakeError;
use pelage_params::{Knob, ParamError};

pelage_params::tables! {
    /// Parameters of a bake: one table per stage. `Recipe::default()` is the coat `animal`.
    pub struct Recipe, such as "hair.length_m=0.02" {
        /// Import of the model.
        model: ModelParams,
        /// Layout of the hair tile on the model.
        surface: SurfaceParams,
        /// Strands of the tile.
        hair: HairParams,
        /// Second layer of shorter hair below the strands of `hair`.
        underfur: UnderfurParams,
        /// Values that vary over the model.
        groom: GroomParams,
        /// Colours of the strands.
        color: ColorParams,
        /// Shading of the hair.
        shading: ShadingParams,
        /// Optical properties of the hair's fibres.
        fibre: FibreParams,
        /// Shell textures.
        slice: SliceParams,
        /// Light that reaches the hair.
        visibility: VisibilityParams,
        /// Single strands and guided hair.
        strands: StrandParams,
        /// Fins.
        fins: FinParams,
        /// Levels of detail.
        detail: DetailParams,
        /// Ink-wash style.
        ink: InkParams,
        /// Texture formats of the package.
        pack: PackParams,
        /// Images that measure the error of a bake with limits.
        judge: JudgeParams,
    }
}

/// Returns every key of a recipe, in order.
pub fn keys() -> impl Iterator<Item = &'static Knob> {
    pelage_params::knobs::<Recipe>()
}

/// Returns each path once, with the first key that names it.
fn each_once<'a>(named: impl IntoIterator<Item = (String, Option<&'a str>)>) -> Vec<(String, &'a str)> {
    let mut paths: Vec<(String, &str)> = Vec::new();
    for (key, path) in named {
        if let Some(path) = path.filter(|path| paths.iter().all(|(_, known)| known != path)) {
            paths.push((key, path));
        }
    }
    paths
}

/// Converts an error in a recipe. An error without a line comes from the command line.
fn input(file: &str, fault: ParamError) -> BakeError {
    BakeError::Input { file: file.to_owned(), place: fault.location(), reason: fault.reason }
}

impl DetailParams {
    /// Whether a package has simplified index lists.
    pub fn has_lists(&self) -> bool {
        self.enabled && self.simplified
    }
}

impl Recipe {
    /// Parses a recipe; `file` is its name for messages.
    ///
    /// Fails with [`BakeError::Input`] with line and key for invalid TOML, an unknown table or key, a wrong type or a
    /// value outside its range.
    pub fn parse(file: &str, text: &str) -> Result<Self, BakeError> {
        let mut recipe = Self::default();
        recipe.merge(file, text)?;
        Ok(recipe)
    }

    /// Parses the recipe recorded in a package; `file` is its name for messages. Packages written before coats existed
    /// may omit keys. Such keys get the values of [`Coat::Natural`] and the shading model `kajiya-kay`, which were the
    /// defaults then.
    ///
    /// Fails with the errors of [`Recipe::parse`].
    pub fn parse_recorded(file: &str, text: &str) -> Result<Self, BakeError> {
        let mut recipe = Self::of_coat(Coat::Natural)?;
        recipe.shading.model = ShadingModel::KajiyaKay;
        recipe.merge(file, text)?;
        Ok(recipe)
    }

    /// Returns the recipe that names a coat and sets nothing else.
    ///
    /// Fails with [`BakeError::Internal`] if the coat's file is invalid.
    pub fn of_coat(coat: Coat) -> Result<Self, BakeError> {
        let mut recipe = Self::default();
        recipe.set(&format!("hair.coat={}", coat.word()))?;
        Ok(recipe)
    }

    /// Reads a recipe over this one, in the format of [`Recipe::parse`]. Keys in the text are set, all others keep
    /// their values. If the text changes the coat, keys that it does not name also change, if they have the previous
    /// coat's value.
    ///
    /// Fails with the errors of [`Recipe::parse`]; keys before the error are already set.
    pub fn merge(&mut self, file: &str, text: &str) -> Result<(), BakeError> {
        self.change_with_coat(file, |recipe| pelage_params::read(recipe, text))
    }

    /// Sets one value, as in `--set hair.length_m=0.02`. Strings need no quotes: `hair.style=curly`. Setting
    /// `hair.coat=winter` also changes the keys that have the previous coat's value.
    ///
    /// Fails with the errors of [`Recipe::parse`], with `--set` as the file; the recipe is then unchanged.
    pub fn set(&mut self, assignment: &str) -> Result<(), BakeError> {
        self.change_with_coat("--set", |recipe| pelage_params::set(recipe, assignment))
    }

    /// Applies a change. If it changes the coat, keys with the previous coat's value get that of the new coat, unless
    /// the change sets them.
    fn change_with_coat(
        &mut self,
        file: &str,
        change: impl Fn(&mut Self) -> Result<(), ParamError>,
    ) -> Result<(), BakeError> {
        let before = self.hair.coat;
        change(self).map_err(|fault| input(file, fault))?;
        self.shading.settle();
        let coat = self.hair.coat;
        if coat == before {
            return Ok(());
        }
        coats::change(self, before, coat)
            .map_err(|fault| BakeError::Internal(format!("the coat {:?}: {fault}", coat.word())))?;
        // Apply the change again: a key that it sets may have had the previous coat's value.
        change(self).map_err(|fault| input(file, fault))?;
        self.shading.settle();
        Ok(())
    }

    /// Returns the recipe as TOML, with every key that has a value, in the order of [`keys`]. Parsing it gives an equal
    /// recipe.
    pub fn to_toml(&self) -> String {
        pelage_params::to_toml(self)
    }

    /// Returns [`Recipe::to_toml`] with each key's meaning, type and range as comments, and keys without a value
    /// commented out.
    pub fn to_documented_toml(&self) -> String {
        pelage_params::to_documented_toml(self)
    }

    /// Returns [`Recipe::to_documented_toml`] with the lines of `note` as further comments above each key.
    pub fn to_noted_toml(&self, note: impl Fn(&Knob) -> Vec<String>) -> String {
        pelage_params::to_noted_toml(self, note)
    }

    /// Returns the paths of images that the recipe names, each once, with the first key that names it.
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

    /// Returns the paths of strand files that the recipe names, each once, with the first key that names it.
    pub fn strand_files(&self) -> Vec<(String, &str)> {
        fn path((i, group): (usize, &HairGroupParams)) -> (String, Option<&str>) {
            (format!("strands.group, table {i}, file"), group.file.as_ref().map(|path| path.0.as_str()))
        }
        each_once(self.strands.group.iter().enumerate().map(path))
    }

    /// Returns the number of strands in the tile: guard hair and underfur.
    pub fn strands_in_tile(&self) -> u32 {
        self.hair.density + self.underfur.density
    }

    /// Checks every value against its range.
    ///
    /// Fails with [`BakeError::Params`] with the key, what was found and what was expected.
    pub fn validate(&self) -> Result<(), BakeError> {
        Ok(pelage_params::validate(self)?)
    }
}

/// Returns the recipe of the coat `natural` with the shading model `kajiya-kay`, for tests. Its strands are few, thick
/// and of one kind, and no table is computed for their fibres.
#[doc(hidden)]
pub fn natural() -> Recipe {
    let mut recipe = Recipe::of_coat(Coat::Natural).unwrap_or_else(|error| panic!("{error}"));
    recipe.shading.model = ShadingModel::KajiyaKay;
    recipe
}

#[cfg(test)]
mod tests;
