//! `pelage bake --write-recipe`: the whole recipe of a bake, what it chose included, as a file that gives the same package.

use super::exit::Failure;
use super::output::require_parent;
use super::picture_args::PictureArgs;
use pelage_bake::decision::Decision;
use pelage_bake::io;
use pelage_bake::pipeline::Baked;
use pelage_bake::recipe::{Recipe, keys};
use pelage_bake::stages::groom::MapImages;
use pelage_bake::stages::pack;
use pelage_formats::{InputRecord, Limits as FormatLimits, Package};
use pelage_import::BakeError;
use pelage_import::input_record;
use pelage_truth::decide::{Figure, Limits};
use std::path::{Path, PathBuf};

/// Where the file would lie: links followed as far as it is there.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let beside = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.canonicalize().ok().or_else(beside).unwrap_or_else(absolute)
}

/// Fails early where the recipe cannot be written, or would take the place of another file of the bake.
///
/// * `recipe`: the one that is read, if any: it has its author's words, which the written one has not
pub fn require_place(path: &Path, model: &Path, package: &Path, recipe: Option<&Path>) -> Result<(), Failure> {
    require_parent(path)?;
    let others = [("the model", Some(model)), ("the package", Some(package)), ("the recipe that is read", recipe)];
    for (what, other) in others {
        if other.is_some_and(|other| place(other) == place(path)) {
            let text = format!("--write-recipe {}: that is {what}; give it another name", path.display());
            return Err(Failure::Usage(text));
        }
    }
    Ok(())
}

/// Fails where the recipe, lying at `path`, would not find the very files that it names.
///
/// * `images`: these files as they were read for the bake
pub fn require_files(path: &Path, recipe: &Recipe, images: &MapImages) -> Result<(), Failure> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let refuse = |found: String| {
        Failure::Usage(format!(
            "--write-recipe {found}; a recipe finds files from its own folder: write it into that of --recipe, or copy them so that it finds them"
        ))
    };
    let found = io::read_map_images(&path.display().to_string(), &|name| folder.join(name), recipe)
        .map_err(|error| refuse(error.to_string()))?;
    match found.inputs.iter().find(|input| !images.inputs.contains(input)) {
        Some(other) => {
            let text = format!("{}: it would find another file {:?} than this bake", path.display(), other.name);
            Err(refuse(text))
        }
        None => Ok(()),
    }
}

/// What stands above a key that nobody said.
const BY_BAKE: &str = "chosen by the bake";

/// The options that let a bake choose, as they may be typed; empty where there are none.
pub fn options(limits: &Limits, pictures: &PictureArgs) -> String {
    let limits = Figure::ALL.iter().filter_map(|figure| Some(format!("{} {}", figure.option(), limits.of(*figure)?)));
    let pictures = Some(pictures.words()).filter(|words| !words.is_empty());
    limits.chain(pictures).collect::<Vec<_>>().join(" ")
}

/// What a recipe was, and what the options of the command made of it.
pub struct Chosen<'a> {
    /// Name of the model, for people.
    pub model: &'a str,
    /// The recipe as it was given.
    pub asked: &'a Recipe,
    /// The same with what options of the command chose.
    pub recipe: &'a Recipe,
    /// These [`options`].
    pub options: &'a str,
}

impl Chosen<'_> {
    /// Makes of a package the one that a bake by the written recipe gives, and returns that recipe.
    ///
    /// * `path`: where the recipe will lie
    /// * `inputs`: the files of the model, as the package records them
    /// * `images`: the files that the recipe names
    ///
    /// # Errors
    ///
    /// As [`Self::text`].
    pub fn put_into(
        &self,
        baked: &mut Baked,
        path: &Path,
        inputs: Vec<InputRecord>,
        images: &MapImages,
    ) -> Result<String, BakeError> {
        let fault = |fault| BakeError::Internal(format!("the package does not read back: {fault}"));
        let recorded =
            Package::open(&baked.package, &FormatLimits::default()).map_err(fault)?.manifest().recipe.clone();
        let (text, file) = (self.text(&recorded, &baked.decisions)?, path.display().to_string());
        let record = input_record("recipe", &file, text.as_bytes());
        let inputs = inputs.into_iter().chain([record]).chain(images.inputs.iter().cloned()).collect();
        baked.package = pack::with_recipe(&baked.package, &file, &text, inputs)?;
        Ok(text)
    }

    /// The recipe: every key with its meaning, and above those that were chosen by what.
    ///
    /// * `recorded`: the recipe as the package has it, in which what it left open is filled in
    /// * `decisions`: what the bake chose where the recipe is silent
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] where the line of a decision is no line of a recipe.
    fn text(&self, recorded: &str, decisions: &[Decision]) -> Result<String, BakeError> {
        let mut recipe = Recipe::recorded("the package's recipe", recorded)?;
        for Decision { what, line, .. } in decisions {
            let fault = |fault| BakeError::Internal(format!("the decision on {what} is no line of a recipe: {fault}"));
            recipe.read("decision", line).map_err(fault)?;
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
            "# The whole recipe of a bake of {:?}: the same model with this file gives the same package.\n\
             # Above each key stands what it means. What neither a recipe nor an option said is {BY_BAKE}.\n\n{said}",
            self.model
        ))
    }
}

#[cfg(test)]
#[path = "write_recipe_tests.rs"]
mod tests;
