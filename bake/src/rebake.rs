//! A model that is baked again and again while its recipe changes.

use crate::pipeline::{Baked, Kept, Output, Outputs, Told, baked, run};
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;
use pelage_import::BakeError;
use pelage_import::mesh::Model;

/// What the steps of a bake made, kept for the next one: only what a change of the recipe decides about is made again.
///
/// The package is always the one that [`crate::pipeline::bake`] gives, byte for byte.
#[derive(Clone, Debug)]
pub struct Rebake<'a> {
    outputs: Outputs<'a>,
    before: Option<(&'a Recipe, &'a MapImages)>,
}

impl<'a> Rebake<'a> {
    /// Nothing is made yet.
    pub fn new(model: &'a Model) -> Self {
        Self { outputs: Outputs { model: Some(model), ..Outputs::default() }, before: None }
    }

    /// Bakes the model as `told` says. Where it fails, what was made so far is kept, too. Images are the same only where they are at the same place:
    /// whoever reads them again has others.
    ///
    /// # Errors
    ///
    /// As [`crate::pipeline::bake`].
    pub fn bake(&mut self, told: &Told<'a>, on_stage: &mut dyn FnMut(&'static str)) -> Result<Baked, BakeError> {
        match self.before {
            Some((recipe, images)) if std::ptr::eq(images, told.images) => self.outputs.follow(recipe, told.recipe),
            Some(_) => {
                self.outputs.forget(Output::Laid);
                self.outputs.kept = Kept::default();
            }
            None => {}
        }
        self.before = Some((told.recipe, told.images));
        run(told, &mut self.outputs, on_stage)?;
        baked(&self.outputs)
    }
}
