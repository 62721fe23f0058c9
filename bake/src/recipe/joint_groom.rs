//! Groom of the hair on single joints: `[[groom.joint]]`.

use super::material_groom::{DENSITY, SHARE};
use super::named_table::named_table;

named_table! {
    /// Groom of the mesh surface that follows the joints that `name` matches, and their descendants. `*` matches any
    /// characters, `?` one.
    JointGroom of "a joint" {
        /// Overrides `groom.length`.
        length: f32, in SHARE;
        /// Overrides `groom.density`.
        density: f32, in DENSITY;
        /// Overrides `groom.lean`.
        lean: f32, in SHARE;
        /// Overrides `groom.wetness`; added to it if that is an image.
        wetness: f32, in SHARE;
        /// Overrides `groom.bare`; if that is an image, hair grows only where neither is bare.
        bare: f32, in SHARE;
    }
}
