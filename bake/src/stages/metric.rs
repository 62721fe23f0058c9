//! Conversion of metric hair settings (hairs per square millimetre, radii in metres) to units of the tile.
//!
//! A tile holds some thousands of strands, and its texels should not be wider than a hair. If the recipe does not set
//! the tile's width, the tile is as wide as both limits permit. A narrow tile repeats more often, and covers fewer
//! pixels than its number of strands justifies.

use super::groom::Lengths;
use crate::decision::{Decision, metres_in_words};
use crate::recipe::{Recipe, SurfaceSource};
use pelage_formats::Bounds;
use pelage_import::BakeError;

/// Minimum width of a hair at its root, texels. A hair thinner than this fades in every mip level, which makes the fur
/// too transparent.
pub const LEAST_HAIR_TEXELS: f64 = 1.0;
/// Maximum number of strands in a tile whose width is derived. With more strands, the tile would repeat less often, but
/// baking would take longer.
const MOST_STRANDS: f64 = 20_000.0;
/// Square millimetres per square metre.
const MM2: f64 = 1e6;

/// Recipe converted to units of its tile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TileRecipe {
    /// Converted recipe, without densities per square millimetre and radii in metres.
    pub recipe: Recipe,
    /// Decisions made for the conversion.
    pub decisions: Vec<Decision>,
    /// Warnings about settings that the tile cannot represent.
    pub warnings: Vec<String>,
}

/// Returns whether a recipe gives a density per square millimetre or a radius in metres.
pub fn is_metric(recipe: &Recipe) -> bool {
    let (hair, under) = (&recipe.hair, &recipe.underfur);
    let radii = [hair.root_radius_m, hair.tip_radius_m, under.root_radius_m, under.tip_radius_m];
    let densities = [hair.density_mm2, under.density_mm2];
    radii.iter().chain(&densities).any(Option::is_some)
}

/// Converts densities and radii to units of the tile. Chooses the width of the tile if the recipe does not set it.
/// Settings already in units of the tile are unchanged.
///
/// * `bounds`: bounds of the model at rest, metres
///
/// Fails with [`BakeError::Params`] if a tile of the width set in the recipe cannot hold the hair. The message contains
/// the key, what was found and what would be possible.
pub fn to_tile_units(recipe: &Recipe, bounds: &Bounds) -> Result<TileRecipe, BakeError> {
    let mut done = TileRecipe { recipe: recipe.clone(), ..TileRecipe::default() };
    if !is_metric(recipe) {
        return Ok(done);
    }
    let (tile_size_m, why) = tile_size(recipe, bounds);
    let told = &mut done.recipe;
    if recipe.surface.tile_size_m.is_none() {
        told.surface.tile_size_m = Some(tile_size_m);
        let chosen = format!("{}, {why}", metres_in_words(tile_size_m));
        done.decisions.push(Decision {
            what: "width of tile",
            chosen,
            line: format!("surface.tile_size_m = {tile_size_m}"),
        });
        scale_reaches(told, Lengths::resolve(recipe, bounds).tile_size_m / tile_size_m, &mut done.decisions);
    }
    let (hair, under) = (&mut told.hair, &mut told.underfur);
    let radii = [
        ("hair.root_radius_m", hair.root_radius_m.take(), &mut hair.root_radius, 1e-5),
        ("hair.tip_radius_m", hair.tip_radius_m.take(), &mut hair.tip_radius, 0.0),
        ("underfur.root_radius_m", under.root_radius_m.take(), &mut under.root_radius, 1e-5),
        ("underfur.tip_radius_m", under.tip_radius_m.take(), &mut under.tip_radius, 0.0),
    ];
    for (key, radius_m, radius, least) in radii {
        if let Some(radius_m) = radius_m {
            *radius = share_of_tile(key, radius_m, tile_size_m, least)?;
        }
    }
    let densities = [
        ("hair.density_mm2", "strands in the tile", hair.density_mm2.take(), &mut hair.density, "hair.density"),
        (
            "underfur.density_mm2",
            "underfur in the tile",
            under.density_mm2.take(),
            &mut under.density,
            "underfur.density",
        ),
    ];
    for (key, what, per_mm2, density, own_key) in densities {
        let Some(per_mm2) = per_mm2 else { continue };
        *density = strands(key, per_mm2, tile_size_m)?;
        let chosen = format!("{density}, {per_mm2} per mm² on {} of skin", format_area(area_m2(tile_size_m)));
        done.decisions.push(Decision { what, chosen, line: format!("{own_key} = {density}") });
    }
    done.warnings.extend(too_thin(recipe, &done.recipe, tile_size_m));
    Ok(done)
}

