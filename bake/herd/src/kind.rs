//! What commands of a herd do.

use serde::Serialize;

/// Kind of a command of a herd.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Bake a model.
    #[default]
    Bake,
    /// Inspect a package.
    Inspect,
    /// Draw a picture.
    Render,
    /// Trace the true picture.
    Truth,
    /// Trace a part of the true picture.
    Part,
    /// Merge parts of a true picture.
    Merge,
    /// Compare a picture with the true one.
    Compare,
    /// Draw a share of a sequence.
    Sequence,
    /// Measure rows of a chart.
    Rows,
    /// Write a chart.
    Chart,
    /// Time a frame.
    Bench,
}
