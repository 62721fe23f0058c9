//! `ink_composite`: paper, wash and lines into the application's pass, with the depth of what is painted.

use super::ink::ink_screen_wgsl;
use crate::ink::InkShow;

/// The shader.
pub(crate) const WGSL: &str = ink_screen_wgsl!("ink_composite.wgsl");

/// The number that the shader knows a choice by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ScreenShow {
    Painting = 0,
    Lines = 1,
    Features = 2,
    Wash = 3,
}

impl From<InkShow> for ScreenShow {
    fn from(show: InkShow) -> Self {
        match show {
            InkShow::Painting => Self::Painting,
            InkShow::Lines => Self::Lines,
            InkShow::Features => Self::Features,
            InkShow::Wash => Self::Wash,
        }
    }
}
