//! Options of an import.

use crate::BakeError;
use pelage_params::Field as _;
use std::ops::RangeInclusive;

/// Options for reading a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// Length of one unit of the model, metres; range [`ImportOptions::UNIT_M`], default 1.
    pub unit_m: f32,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self { unit_m: 1.0 }
    }
}

impl ImportOptions {
    /// Range of `unit_m`.
    pub const UNIT_M: RangeInclusive<f32> = 1e-6..=1e6;

    /// Checks that the options are in range.
    ///
    /// Fails with [`BakeError::Params`] for a unit outside its range.
    pub fn validate(&self) -> Result<(), BakeError> {
        self.unit_m.check(&Self::UNIT_M).map_err(|reason| BakeError::Params { what: "model.unit_m", reason })
    }
}
