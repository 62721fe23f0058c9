//! Comb marks in a recipe: `surface.comb_marks`.

use super::material_groom::{DENSITY, SHARE};
use super::named_table::named_table;
use pelage_params::{Range, SrgbColor};

/// Range of coordinates, metres.
const PLACE: Range<f32> = -1e6..=1e6;

named_table! {
    /// What hair is like at a place, and where it is combed to there. A mark has a place and says at least one thing.
    CombMarkParams of "a mark" checked by is_whole {
        /// Place near the skin, metres in world space at rest. Required.
        at: [f32; 3], in PLACE;
        /// Where hair is combed to there: any length but 0. It counts with `surface.comb = "marks"`, which is what `auto` is where a mark has one.
        direction: [f32; 3], in PLACE;
        /// Length there, share of `hair.length_m`, in place of what `[groom]` says.
        length: f32, in SHARE;
        /// Hairs per area there, likewise.
        density: f32, in DENSITY;
        /// Extra lean there, likewise.
        lean: f32, in SHARE;
        /// Colour there in place of the model's or `groom.color`: an sRGB colour, which multiplies root and tip colour. A material with a texture is multiplied
        /// by it instead.
        color: SrgbColor, in ();
        /// How far it reaches along the skin, metres: in full within a quarter of that, then less and less (for values three tenths of the model's radius, for
        /// the direction as far as there is no other mark). Beyond, hair is as it would be without.
        reach_m: f32, in 1e-6..=1e6;
        /// Whether the same stands on the other side, x turned about.
        mirrored: bool = false, in ();
    }
}

fn is_whole(mark: &CombMarkParams) -> Result<(), String> {
    if mark.at.is_none() {
        return Err("found no at, expected a place, [x, y, z] in metres".into());
    }
    if mark.direction == Some([0.0; 3]) {
        return Err("direction: found [0, 0, 0], expected a direction".into());
    }
    let says = mark.direction.is_some() || mark.color.is_some();
    if !says && [mark.length, mark.density, mark.lean].iter().all(Option::is_none) {
        return Err("found neither direction nor length, density, lean and color, expected at least one".into());
    }
    Ok(())
}

impl CombMarkParams {
    /// The mark, and where it is mirrored its likeness on the other side.
    pub fn with_likeness(&self) -> impl Iterator<Item = Self> + use<> {
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
