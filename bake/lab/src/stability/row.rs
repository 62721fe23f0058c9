//! Row of the stability table, and the results of its test.

use glam::Mat4;
use pelage_import::BakeError;
use pelage_runtime::{FrameParams, PassId};

/// Test of both forms of a method on the processor.
pub type RowTest = fn() -> Result<Vec<Finding>, BakeError>;

/// Test of both forms of a method by pictures, which the callback renders.
pub type DrawnRowTest = fn(&mut DrawCallback<'_>) -> Result<Vec<Finding>, BakeError>;

/// Callback that renders on an adapter unknown to this library. Returns `width * height` texels, row-major from the
/// top: premultiplied linear colour and opacity, with at least ten bits.
pub type DrawCallback<'a> = dyn FnMut(&Drawing<'_>) -> Result<Vec<[f32; 4]>, BakeError> + 'a;

/// Picture to render on an empty background: one instance of a package at rest.
#[derive(Clone, Copy, Debug)]
pub struct Drawing<'a> {
    /// Contents of the package.
    pub package: &'a [u8],
    /// Camera, light and style.
    pub params: &'a FrameParams,
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Passes to draw, in order.
    pub passes: &'a [PassId],
    /// Placement of the instance.
    pub at: Mat4,
}

/// Row of the table. `D` is the type of its test.
#[derive(Clone, Copy, Debug)]
pub struct Row<D = RowTest> {
    /// Name of the method.
    pub method: &'static str,
    /// Description of the failure.
    pub cliff: &'static str,
    /// Description of the naive form.
    pub naive: &'static str,
    /// Description of pelage's form.
    pub safe: &'static str,
    /// Function that tests both forms at the failure.
    pub drive: D,
}

/// Result of a test: errors of both forms by the same measure, where 0 is perfect.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Description of the test case.
    pub case: String,
    /// Name of the measure, with unit.
    pub measure: &'static str,
    /// Error of the naive form; NaN if the form returns no number.
    pub naive: f64,
    /// Error of pelage's form.
    pub safe: f64,
    /// Bound on the error of pelage's form.
    pub bound: f64,
    /// Error that the naive form must exceed; otherwise, the data did not trigger the failure.
    pub fails_above: f64,
}

impl Finding {
    /// Returns whether pelage's form stays within its bound.
    pub fn holds(&self) -> bool {
        self.safe <= self.bound
    }

    /// Returns whether the naive form fails, as the row requires.
    pub fn naive_fails(&self) -> bool {
        !self.naive.is_finite() || self.naive > self.fails_above
    }
}
