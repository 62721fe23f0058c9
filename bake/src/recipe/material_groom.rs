//! Groom and gloss of single materials: `[[groom.material]]`, `[[shading.material]]`.

use super::maps::{ColorMap, ScalarMap, VectorMap};
use super::named_table::named_table;
use pelage_formats::Gloss;
use pelage_params::{Range, SrgbColor};

/// Range of maps that are fractions, such as length.
pub(super) const SHARE: Range<f32> = 0.0..=1.0;
/// Range of the density map.
pub(super) const DENSITY: Range<f32> = 0.25..=4.0;

named_table! {
    /// Gloss of the bare surface of the materials that `name` matches. On a furred material, the skin between hairs is
    /// glossy.
    MaterialGloss of "a material" {
        /// Roughness as in glTF: 0.04 is a mirror, 1 dull. If left out, eyes have 0.06, noses 0.4, other materials that
        /// of the model or 0.5.
        roughness: f32, in Gloss::ROUGHNESS;
        /// Share of the light from straight ahead that is reflected; 0 removes the gloss. If left out, eyes have 0.025,
        /// noses 0.035, others 0.04.
        reflectance: f32, in SHARE;
    }
}

named_table! {
    /// Groom of the materials that `name` matches; overrides `[groom]`. Later tables take precedence.
    MaterialGroom of "a material" {
        /// Overrides `groom.length`.
        length: ScalarMap, in SHARE;
        /// Overrides `groom.density`.
        density: ScalarMap, in DENSITY;
        /// Overrides `groom.lean`.
        lean: ScalarMap, in SHARE;
        /// Overrides `groom.comb`.
        comb: VectorMap, in ();
        /// Overrides `groom.wetness`.
        wetness: ScalarMap, in SHARE;
        /// Overrides `groom.bare`.
        bare: ScalarMap, in SHARE;
        /// Overrides `groom.color`.
        color: ColorMap, in ();
        /// Overrides `groom.hair_color`.
        hair_color: SrgbColor, in ();
    }
}
