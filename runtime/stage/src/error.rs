//! Error type of this crate.

use pelage_formats::FormatError;

/// Errors of the stage, grouped by the faulty input. Each variant gives the file, the position in it, the value found
/// and the value expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// A scene file, or a package that it uses, is invalid.
    #[error("{file}: {place}: {reason}")]
    Input {
        /// File name as given by the user.
        file: String,
        /// Line and key of a scene file (`line 3, camera.eye`), or section of a package.
        place: String,
        /// Found and expected values.
        reason: String,
    },
    /// A package is damaged, too new, or not a package.
    #[error("{file}: {source}")]
    Package {
        /// File name as given by the user.
        file: String,
        /// Section, offset, and the found and expected values.
        source: FormatError,
    },
    /// The request names something that does not exist, or exceeds the device's limits.
    #[error("{what}: {reason}")]
    Request {
        /// Request as the user wrote it: `clip Walk`, `size 9000x9000`.
        what: String,
        /// Found value, and the alternatives that exist.
        reason: String,
    },
    /// A parameter of the frame is out of range, or exceeds the device's limits.
    #[error("{0}")]
    Params(String),
    /// No usable graphics adapter was found, or it lacks a feature that the package needs. The text lists what was
    /// tried.
    #[error("no usable graphics adapter: {0}")]
    NoAdapter(String),
    /// The device stopped responding: a fault of the driver or machine, independent of the input.
    #[error("the graphics device failed: {0}")]
    Device(String),
    /// Internal error, which no input should cause.
    #[error("internal error, please report it: {0}")]
    Internal(String),
}
