//! What a recipe says about the hair on single joints: `[[groom.joint]]`.

use super::material_groom::{DENSITY, SHARE};
use super::named_table::named_table;

named_table! {
    /// The groom of the skin that follows the joints that `name` matches, and those that hang on them. `*` stands for any characters, `?` for one.
    JointGroom of "a joint" {
        /// In place of `groom.length`.
        length: f32, in SHARE;
        /// In place of `groom.density`.
        density: f32, in DENSITY;
        /// In place of `groom.lean`.
        lean: f32, in SHARE;
        /// In place of `groom.wetness`; added to it where that is an image.
        wetness: f32, in SHARE;
        /// In place of `groom.bare`; where that is an image, hair grows where neither is bare.
        bare: f32, in SHARE;
    }
}
