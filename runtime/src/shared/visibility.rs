/// WGSL source of this topic.
pub const WGSL: &str = include_str!("visibility.wgsl");

pub use pelage_formats::meaning::{VISIBILITY_MEAN_Z, above_horizon, light_in_tile, visibility_towards};
