pub use pelage_formats::meaning::{blend, handedness_of, normalize_or, transform_normal, weighted};

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("skinning.wgsl");
