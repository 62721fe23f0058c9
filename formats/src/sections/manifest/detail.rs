//! Levels of detail for fur that is small on screen.

use serde::{Deserialize, Serialize};

/// Far layer: its height and lighting, as means over the hair that is visible from above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FarLayerInfo {
    /// Height of the surface drawn with the far layer, as a share of the fur's height, 0..=1. At this height, its
    /// outline is as wide as that of the layers.
    pub height: f32,
    /// Height, as a share of the fur's height, at which the ambient attenuation γ equals the mean over the visible
    /// hair, 0..=1.
    pub ambient_height: f32,
    /// Mean share of the key light that reaches the visible hair if the light arrives along the normal, 0..=1: t of
    /// Yang 2006, eq. (2).
    pub light_straight: f32,
    /// Mean share of the key light that reaches the visible hair if the path through each layer is four times as long,
    /// 0..=[`FarLayerInfo::light_straight`].
    pub light_slanted: f32,
}

/// Level of detail, for a range of heights of the fur on screen.
///
/// Between `full_px` and `gone_px`, a level and the next are cross-faded. `full_px` decreases from level to level. Each
/// level is gone before the next begins to fade, or at the same height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DetailLevel {
    /// Step between drawn layers, from the outermost inwards; each drawn layer represents `step` layers. A power of
    /// two: 1 in the first level, and twice that of the previous level in the others. The last level may have 0: it
    /// draws no layers, but the far layer on the surface.
    pub step: u32,
    /// Minimum height of the fur on screen at which the level is drawn without fading, pixels; 0 in the last level.
    pub full_px: f32,
    /// Maximum height of the fur on screen at which only the next level is drawn, pixels, at most `full_px`; 0 in the
    /// last level.
    pub gone_px: f32,
    /// Factor on the fins' opacity, 0..=1. With 0, fins are not drawn.
    pub fins: f32,
    /// Factor on the number of layers that each layer represents, above 0; 1 in the first level. It preserves the mean
    /// optical depth of the fur: a drawn layer also represents layers below it, in which hair is thicker.
    pub density: f32,
}

impl FarLayerInfo {
    /// Checks that every value is in its range.
    pub(super) fn check(&self) -> Result<(), String> {
        for (what, value, max) in [
            ("height", self.height, 1.0),
            ("ambient_height", self.ambient_height, 1.0),
            ("light_straight", self.light_straight, 1.0),
            ("light_slanted", self.light_slanted, self.light_straight),
        ] {
            // NaN is outside every range.
            if !(0.0..=max).contains(&value) {
                return Err(format!("coat.{what} is {value}, expected 0..={max}"));
            }
        }
        Ok(())
    }
}

/// Checks that the levels form a chain from all layers down to the coarsest level that the package can have, given its
/// layer count and whether it has a far layer.
pub(super) fn check(levels: &[DetailLevel], layers: u32, has_coat: bool) -> Result<(), String> {
    if !levels.is_empty() && layers == 0 {
        return Err(format!("detail has {} levels, expected none without fur", levels.len()));
    }
    let mut step = 1;
    let mut ceiling = f32::MAX;
    for (i, level) in levels.iter().enumerate() {
        let last = i + 1 == levels.len();
        let fail = |field: &str, found: f32, expected: String| {
            Err(format!("detail[{i}].{field} is {found}, expected {expected}"))
        };
        let coat = last && i > 0 && level.step == 0;
        if coat && !has_coat {
            return Err(format!("detail[{i}].step is 0, expected above 0 in a package without far layer (coat)"));
        }
        if !coat && level.step != step {
            return Err(format!("detail[{i}].step is {}, expected {step}, or 0 in the last level", level.step));
        }
        // 2^32 is not a valid step, but exceeds every number of layers, so the chain ends before it.
        step = step.checked_mul(2).unwrap_or(0);
        if last && (level.full_px != 0.0 || level.gone_px != 0.0) {
            return fail("full_px", level.full_px, "0 for full_px and gone_px in the last level".into());
        }
        // NaN is outside every range.
        let falls = level.full_px > 0.0 && level.full_px <= ceiling;
        if !last && !falls {
            return fail(
                "full_px",
                level.full_px,
                format!("more than 0 and at most {ceiling} (in the first level any number, else the previous gone_px)"),
            );
        }
        if !(level.gone_px >= 0.0 && level.gone_px <= level.full_px) {
            return fail("gone_px", level.gone_px, format!("0 to full_px, {}", level.full_px));
        }
        if !(0.0..=1.0).contains(&level.fins) {
            return fail("fins", level.fins, "0..=1".into());
        }
        if !(level.density > 0.0 && level.density.is_finite()) || (i == 0 && level.density != 1.0) {
            return fail("density", level.density, if i == 0 { "1".into() } else { "a finite number above 0".into() });
        }
        ceiling = level.gone_px;
    }
    Ok(())
}
