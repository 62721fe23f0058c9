//! Repeated bakes of one model while its recipe changes.

use crate::pipeline::{BakeInput, Baked, CachedStages, OnStep, Output, Outputs, baked, run};
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;
use pelage_import::BakeError;
use pelage_import::mesh::Model;

/// Outputs of the last bake, reused by the next one. Only outputs affected by a change of the recipe are made again.
///
/// The package is always identical, byte for byte, to that of [`crate::pipeline::bake`].
#[derive(Clone, Debug)]
pub struct Rebake<'a> {
    outputs: Outputs<'a>,
    before: Option<(&'a Recipe, &'a MapImages)>,
}

impl<'a> Rebake<'a> {
    /// Creates an empty state.
    pub fn new(model: &'a Model) -> Self {
        Self { outputs: Outputs::of_model(model), before: None }
    }

    /// Bakes the model with the recipe in `input`. If it fails, the outputs made so far are kept. Images are compared
    /// by address, so images that were read again count as changed.
    ///
    /// Fails with the errors of [`crate::pipeline::bake`].
    pub fn bake(&mut self, input: &BakeInput<'a>, on_step: &mut OnStep<'_>) -> Result<Baked, BakeError> {
        match self.before {
            Some((recipe, images)) if std::ptr::eq(images, input.images) => {
                self.outputs.invalidate_changes(recipe, input.recipe);
            }
            Some(_) => {
                self.outputs.invalidate(Output::Layout);
                self.outputs.kept = CachedStages::default();
            }
            None => {}
        }
        self.before = Some((input.recipe, input.images));
        run(input, &mut self.outputs, on_step)?;
        baked(&self.outputs)
    }
}
