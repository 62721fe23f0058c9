//! Readers of strands from files of other programs.
//!
//! Counts are checked against the file's length before anything is allocated: a header may claim four billion strands.
//! A point that is not finite is an error. A strand without length is dropped and counted.

mod hair;
mod source;
mod text;
mod tfx;

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
    /// Text with one line `x y z` or `x y z radius` per point. Each strand begins at its root, and blank lines separate
    /// strands.
    Text,
}

impl GuideFormat {
    /// All formats, with their file extensions.
    pub const EXTENSIONS: [(&'static str, Self); 3] = [("hair", Self::Hair), ("tfx", Self::Tfx), ("txt", Self::Text)];

    /// Returns the format for a file extension; upper and lower case are equal.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let named = Self::EXTENSIONS.iter().find(|(e, _)| extension.eq_ignore_ascii_case(e));
        named.map(|(_, format)| *format)
    }

    /// Reads strands; `file` is the file's name, for errors.
    ///
    /// # Errors
    ///
    /// [`BakeError::Input`] with the position in the file, the value found and the value expected.
    pub fn read(self, file: &str, bytes: &[u8]) -> Result<Guides, BakeError> {
        let source = Source { file, bytes };
        match self {
            Self::Hair => hair::read(source),
            Self::Tfx => tfx::read(source),
            Self::Text => text::read(source),
        }
    }
}