/// Returns the tile's width, metres, and the reason for it.
fn tile_size(recipe: &Recipe, bounds: &Bounds) -> (f32, String) {
    let ordinary = Lengths::resolve(recipe, bounds).tile_size_m;
    if recipe.surface.tile_size_m.is_some() {
        return (ordinary, String::new());
    }
    let mut found = (f64::from(ordinary), "from the model's size".to_owned());
    let mut at_most = |size_m: f64, why: String| {
        if size_m < found.0 {
            found = (size_m, why);
        }
    };
    let (mut per_mm2, mut fixed) = (0.0, 0.0);
    for (metric, in_tile) in
        [(recipe.hair.density_mm2, recipe.hair.density), (recipe.underfur.density_mm2, recipe.underfur.density)]
    {
        match metric {
            Some(metric) => per_mm2 += f64::from(metric),
            None => fixed += f64::from(in_tile),
        }
    }
    if per_mm2 > 0.0 {
        let strands = (MOST_STRANDS - fixed).max(1.0);
        at_most((strands / per_mm2 / MM2).sqrt(), format!("which holds {MOST_STRANDS:.0} strands"));
    }
    if let Some(width_m) = hair_width_m(recipe) {
        let texels = recipe.slice.tile_texels;
        let size_m = width_m * f64::from(texels) / LEAST_HAIR_TEXELS;
        at_most(
            size_m,
            format!("at which each of {texels} texels is as wide as a hair of {}", metres_in_words(width_m as f32)),
        );
    }
    (found.0 as f32, found.1)
}

/// Returns the width at the root, metres, if the recipe gives a radius in metres: that of guard hair, or else that of
/// underfur, which is finer.
pub fn hair_width_m(recipe: &Recipe) -> Option<f64> {
    let radius_m = recipe.hair.root_radius_m.or(recipe.underfur.root_radius_m)?;
    Some(2.0 * f64::from(radius_m))
}

/// Scales the reach of patches and comb, in tiles, so that both keep the length in metres that they have with the
/// default tile. The default tile is derived from the model's size.
///
/// * `times`: width of the default tile divided by that of the chosen tile; at least 1
fn scale_reaches(recipe: &mut Recipe, times: f32, decisions: &mut Vec<Decision>) {
    let surface = &mut recipe.surface;
    if times <= 1.0 || surface.source != SurfaceSource::Patches {
        return;
    }
    surface.patch_size = (surface.patch_size * times).min(1000.0);
    surface.comb_smoothing = (surface.comb_smoothing * times).min(100.0);
    for (what, key, tiles) in [
        ("reach of patches", "patch_size", surface.patch_size),
        ("reach of the comb", "comb_smoothing", surface.comb_smoothing),
    ] {
        let chosen = format!(
            "{tiles} tiles, the same in metres as with the default tile, which is {times:.1} times \
             as wide"
        );
        decisions.push(Decision { what, chosen, line: format!("surface.{key} = {tiles}") });
    }
}

fn share_of_tile(key: &'static str, radius_m: f32, tile_size_m: f32, least: f32) -> Result<f32, BakeError> {
    let share = radius_m / tile_size_m;
    if (least..=0.25).contains(&share) {
        return Ok(share);
    }
    let [low, high] = [least, 0.25].map(|share| metres_in_words(share * tile_size_m));
    let reason = format!(
        "found {}, expected {low} to {high} for a tile {} wide; surface.tile_size_m sets that width",
        metres_in_words(radius_m),
        metres_in_words(tile_size_m)
    );
    Err(BakeError::Params { what: key, reason })
}

fn strands(key: &'static str, per_mm2: f32, tile_size_m: f32) -> Result<u32, BakeError> {
    /// Same limit as `hair.density`.
    const MOST: f64 = 1e6;
    let area_mm2 = area_m2(tile_size_m) * MM2;
    let strands = (f64::from(per_mm2) * area_mm2).round();
    if (1.0..=MOST).contains(&strands) || per_mm2 == 0.0 {
        return Ok(strands as u32);
    }
    let reason = format!(
        "found {per_mm2} hairs per mm², which are {strands} strands in a tile {} wide, expected {:.3e} to {:.3e} per \
         mm² for 1 to {MOST} strands; surface.tile_size_m sets that width",
        metres_in_words(tile_size_m),
        1.0 / area_mm2,
        MOST / area_mm2
    );
    Err(BakeError::Params { what: key, reason })
}

/// Returns a warning if hair is thinner than the texels of its tile.
///
/// * `said`: original recipe
/// * `recipe`: recipe in units of its tile
fn too_thin(said: &Recipe, recipe: &Recipe, tile_size_m: f32) -> Option<String> {
    let width_m = hair_width_m(said)?;
    let texels = recipe.slice.tile_texels;
    let texel_m = f64::from(tile_size_m) / f64::from(texels);
    // Half a percent of tolerance covers the rounding of the tile's width.
    if width_m >= 0.995 * LEAST_HAIR_TEXELS * texel_m {
        return None;
    }
    let enough = f64::from(tile_size_m) * LEAST_HAIR_TEXELS / width_m;
    let finer = Some(enough.ceil() as u32).filter(|n| *n <= 2048).map(u32::next_power_of_two);
    let finer = finer.map_or_else(String::new, |n| format!("slice.tile_texels = {n} or "));
    Some(format!(
        "hair is {} wide, but a texel of its tile is {}, so layers draw it too faint; {finer}surface.tile_size_m = \
         {:.2e} would resolve it",
        metres_in_words(width_m as f32),
        metres_in_words(texel_m as f32),
        width_m * f64::from(texels) / LEAST_HAIR_TEXELS
    ))
}

fn area_m2(side_m: f32) -> f64 {
    f64::from(side_m) * f64::from(side_m)
}

fn format_area(m2: f64) -> String {
    if m2 < 1e-2 { format!("{:.1} mm²", m2 * MM2) } else { format!("{m2:.3} m²") }
}

#[cfg(test)]
#[path = "metric_tests.rs"]
mod tests;
