//! Words that several options take.

use super::compare::Rgb;
use clap::ValueEnum;
use std::str::FromStr;

/// `on` or `off`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// Drawn
    On,
    /// Left out
    Off,
}

/// `--background`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// Opacity 0.
    Transparent,
    /// sRGB-encoded.
    Color([u8; 3]),
}

impl Background {
    /// sRGB-encoded; `None` for transparent.
    pub fn color(self) -> Option<[u8; 3]> {
        match self {
            Self::Transparent => None,
            Self::Color(rgb) => Some(rgb),
        }
    }
}

impl FromStr for Background {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "transparent" {
            return Ok(Self::Transparent);
        }
        let color = text.parse::<Rgb>().map(|rgb| Self::Color(rgb.0));
        color.map_err(|_| "expected transparent, or red,green,blue of 0 to 255 each".into())
    }
}
