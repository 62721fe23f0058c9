pub use pelage_formats::meaning::{blend, handedness_of, normalize_or, transform_normal, weighted};

/// The shader source.
pub const WGSL: &str = include_str!("skinning.wgsl");
