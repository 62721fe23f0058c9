//! Groom of the hair on single materials: `[[groom.material]]`.

use super::maps::{ColorMap, ScalarMap, VectorMap};
use super::named_table::named_table;
use pelage_params::{Range, SrgbColor};

/// Range of maps that are fractions, such as length.
pub(super) const SHARE: Range<f32> = 0.0..=1.0;
/// Range of the density map.
pub(super) const DENSITY: Range<f32> = 0.25..=4.0;

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
