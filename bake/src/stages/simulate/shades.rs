//! Colour of a hair from root to tip.

use crate::recipe::{ColorParams, HairColors, SrgbColor};
use glam::Vec3;

/// Largest offset of a hair's band from the recipe's position, as a share of the hair's length. A ring would show if
/// all hairs were banded at the same height.
const BAND_STRAYS: f32 = 0.08;

/// Colours of one kind of hair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shades {
    /// Root colour, linear RGB.
    pub(super) root: Vec3,
    tip: Vec3,
    band: Option<Band>,
}

/// Band of another colour, as hairs of wild animals have (agouti).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Band {
    color: Vec3,
    /// Centre, as a share of the hair's length.
    at: f32,
    /// Width, as a share of the hair's length.
    width: f32,
}

impl Shades {
    /// Returns the colours of guard hair, brown if the recipe gives none. `water`: share of the light that a film of
    /// water transmits.
    pub(super) fn new(color: &ColorParams, water: f32) -> Self {
        let band = |band| Band { color: linear(band) * water, at: color.band_at, width: color.band_width };
        let HairColors { root, tip, .. } = color.hair(HairColors::BROWN);
        Self { root: linear(root) * water, tip: linear(tip) * water, band: color.band.map(band) }
    }

    /// Replaces colours by those that the recipe gives for underfur, and removes the band.
    pub(super) fn with_underfur_colors(self, root: Option<SrgbColor>, tip: Option<SrgbColor>, water: f32) -> Self {
        let own = |color: Option<SrgbColor>, else_: Vec3| color.map_or(else_, |color| linear(color) * water);
        Self { root: own(root, self.root), tip: own(tip, self.tip), band: None }
    }

    /// Returns the colour at share `t` of a hair's length, linear RGB. `stray` is the band offset of the hair, in
    /// -1..1.
    pub(super) fn at(&self, t: f32, stray: f32) -> Vec3 {
        let plain = self.root + (self.tip - self.root) * t;
        let Some(band) = self.band else { return plain };
        let aside = (t - band.at - BAND_STRAYS * stray).abs() / (0.5 * band.width);
        plain.lerp(band.color, crate::noise::smooth((1.5 - aside).clamp(0.0, 1.0)))
    }
}

/// Converts an sRGB colour to linear RGB (IEC 61966-2-1).
pub fn linear(color: SrgbColor) -> Vec3 {
    Vec3::from(color.0.map(pelage_formats::meaning::srgb_value_to_linear))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn band_colours_only_its_own_range() {
        let color = ColorParams {
            band: Some(SrgbColor::hex(0xff_ff_ff)),
            band_at: 0.7,
            band_width: 0.2,
            ..ColorParams::default()
        };
        let (banded, plain) = (Shades::new(&color, 1.0), Shades::new(&ColorParams::default(), 1.0));
        assert_eq!(banded.at(0.7, 0.0), Vec3::ONE);
        assert_eq!((banded.at(0.5, 0.0), banded.at(0.9, 0.0)), (plain.at(0.5, 0.0), plain.at(0.9, 0.0)));
        // The band's border is half of each colour.
        let border = banded.at(0.6, 0.0);
        assert!((border - plain.at(0.6, 0.0).midpoint(Vec3::ONE)).length() < 1e-5, "{border}");
        assert_ne!(banded.at(0.6, 1.0), banded.at(0.6, -1.0));
    }

    #[test]
    fn underfur_colours_default_to_guard_hair() {
        let guard = Shades::new(&ColorParams::default(), 1.0);
        assert_eq!(guard.with_underfur_colors(None, None, 1.0), Shades { band: None, ..guard });
        let white = guard.with_underfur_colors(None, Some(SrgbColor::hex(0xff_ff_ff)), 0.5);
        assert_eq!((white.root, white.at(1.0, 0.0)), (guard.root, Vec3::splat(0.5)));
    }
}
