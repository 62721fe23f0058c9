//! The error type of the offline crates: importer, baker, truth and herd.

use pelage_formats::FormatError;
use std::path::PathBuf;

/// What stopped a bake, by who is at fault. Each variant says which file, where in it, what was found and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The file system refused (exit code 2).
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried: `read`, `write`, `create`, `rename`, …
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A model, image, recipe or unpacked folder is not what it should be (exit code 3).
    #[error("{file}: {place}: {reason}")]
    Input {
        /// The file as the user named it.
        file: String,
        /// Byte offset (`byte 20`), JSON pointer (`/meshes/0/primitives/1`), line of an OBJ (`line 7`), or recipe key with line
        /// (`line 3, hair.length_m`).
        place: String,
        /// What was found and what was expected, and where it helps, what to do.
        reason: String,
    },
    /// A package is damaged, too new, or not a package (exit code 3).
    #[error("{file}: {source}")]
    Package {
        /// The file as the user named it.
        file: String,
        /// Section, offset, found and expected.
        source: FormatError,
    },
    /// A stage was called with parameters outside their range (exit code 3 when they came from a recipe).
    #[error("{what}: {reason}")]
    Params {
        /// The parameter, as in the recipe: `hair.length_m`.
        what: &'static str,
        /// What was found and what was expected.
        reason: String,
    },
    /// Something that should not happen, whatever the input (exit code 5).
    #[error("internal error, please report it: {0}")]
    Internal(String),
}

impl From<pelage_params::OutOfRange> for BakeError {
    fn from(pelage_params::OutOfRange { name, reason }: pelage_params::OutOfRange) -> Self {
        Self::Params { what: name, reason }
    }
}
