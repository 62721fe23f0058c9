//! Tone mapping; Rust counterpart of `tone.wgsl`.

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("tone.wgsl");

pub use pelage_formats::meaning::tone::tone_mapped;
