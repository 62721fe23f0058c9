//! Models embedded in the binary, for trying pelage without any files.

use super::exit::Failure;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::import::{ImportOptions, import};
use pelage_import::BakeError;
use pelage_import::mesh::Model;

/// Embedded model and its recipe.
#[derive(Debug)]
pub struct BuiltIn {
    /// File name in the repository's `assets/`, without extension.
    pub name: &'static str,
    glb: &'static [u8],
    recipe: &'static str,
}

/// Hare, with a breathing animation.
pub const HARE: BuiltIn = BuiltIn {
    name: "hare",
    glb: include_bytes!("../built_in/hare.glb"),
    recipe: include_str!("../built_in/hare.toml"),
};

/// Torus.
pub const TORUS: BuiltIn = BuiltIn {
    name: "torus",
    glb: include_bytes!("../built_in/torus.glb"),
    recipe: include_str!("../built_in/torus.toml"),
};

impl BuiltIn {
    /// Returns the file name used in messages.
    pub fn file(&self) -> String {
        format!("{}.glb", self.name)
    }

    /// Parses the embedded recipe.
    pub fn recipe(&self) -> Result<Recipe, Failure> {
        Ok(Recipe::parse(&format!("{}.toml", self.name), self.recipe)?)
    }

    /// Imports the embedded model with the options of `recipe`.
    pub fn import(&self, recipe: &Recipe) -> Result<Model, Failure> {
        let mut no_files =
            |uri: &str, _: u64| Err(BakeError::Internal(format!("a built-in model refers to the file {uri}")));
        let options = ImportOptions { unit_m: recipe.model.unit_m };
        Ok(import(&self.file(), self.glb, &mut no_files, &options)?)
    }
}
