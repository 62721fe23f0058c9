//! `ink_composite`: paper, wash and lines into the application's pass, with the depth of what is painted.

use super::ink::ink_screen_wgsl;

/// The shader.
pub(crate) const WGSL: &str = ink_screen_wgsl!("ink_composite.wgsl");
