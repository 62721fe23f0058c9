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
    /// The device was made without a feature that the package's textures need.
    #[error(
        "package {package:?}: texture {texture:?} is {format}, which needs the device feature {feature}: request it when the \
         device is made, or where the adapter lacks it bake the package with format rgba8"
    )]
    MissingFeature {
        /// Name of the model in the package.
        package: String,
        /// Name of the texture in the package.
        texture: String,
        /// Its format, in WebGPU's words.
        format: &'static str,
        /// Name of the `wgpu::Features` flag.
        feature: &'static str,
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
