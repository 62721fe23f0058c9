//! `ink_dilate`: half of the dilation, along rows; `ink_stroke` does that along columns. Together they are one dilation by discs of each feature's
//! own size instead of three by 3 x 3 pixels.

use super::ink::ink_screen_wgsl;

/// The shader.
pub(crate) const WGSL: &str = ink_screen_wgsl!("ink_dilate.wgsl");
