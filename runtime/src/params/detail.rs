//! How much of the fur is drawn where it is small.

use crate::error::RuntimeError;

/// How much of each model's fur is drawn. [`crate::FurParams::layers`] goes before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// All of it, whatever its size on screen.
    Full,
    /// As much as its size on screen shows, by the package's levels of detail and the size that each instance has in
    /// [`crate::FrameParams::viewport`] (default, with a bias of 1).
    Auto {
        /// Factor on the size, above 0: 2 draws as much as if everything were twice as large, 0.5 saves more (1 as the package says).
        bias: f32,
    },
    /// This level of every package, and between two levels by the fraction: 0 all layers; beyond the last, the last. For measuring.
    Level(
        /// At least 0.
        f32,
    ),
}

impl Default for Detail {
    fn default() -> Self {
        Self::Auto { bias: 1.0 }
    }
}

impl Detail {
    pub(crate) fn check(&self) -> Result<(), RuntimeError> {
        let good = |x: f32| x.is_finite() && x > 0.0;
        let fail = |found: String, expected: &str| {
            Err(RuntimeError::Params { field: "FurParams::detail", found, expected: expected.into() })
        };
        match *self {
            Self::Auto { bias } if !good(bias) => fail(bias.to_string(), "a bias above 0"),
            Self::Level(level) if !(level.is_finite() && level >= 0.0) => fail(level.to_string(), "at least 0"),
            _ => Ok(()),
        }
    }
}
