//! Comb marks in a recipe: `surface.comb_marks`.

use super::material_groom::{DENSITY, SHARE};
use super::named_table::named_table;
use pelage_params::{Range, SrgbColor};

/// Range of coordinates, metres.
const PLACE: Range<f32> = -1e6..=1e6;

named_table! {
    /// Hair properties and comb direction near a point. A mark needs `at` and at least one property.
    CombMarkParams of "a mark" checked by check_mark {
        /// Position near the mesh surface, metres in world space at rest. Required.
        at: [f32; 3], in PLACE;
        /// Comb direction, any length but 0. Used if `surface.comb` is `"marks"`. With `"auto"`, a mark with a
        /// direction selects `marks`.
        direction: [f32; 3], in PLACE;
        /// Hair length, as a share of `hair.length_m`; overrides `[groom]`.
        length: f32, in SHARE;
        /// Hairs per area relative to the rest of the fur; overrides `[groom]`.
        density: f32, in DENSITY;
        /// Extra lean; overrides `[groom]`.
        lean: f32, in SHARE;
        /// sRGB colour of the hair, instead of the model's or `groom.color`; root and tip colour are multiplied by it.
        /// On a material with a texture, the texture is multiplied by it instead.
        color: SrgbColor, in ();
        /// Reach along the surface, metres. The effect is full within a quarter of it, then fades to none. Default:
        /// three tenths of the model's radius; for the direction, the distance to the next mark.
        reach_m: f32, in 1e-6..=1e6;
        /// Whether the mark also applies at its position mirrored in x.
        mirrored: bool = false, in ();
    }
}

fn check_mark(mark: &CombMarkParams) -> Result<(), String> {
    if mark.at.is_none() {
        return Err("found no `at`, expected a position, [x, y, z] in metres".into());
    }
    if mark.direction == Some([0.0; 3]) {
        return Err("direction: found [0, 0, 0], expected a vector that is not zero".into());
    }
    let says = mark.direction.is_some() || mark.color.is_some();
    if !says && [mark.length, mark.density, mark.lean].iter().all(Option::is_none) {
        return Err("found none of direction, length, density, lean and color, expected at least one".into());
    }
    Ok(())
}

impl CombMarkParams {
    /// Returns the mark and, if it is mirrored, its mirror image.
    pub fn with_mirror_image(&self) -> impl Iterator<Item = Self> + use<> {
        let turned = |v: [f32; 3]| [-v[0], v[1], v[2]];
        let mirrored = self.mirrored().then(|| Self {
            at: self.at.map(turned),
            direction: self.direction.map(turned),
            ..self.clone()
        });
        std::iter::once(self.clone()).chain(mirrored)
    }
}

#[cfg(test)]
#[path = "comb_marks_tests.rs"]
mod tests;
