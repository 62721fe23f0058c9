pub use pelage_formats::meaning::fin_opacity;

/// The shader source.
pub const WGSL: &str = include_str!("fins.wgsl");
