//! Seal of an ink painting.

use crate::error::RuntimeError;
use glam::Vec2;
use pelage_formats::meaning::seal::SealImage;
use std::sync::Arc;

/// Seal on an ink painting, stamped last. White of the image leaves the painting as it was; its colours cover it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Seal {
    /// Image; keep it in the same [`Arc`] from frame to frame, because a new one is uploaded.
    pub image: Arc<SealImage>,
    /// Centre, as shares of the picture's width from the left and of its height from the top (default 0.9, 0.88).
    pub center: Vec2,
    /// Height, as a share of the picture's height, 0.001..=1 (default 0.1).
    pub height: f32,
}

impl Seal {
    /// Creates a seal with the default place.
    pub fn new(image: Arc<SealImage>) -> Self {
        Self { image, center: Self::CENTER, height: Self::HEIGHT }
    }

    /// Default centre.
    pub const CENTER: Vec2 = Vec2::new(0.9, 0.88);
    /// Default height.
    pub const HEIGHT: f32 = 0.1;

    /// Returns the seal at another place.
    pub fn at(self, center: Vec2, height: f32) -> Self {
        Self { center, height, ..self }
    }

    pub(super) fn check(&self) -> Result<(), RuntimeError> {
        let fail = |field, found, expected: &str| Err(RuntimeError::Params { field, found, expected: expected.into() });
        if !self.center.is_finite() {
            return fail("Seal::center", self.center.to_string(), "finite numbers");
        }
        if !(0.001..=1.0).contains(&self.height) {
            return fail("Seal::height", self.height.to_string(), "0.001..=1");
        }
        Ok(())
    }
}
