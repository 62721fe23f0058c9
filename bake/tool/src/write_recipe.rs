//! `pelage bake --write-recipe`: writes the full recipe of a bake, with the values that it chose. The file bakes to the
//! same package.

use super::exit::Failure;
use super::picture_args::PictureArgs;
use pelage_bake::decision::Decision;
use pelage_bake::io;
use pelage_bake::pipeline::Baked;
use pelage_bake::recipe::{Recipe, keys};
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::pack;
use pelage_formats::{InputRecord, Limits as FormatLimits, Package};
use pelage_import::{BakeError, input_record};
use pelage_truth::decide::{Figure, Limits};
use std::path::Path;

/// Fails if the image names in a recipe written to `path` would not lead to the same files.
///
/// * `images`: the images as read for the bake
pub fn require_files(path: &Path, recipe: &Recipe, images: &MapImages) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let refuse = |found: String| {
        Failure::Usage(format!(
            "--write-recipe {found}; file names in a recipe are relative to its folder: \
             write it into the folder of --recipe, or copy the files as well"
        ))
    };
    let found = io::read_map_images(&path.display().to_string(), &|name| folder.join(name), recipe)
        .map_err(|error| refuse(error.to_string()))?;
    match found.inputs.iter().find(|input| !images.inputs.contains(input)) {
        Some(other) => {
            let text = format!("{}: {:?} would refer to another file than in this bake", path.display(), other.name);
            Err(refuse(text))
        }
        None => Ok(()),
    }
}

/// Comment above a key that the bake chose and the user did not set.
const BY_BAKE: &str = "chosen by the bake";

/// Returns the options that make the bake choose settings, as on the command line; empty without such options.
pub fn options(limits: &Limits, pictures: &PictureArgs) -> String {
    let limits = Figure::ALL.iter().filter_map(|figure| Some(format!("{} {}", figure.option(), limits.of(*figure)?)));
    let pictures = Some(pictures.words()).filter(|words| !words.is_empty());
    limits.chain(pictures).collect::<Vec<_>>().join(" ")
}

/// Recipe before and after the choices made for the command-line options.
pub struct RecipeChoices<'a> {
    /// Name of the model, for the text.
    pub model: &'a str,
    /// Recipe before the choices.
    pub asked: &'a Recipe,
    /// Recipe after the choices.
    pub recipe: &'a Recipe,
    /// Command-line options that required the choices, from [`options`].
    pub options: &'a str,
}

impl RecipeChoices<'_> {
    /// Changes a package into the one that the written recipe bakes to, and returns that recipe.
    ///
    /// * `path`: path of the recipe to write
    /// * `inputs`: files of the model, as the package records them
    /// * `images`: images of the recipe
    ///
    /// Fails like [`Self::text`].
    pub fn put_into(
        &self,
        baked: &mut Baked,
        path: &Path,
        inputs: Vec<InputRecord>,
        images: &MapImages,
    ) -> Result<String, BakeError> {
        let fault = |fault| BakeError::Internal(format!("cannot read back the package: {fault}"));
        let recorded =
            Package::open(&baked.package, &FormatLimits::default()).map_err(fault)?.manifest().recipe.clone();
        let (text, file) = (self.text(&recorded, &baked.decisions)?, path.display().to_string());
        let record = input_record("recipe", &file, text.as_bytes());
        let inputs = inputs.into_iter().chain([record]).chain(images.inputs.iter().cloned()).collect();
        baked.package = pack::with_recipe(&baked.package, &file, &text, inputs)?;
        Ok(text)
    }

    /// Returns the text of the recipe. Every key has a comment with its meaning, and chosen keys also the source of the
    /// choice.
    ///
    /// * `recorded`: recipe of the package, with all unset keys filled in
    /// * `decisions`: choices of the bake for unset keys
    ///
    /// Fails with [`BakeError::Internal`] if the line of a decision is not a line of a recipe.
    fn text(&self, recorded: &str, decisions: &[Decision]) -> Result<String, BakeError> {
        let mut recipe = Recipe::parse_recorded("the package's recipe", recorded)?;
        for Decision { what, line, .. } in decisions {
            let fault =
                |fault| BakeError::Internal(format!("the decision on {what} is not a valid recipe line: {fault}"));
            recipe.merge("decision", line).map_err(fault)?;
        }
        let by_options: Vec<&str> =
            keys().filter(|key| key.value(self.asked) != key.value(self.recipe)).map(|key| key.name).collect();
        let said = recipe.to_noted_toml(|key| {
            let of_key = |d: &&Decision| d.line.split_once('=').is_some_and(|(name, _)| name.trim() == key.name);
            let by_option = by_options.contains(&key.name).then(|| format!("{BY_BAKE}: for {}", self.options));
            let words = decisions.iter().filter(of_key).map(|d| format!("{BY_BAKE}: {}, {}", d.what, d.chosen));
            let mut notes: Vec<String> = by_option.into_iter().chain(words).collect();
            if notes.is_empty() && key.value(self.recipe) != key.value(&recipe) {
                notes.push(BY_BAKE.to_owned());
            }
            notes
        });
        Ok(format!(
            "# Complete recipe of a bake of {:?}: baking the same model with this file gives the same package.\n\
             # A comment above each key explains it. Values from neither a recipe nor an option are {BY_BAKE}.\n\n\
             {said}",
            self.model
        ))
    }
}

#[cfg(test)]
#[path = "write_recipe_tests.rs"]
mod tests;
