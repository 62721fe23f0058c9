//! What commands of a herd do.

use serde::Serialize;

/// What a command does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A model into a package.
    #[default]
    Bake,
    /// What is in a package, its levels of detail too.
    Inspect,
    /// A picture.
    Render,
    /// The true one.
    Truth,
    /// A part of a true one.
    Part,
    /// Those put together.
    Merge,
    /// How far a picture is from the true one.
    Compare,
    /// A share of a sequence.
    Sequence,
    /// Rows of a chart.
    Rows,
    /// A chart.
    Chart,
    /// Milliseconds of a frame.
    Bench,
}
