//! The one error type of this crate.

use pelage_formats::FormatError;

/// What stopped a stage, by who is at fault. Each variant says which file, where in it, what was found and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// A scene file, or a package that does not fit it, is not what it should be.
    #[error("{file}: {place}: {reason}")]
    Input {
        /// The file as the user named it.
        file: String,
        /// Line and key of a scene file (`line 3, camera.eye`), or section of a package.
        place: String,
        /// What was found and what was expected.
        reason: String,
    },
    /// A package is damaged, too new, or not a package.
    #[error("{file}: {source}")]
    Package {
        /// The file as the user named it.
        file: String,
        /// Section, offset, found and expected.
        source: FormatError,
    },
    /// What was asked for is not there, or more than the device can do.
    #[error("{what}: {reason}")]
    Asked {
        /// What was asked for: `clip Walk`, `size 9000x9000`.
        what: String,
        /// What was found, and what there is instead.
        reason: String,
    },
    /// A parameter of the frame is out of its range, or more than the device can do.
    #[error("{0}")]
    Params(String),
    /// No graphics adapter can be used, or it lacks what the package needs; the text says what was tried.
    #[error("no usable graphics adapter: {0}")]
    NoAdapter(String),
    /// The device stopped answering: a fault of driver or machine that no input explains.
    #[error("the graphics device failed: {0}")]
    Device(String),
    /// Something that should not happen, whatever the input.
    #[error("internal error, please report it: {0}")]
    Internal(String),
}
