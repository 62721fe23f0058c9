//! Root of the hair that is visible at a point of the tile: `FORMAT.md`, "ROOT".

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Lateral offset of hair from its root, at one height above the surface, tile widths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RootOffset {
    /// Offset of hair that points straight away from the surface, along u and v.
    pub mean: [f32; 2],
    /// Additional offset per unit of the lateral component of the hair's unit direction.
    pub along: f32,
}

impl RootOffset {
    /// Returns the offset along u and v from the root of a hair to the point where the hair is visible, tile widths.
    ///
    /// * `direction` - of the hair at that point, in the frame of the tile, unit length
    pub fn offset(&self, direction: Vec3) -> Vec2 {
        root_offset(Vec2::from(self.mean).extend(self.along), direction)
    }
}

/// Returns the offset from the root of a hair to the point where it is visible. `aside` holds `mean` and `along` of a
/// [`RootOffset`], in any unit.
pub fn root_offset(aside: Vec3, direction: Vec3) -> Vec2 {
    aside.truncate() + direction.truncate() * aside.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_offset_depends_on_height_and_direction() {
        let aside = RootOffset { mean: [0.01, 0.2], along: 0.5 };
        assert_eq!(aside.offset(Vec3::Z), Vec2::new(0.01, 0.2));
        assert!(aside.offset(Vec3::new(0.6, -0.4, 0.69)).distance(Vec2::new(0.31, 0.0)) < 1e-6);
    }
}
