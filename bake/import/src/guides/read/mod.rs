//! Readers of strands from files of other programs.
//!
//! Counts are checked against the file's length before anything is allocated: a header may claim four billion strands.
//! Single bad strands are left out and counted: no length, a point that is not finite, or a point far from the others.

mod hair;
mod source;
mod text;
mod tfx;
mod usda;

#[cfg(test)]
mod tests;

use super::Guides;
use crate::error::BakeError;
use source::Source;

pub use hair::HairFile;

/// Strand formats that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideFormat {
    /// Cem Yuksel's binary format.
    Hair,
    /// TressFX, versions 3 and 4.
    Tfx,
    /// Text with one line `x y z` or `x y z radius` per point; commas may separate the numbers. Each strand begins at
    /// its root, and blank lines separate strands. Lines that begin with `#` are ignored.
    Text,
    /// USD as text, with prims of type `BasisCurves`. Points are converted to metres, y up.
    Usda,
}

impl GuideFormat {
    /// All formats, with their file extensions.
    pub const EXTENSIONS: [(&'static str, Self); 5] =
        [("hair", Self::Hair), ("tfx", Self::Tfx), ("txt", Self::Text), ("usda", Self::Usda), ("usd", Self::Usda)];

    /// Returns the format for a file extension; upper and lower case are equal.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let named = Self::EXTENSIONS.iter().find(|(e, _)| extension.eq_ignore_ascii_case(e));
        named.map(|(_, format)| *format)
    }

    /// Reads strands; `file` is the file's name, for errors.
    ///
    /// Fails with [`BakeError::Input`] with the position in the file, the value found and the value expected; also if
    /// the file has no strands, or all of them are left out.
    pub fn read(self, file: &str, bytes: &[u8]) -> Result<Guides, BakeError> {
        let source = Source { file, bytes, is_strict: false };
        let guides = match self {
            Self::Hair => hair::read(source),
            Self::Tfx => tfx::read(source),
            Self::Text => text::read(source),
            Self::Usda => usda::read(source),
        };
        guides?.checked(file)
    }
}
