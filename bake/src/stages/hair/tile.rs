//! All the hair of a coat's tile, as a resolved recipe describes it: the one place where a bake and the traced truth get their strands from.

use super::styles::{StyleForces, WET};
use super::{Strands, VolumeParams, simulate_coats};
use crate::recipe::{HairParams, Recipe, Style};
use crate::stages::groom::{Lengths, Water};
use pelage_import::BakeError;

/// The strands of one tile: dry, and where the coat is wet in places the same hairs wet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileHair {
    /// The strands, or all that there are.
    pub strands: Strands,
    /// The same hairs when wet, as high as `strands`; `None` where the coat is dry or wet all over.
    pub wet: Option<Strands>,
    /// Style of `strands`.
    pub style: Style,
}

impl TileHair {
    /// Grows them.
    ///
    /// # Errors
    /// [`BakeError::Params`] for a value outside its range.
    pub fn grow(recipe: &Recipe, lengths: Lengths, water: Water) -> Result<Self, BakeError> {
        let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
        let style = if water == Water::Wet { WET } else { recipe.hair.style };
        let grow = |style| simulate_of(recipe, style, &volume);
        let mut strands = grow(style)?;
        let mut wet = if water == Water::Mixed && !StyleForces::of(style).wet { Some(grow(WET)?) } else { None };
        if let Some(wet) = &mut wet {
            // Layers that are mixed lie at the same heights.
            strands.height = strands.height.max(wet.height);
            wet.height = strands.height;
        }
        Ok(Self { strands, wet, style })
    }
}

/// The strands of a recipe's tile, both coats, in that style of guard hair.
fn simulate_of(recipe: &Recipe, style: Style, volume: &VolumeParams) -> Result<Strands, BakeError> {
    let hair = HairParams { style, ..recipe.hair.clone() };
    simulate_coats(&hair, &recipe.underfur, &recipe.color, volume)
}

/// The dry or wet strands of a recipe's tile, as its style says.
///
/// # Errors
/// [`BakeError::Params`] for a value outside its range.
pub fn simulate_recipe(recipe: &Recipe, volume: &VolumeParams) -> Result<Strands, BakeError> {
    simulate_of(recipe, recipe.hair.style, volume)
}
