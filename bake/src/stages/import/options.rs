//! How to read a model.

use crate::BakeError;
use crate::recipe::ModelParams;

/// How to read a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// `model.unit_m` of a recipe, with its range and default: length of one unit of the model, metres.
    pub unit_m: f32,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { unit_m: ModelParams::default().unit_m }
    }
}

impl ImportOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    ///
    /// [`BakeError::Params`] for a unit outside its range.
    pub fn validate(&self) -> Result<(), BakeError> {
        Ok(ModelParams { unit_m: self.unit_m, ..ModelParams::default() }.validate()?)
    }
}
