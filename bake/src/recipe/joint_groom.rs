//! Groom of the hair on single joints: `[[groom.joint]]`.

use super::material_groom::{DENSITY, SHARE};
use super::named_table::named_table;

named_table! {
    /// Groom of the mesh surface that follows the joints matched by `name`, and their descendants. In `name`, `*`
    /// matches any characters and `?` one.
    JointGroom of "a joint" {
        /// Overrides `groom.length`.
        length: f32, in SHARE;
        /// Overrides `groom.density`.
        density: f32, in DENSITY;
        /// Overrides `groom.lean`.
        lean: f32, in SHARE;
        /// Overrides `groom.wetness`; if that is an image, the two are added.
        wetness: f32, in SHARE;
        /// Overrides `groom.bare`. If that is an image, hair grows only where neither is bare.
        bare: f32, in SHARE;
    }
}
