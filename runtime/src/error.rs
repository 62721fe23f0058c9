//! The one error type of this crate.

use pelage_formats::FormatError;

/// What stopped the runtime, by who is at fault.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// The package is damaged, too new, or not a package.
    #[error("{0}")]
    Package(#[from] FormatError),
    /// The package is well-formed but nothing that can be drawn.
    #[error("package {package:?}: {what}: {reason}")]
    Content {
        /// Name of the model in the package.
        package: String,
        /// Field or texture at fault: `mesh`, `texture "shell_color"`.
        what: String,
        /// What was found and what was expected.
        reason: String,
    },
    /// Something is larger than the device's limits allow.
    #[error(
        "{what} is {found}, above the device's {limit} of {allowed}: request a higher limit when the device is made"
    )]
    DeviceLimit {
        /// What is too large.
        what: String,
        /// Its size.
        found: u64,
        /// Name of the field of `wgpu::Limits`.
        limit: &'static str,
        /// The limit of the device.
        allowed: u64,
    },
    /// [`crate::RendererOptions`] that this device cannot draw with.
    #[error("RendererOptions::{field} is {found}, expected {expected}")]
    Options {
        /// The field.
        field: &'static str,
        /// Its value.
        found: String,
        /// What it must be.
        expected: &'static str,
    },
    /// [`crate::FrameParams`] or an [`crate::Instance`] outside its range.
    #[error("{field} is {found}, expected {expected}")]
    Params {
        /// The field: `FurParams::layers`.
        field: &'static str,
        /// Its value.
        found: String,
        /// What it must be.
        expected: String,
    },
}
