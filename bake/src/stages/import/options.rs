//! How to read a model.

use crate::BakeError;
use serde::{Deserialize, Serialize};

/// How to read a model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImportOptions {
    /// Length of one unit of the model, metres, 1e-6..=1e6 (default 1, as glTF says; 0.01 for a model made in centimetres). OBJ has no
    /// unit of its own.
    pub unit_m: f32,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { unit_m: 1.0 }
    }
}

impl ImportOptions {
    /// Checks the ranges.
    ///
    /// # Errors
    ///
    /// [`BakeError::Params`] for a unit outside its range.
    pub fn validate(&self) -> Result<(), BakeError> {
        if (1e-6..=1e6).contains(&self.unit_m) {
            return Ok(());
        }
        let reason = format!("is {}, expected 1e-6..=1e6 metres", self.unit_m);
        Err(BakeError::Params { what: "model.unit_m", reason })
    }
}
