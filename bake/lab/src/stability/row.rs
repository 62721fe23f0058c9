//! A row of the table, and what its drive finds.

use pelage_import::BakeError;
use pelage_runtime::{FrameParams, PassId};

/// Drives both forms over the cliff on the processor.
pub type Driver = fn() -> Result<Vec<Finding>, BakeError>;

/// The same by pictures, which it asks for.
pub type DrawnDriver = fn(&mut Drawer<'_>) -> Result<Vec<Finding>, BakeError>;

/// Who draws, on an adapter that this library knows nothing of: `width * height` texels of linear light times opacity,
/// and opacity, row-major from the top, with ten bits at least.
pub type Drawer<'a> = dyn FnMut(&Drawing<'_>) -> Result<Vec<[f32; 4]>, BakeError> + 'a;

/// A picture to draw over nothing: one copy of a package at rest.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// The package.
    pub package: &'a [u8],
    /// Camera, light and style.
    pub params: &'a FrameParams,
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// The passes to draw, in their order.
    pub passes: &'a [PassId],
}

/// A row of the table. `D` is how it is driven.
#[derive(Clone, Copy, Debug)]
pub struct Row<D = Driver> {
    /// The method.
    pub method: &'static str,
    /// Where it fails.
    pub cliff: &'static str,
    /// What the naive form does.
    pub naive: &'static str,
    /// What we do instead.
    pub safe: &'static str,
    /// Drives both forms over the cliff.
    pub drive: D,
}

/// What one drive found: errors of both forms by the same measure, 0 being perfect.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was driven over the cliff.
    pub case: String,
    /// What is measured, with unit.
    pub measure: &'static str,
    /// Error of the naive form; not a number where it gives none.
    pub naive: f64,
    /// Error of ours.
    pub safe: f64,
    /// What ours must stay within.
    pub bound: f64,
    /// What the naive form must exceed, for the data to have reached the cliff.
    pub fails_above: f64,
}

impl Finding {
    /// Whether our form stays within its bound.
    pub fn holds(&self) -> bool {
        self.safe <= self.bound
    }

    /// Whether the naive form fails, as it must.
    pub fn naive_fails(&self) -> bool {
        !self.naive.is_finite() || self.naive > self.fails_above
    }
}
