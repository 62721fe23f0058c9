//! `ink_stroke`: opacity and grey of the lines: the dilated features, filled by the brush and by the sphere map (Fang 2006, §2), roughened by the paper.

use super::ink::ink_screen_wgsl;

/// The shader.
pub(crate) const WGSL: &str = ink_screen_wgsl!("ink_stroke.wgsl");
