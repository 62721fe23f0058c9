//! `ink_features`: the pixels that lines run through, with half the width and the strength of their line, from the normals of neighbours at two
//! thresholds (Fang 2006, §2).

use super::ink::ink_screen_wgsl;

/// The shader.
pub(crate) const WGSL: &str = ink_screen_wgsl!("ink_features.wgsl");
