//! What is charted: a model with its recipe.

use super::ChartArgs;
use crate::cli::built_in::HARE;
use crate::cli::exit::Failure;
use pelage_bake::groom::MapImages;
use pelage_bake::import::ImportOptions;
use pelage_bake::io;
use pelage_bake::mesh::Model;
use pelage_bake::recipe::Recipe;

/// A model with its recipe.
pub struct Subject {
    /// The model's file as the user named it.
    pub file: String,
    /// Its name without folder and extension.
    pub name: String,
    /// The model.
    pub model: Model,
    /// The recipe that all rows start from.
    pub recipe: Recipe,
    /// The images that the recipe names.
    pub images: MapImages,
    /// The `pelage bake` that would read both, without what changes the recipe.
    pub command: String,
    /// Changes to the recipe, as `--set` takes them.
    pub sets: Vec<String>,
    /// What `pelage chart` was given to read them.
    pub arguments: String,
}

impl Subject {
    /// Reads what the arguments name; by default the built-in hare.
    pub fn new(args: &ChartArgs) -> Result<Self, Failure> {
        let sets = args.recipe.set.clone();
        let set_words = set_words(&sets);
        if let Some(path) = &args.model {
            let (recipe, _) = args.recipe.read()?;
            let model = io::read_model(path, &ImportOptions { unit_m: recipe.model.unit_m })?;
            let mut files = format!(" {}", shell_word(&path.display().to_string()));
            if let Some(recipe) = &args.recipe.recipe {
                files += &format!(" --recipe {}", shell_word(&recipe.display().to_string()));
            }
            let (command, arguments) = (format!("pelage bake{files}"), files + &set_words);
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let (file, images) = (path.display().to_string(), args.recipe.images(&recipe)?);
            return Ok(Self { file, name, model, recipe, images, command, sets, arguments });
        }
        if args.recipe.recipe.is_some() {
            return Err(Failure::Usage("--recipe needs a MODEL: the built-in hare has its own".into()));
        }
        let mut recipe = HARE.recipe()?;
        args.recipe.set.iter().try_for_each(|assignment| recipe.set(assignment))?;
        let command = format!("pelage bake assets/models/{0}.glb --recipe assets/recipes/{0}.toml", HARE.name);
        let (file, name, images) = (HARE.file(), HARE.name.into(), args.recipe.images(&recipe)?);
        Ok(Self { file, name, model: HARE.import(&recipe)?, recipe, images, command, sets, arguments: set_words })
    }
}

/// Changes to a recipe as options: ` --set a=1 --set b=2`.
pub fn set_words<'a>(sets: impl IntoIterator<Item = &'a String>) -> String {
    sets.into_iter().map(|set| format!(" --set {}", shell_word(set))).collect()
}

/// A word as a shell reads it.
pub fn shell_word(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        for (word, expected) in [
            ("a/b-c.glb", "a/b-c.glb"),
            ("my fox.glb", "'my fox.glb'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("a[1]", "'a[1]'"),
        ] {
            assert_eq!(shell_word(word), expected);
        }
    }
}
