pub use pelage_formats::meaning::fin_opacity;

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("fins.wgsl");
