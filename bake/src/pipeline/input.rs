//! Input of all steps.

use crate::progress::StageProgress;
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;

/// Input of a bake, the same for all steps.
#[derive(Clone, Copy, Debug)]
pub struct BakeInput<'a> {
    /// Model or package as the user named it, for messages.
    pub file: &'a str,
    /// Name of the model in the package.
    pub name: &'a str,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// Images that the recipe names.
    pub images: &'a MapImages,
    /// Progress counter of long stages.
    pub progress: &'a StageProgress,
}

impl<'a> BakeInput<'a> {
    /// Creates the input with an unobserved progress counter. Arguments are the fields.
    pub fn new(file: &'a str, name: &'a str, recipe: &'a Recipe, images: &'a MapImages) -> Self {
        Self { file, name, recipe, images, progress: StageProgress::ignored() }
    }
}
