//! What a recipe says about the hair of single materials: `[[groom.material]]`.

use super::maps::{ColorMap, ScalarMap, VectorMap};
use super::named_table::named_table;
use pelage_params::Range;

/// Range of maps that are shares.
pub(super) const SHARE: Range<f32> = 0.0..=1.0;
/// Range of the density map.
pub(super) const DENSITY: Range<f32> = 0.25..=4.0;

named_table! {
    /// The groom of the materials that `name` matches: what is given here stands in for what `[groom]` says. Later tables win.
    MaterialGroom of "a material" {
        /// As `groom.length`.
        length: ScalarMap, in SHARE;
        /// As `groom.density`.
        density: ScalarMap, in DENSITY;
        /// As `groom.lean`.
        lean: ScalarMap, in SHARE;
        /// As `groom.comb`.
        comb: VectorMap, in ();
        /// As `groom.wetness`.
        wetness: ScalarMap, in SHARE;
        /// As `groom.bare`.
        bare: ScalarMap, in SHARE;
        /// As `groom.color`.
        color: ColorMap, in ();
    }
}
