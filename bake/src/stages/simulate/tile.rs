//! All hair of a tile, as a resolved recipe describes it. It is the only source of strands for a bake and for the
//! ray-traced reference.

use super::styles::{StyleForces, WET};
use super::{Strands, VolumeParams, simulate_with_underfur};
use crate::recipe::{HairParams, Recipe, Style};
use crate::stages::groom::{FurWetness, Lengths};
use pelage_import::BakeError;

/// Strands of one tile: dry, and also wet if only parts of the fur are wet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileHair {
    /// Dry strands; the only strands if the fur is dry or wet everywhere.
    pub strands: Strands,
    /// The hairs of `strands` when wet, with the same height; `None` if the fur is dry or wet everywhere.
    pub wet: Option<Strands>,
    /// Style of `strands`.
    pub style: Style,
}

impl TileHair {
    /// Grows the strands.
    ///
    /// Fails with [`BakeError::Params`] for a value outside its range.
    pub fn grow(recipe: &Recipe, lengths: Lengths, water: FurWetness) -> Result<Self, BakeError> {
        let volume = VolumeParams { height: lengths.length_m / lengths.tile_size_m };
        let style = if water == FurWetness::Wet { WET } else { recipe.hair.style };
        let grow = |style| simulate_with_style(recipe, style, &volume);
        let mut strands = grow(style)?;
        let mut wet = if water == FurWetness::Mixed && !StyleForces::of(style).wet { Some(grow(WET)?) } else { None };
        if let Some(wet) = &mut wet {
            // Dry and wet layers can only be mixed if they have the same heights.
            strands.height = strands.height.max(wet.height);
            wet.height = strands.height;
        }
        Ok(Self { strands, wet, style })
    }
}

/// Grows guard hair and underfur of a recipe's tile, with guard hair in the given style.
fn simulate_with_style(recipe: &Recipe, style: Style, volume: &VolumeParams) -> Result<Strands, BakeError> {
    let hair = HairParams { style, ..recipe.hair.clone() };
    simulate_with_underfur(&hair, &recipe.underfur, &recipe.color, volume)
}

/// Grows the strands of a recipe's tile, dry or wet according to its style.
///
/// Fails with [`BakeError::Params`] for a value outside its range.
pub fn simulate_recipe(recipe: &Recipe, volume: &VolumeParams) -> Result<Strands, BakeError> {
    simulate_with_style(recipe, recipe.hair.style, volume)
}
