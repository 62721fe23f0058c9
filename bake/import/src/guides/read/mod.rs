//! Strands from the files of other programs.
//!
//! A file is held against its own length before anything is made of it, so that counts of four billion cost nothing. A point that is not finite is an
//! error; a strand without length is left out and counted.

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

/// Formats of strands that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuideFormat {
    /// Cem Yuksel's binary format.
    Hair,
    /// TressFX, versions 3 and 4.
    Tfx,
    /// A line `x y z` or `x y z radius` per point, root first, a blank line between strands.
    Text,
}

impl GuideFormat {
    /// All of them with the extension that stands for each.
    pub const EXTENSIONS: [(&'static str, Self); 3] = [("hair", Self::Hair), ("tfx", Self::Tfx), ("txt", Self::Text)];

    /// The format of a file with that extension, in any case.
    pub fn of_extension(extension: &str) -> Option<Self> {
        let named = Self::EXTENSIONS.iter().find(|(e, _)| extension.eq_ignore_ascii_case(e));
        named.map(|(_, format)| *format)
    }

    /// Reads strands; `file`: its name, for errors.
    ///
    /// # Errors
    ///
    /// [`BakeError::Input`] with the place in the file, what was found there and what was expected.
    pub fn read(self, file: &str, bytes: &[u8]) -> Result<Guides, BakeError> {
        let source = Source { file, bytes };
        match self {
            Self::Hair => hair::read(source),
            Self::Tfx => tfx::read(source),
            Self::Text => text::read(source),
        }
    }
}
