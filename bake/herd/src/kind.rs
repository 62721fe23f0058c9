//! Kinds of commands of a herd.

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
    /// Trace a reference image.
    Truth,
    /// Trace a part of a reference image.
    Part,
    /// Merge parts of a reference image.
    Merge,
    /// Compare a picture with the reference image.
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
