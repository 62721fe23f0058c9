//! Layer count and tile size for pictures of a known size.

use super::advice::MOST_LAYERS;
use super::prognosis::OnScreen;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::metric::LEAST_HAIR_TEXELS;

/// Returns the recipe with the number of layers and texels that a picture with the sizes of `on_screen` can show.
///
/// Layers are [`pelage_bake::recipe::DetailParams::gap_px`] apart, up to the maximum that is advised. A texel is at
/// most one pixel wide, and at most as wide as a hair at its root.
///
/// * `on_screen`: sizes on the screen of a package made by this recipe
/// * `tile_texels`: width of that package's tile, texels
pub fn fitted(recipe: &Recipe, on_screen: &OnScreen, tile_texels: u32) -> Recipe {
    let mut fitted = recipe.clone();
    let gaps = on_screen.height_px / f64::from(recipe.detail.gap_px);
    fitted.slice.layers = (gaps.ceil().clamp(0.0, f64::from(MOST_LAYERS)) as u32 + 1).clamp(4, MOST_LAYERS);
    let shown = f64::from(tile_texels) * on_screen.texel_px;
    let of_hair = LEAST_HAIR_TEXELS / (2.0 * f64::from(recipe.hair.root_radius)).max(1e-6);
    let texels = shown.max(of_hair).ceil().clamp(16.0, 2048.0);
    fitted.slice.tile_texels = (texels as u32).next_power_of_two();
    fitted
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_bake::recipe::natural;

    #[test]
    fn fitted_settings_follow_the_sizes_on_screen() {
        let recipe = natural();
        let at = |height_px, texel_px| {
            let fitted = fitted(&recipe, &OnScreen { height_px, texel_px, ..OnScreen::default() }, 128);
            (fitted.slice.layers, fitted.slice.tile_texels)
        };
        assert_eq!(at(11.4, 0.75), (11, 128));
        assert_eq!(at(22.8, 1.5), (21, 256), "the sizes on the screen are twice as large");
        assert_eq!(at(1e4, 1e4), (64, 2048), "counts must not exceed the advised maximum");
        assert_eq!(recipe.hair.root_radius, 0.009, "the radius is relative to the tile");
        assert_eq!(at(0.0, 0.0), (4, 64), "a texel must not be wider than a root");
        assert_eq!(Recipe { slice: recipe.slice.clone(), ..fitted(&recipe, &OnScreen::default(), 128) }, recipe);
    }
}
