//! Level of detail of fur that is small on screen.

use crate::error::RuntimeError;

/// Level of detail of each model's fur. [`crate::FurParams::layers`] overrides it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Detail {
    /// Full detail at any size on screen.
    Full,
    /// Detail by size on screen, from the package's levels of detail and the size of each instance in
    /// [`crate::FrameParams::viewport`] (the default, with bias 1).
    Auto {
        /// Factor on the size on screen, above 0: 2 draws as if everything were twice as large, 0.5 saves more. 1
        /// follows the package.
        bias: f32,
    },
    /// Fixed level for every package; a fraction fades between two levels. 0 draws all layers; values above the last
    /// level are clamped to it. For measurements.
    Level(
        /// Level, at least 0.
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
