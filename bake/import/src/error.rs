//! Error type of the offline crates: importer, baker, truth and herd.

use pelage_formats::FormatError;
use std::path::PathBuf;

/// Error of an offline crate, by cause. Each variant gives the file, the position in it, the value found and the value
/// expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// A file system operation failed (exit code 2).
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Attempted operation: `read`, `write`, `create`, `rename`, …
        action: &'static str,
        /// Error returned by the system.
        source: std::io::Error,
    },
    /// A model, image, recipe or unpacked folder is invalid (exit code 3).
    #[error("{file}: {place}: {reason}")]
    Input {
        /// File as named by the user.
        file: String,
        /// Position in the file: byte offset (`byte 20`), JSON pointer (`/meshes/0/primitives/1`), line of an OBJ
        /// (`line 7`), or recipe key with line (`line 3, hair.length_m`).
        place: String,
        /// Reason: the value found, the value expected, and a remedy if there is one.
        reason: String,
    },
    /// A package is damaged, too new, or not a package (exit code 3).
    #[error("{file}: {source}")]
    Package {
        /// File as named by the user.
        file: String,
        /// Error of the package format: section, offset, value found and value expected.
        source: FormatError,
    },
    /// A stage was called with parameters outside their range (exit code 3 if they came from a recipe).
    #[error("{what}: {reason}")]
    Params {
        /// Name of the parameter as in the recipe: `hair.length_m`.
        what: &'static str,
        /// Reason: the value found and the value expected.
        reason: String,
    },
    /// A command would overwrite a file that it reads, or write one file twice (exit code 1).
    #[error("{written}: is the same file as {other}; expected another file")]
    SameFile {
        /// Role and path of the output: `--depfile fox.glb`.
        written: String,
        /// Path and role of the other file: `fox.glb, given as MODEL`.
        other: String,
    },
    /// Internal error, independent of the input (exit code 5).
    #[error("internal error, please report it: {0}")]
    Internal(String),
}

impl From<pelage_params::OutOfRange> for BakeError {
    fn from(pelage_params::OutOfRange { name, reason }: pelage_params::OutOfRange) -> Self {
        Self::Params { what: name, reason }
    }
}
