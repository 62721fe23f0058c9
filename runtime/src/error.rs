//! Error type of this crate.

use pelage_formats::FormatError;

/// Errors of the runtime, grouped by the faulty input.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RuntimeError {
    /// The package is damaged, too new, or not a package.
    #[error("{0}")]
    Package(#[from] FormatError),
    /// The package is well-formed, but its content cannot be drawn.
    #[error("package {package:?}: {what}: {reason}")]
    Content {
        /// Name of the model in the package.
        package: String,
        /// Field or texture at fault: `mesh`, `texture "shell_color"`.
        what: String,
        /// Found and expected values.
        reason: String,
    },
    /// A resource is larger than the device's limits allow.
    #[error(
        "{what} is {found}, above the device's {limit} of {allowed}: request a higher limit when creating the device"
    )]
    DeviceLimit {
        /// Resource that is too large.
        what: String,
        /// Size of the resource.
        found: u64,
        /// Name of the field of `wgpu::Limits`.
        limit: &'static str,
        /// Limit of the device.
        allowed: u64,
    },
    /// The device cannot draw with these [`crate::RendererOptions`].
    #[error("RendererOptions::{field} is {found}, expected {expected}")]
    Options {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        found: String,
        /// Expected value.
        expected: &'static str,
    },
    /// A value of [`crate::FrameParams`] or of an [`crate::Instance`] is out of range.
    #[error("{field} is {found}, expected {expected}")]
    Params {
        /// Name of the field, such as `FurParams::layers`.
        field: &'static str,
        /// Value of the field.
        found: String,
        /// Expected value.
        expected: String,
    },
}
