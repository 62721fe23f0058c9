//! Comparison of the recipe recorded in a package with its fur.

use crate::recipe::Recipe;
use pelage_formats::Manifest;

/// Key of a recorded recipe that does not match the package.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mismatch {
    /// Name of the key in the form used by `--set`: `hair.density`.
    pub key: &'static str,
    /// Value in the recipe, and value found in the package.
    pub reason: String,
}

/// Returns the keys whose recorded values do not match the package's fur, because the recipe was edited after the bake
/// or belongs to another package. Only keys in the text are compared, because defaults differ between versions.
///
/// Returns nothing for an invalid recipe, whose errors [`Recipe::parse`] reports.
pub fn mismatches(manifest: &Manifest, text: &str) -> Vec<Mismatch> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let (Ok(recipe), Ok(named)) = (Recipe::parse_recorded("recipe", text), text.parse::<toml::Table>()) else {
        return Vec::new();
    };
    let fur = &manifest.fur;
    let tile_size_m = recipe.surface.tile_size_m.unwrap_or(fur.tile_size_m);
    // The strand count in the package includes underfur.
    let guard_hairs = fur.strands.saturating_sub(recipe.underfur.density);
    let facts = [
        ("hair.density", recipe.hair.density.to_string(), guard_hairs.to_string(), "strands in the tile"),
        ("slice.layers", recipe.slice.layers.to_string(), fur.layers.to_string(), "layers"),
        ("slice.tile_texels", recipe.slice.tile_texels.to_string(), fur.tile_texels.to_string(), "texels each way"),
        ("surface.tile_size_m", tile_size_m.to_string(), fur.tile_size_m.to_string(), "metres per tile"),
    ];
    let is_named = |key: &str| {
        let (table, key) = key.split_once('.').unwrap_or_default();
        named.get(table).and_then(|table| table.get(key)).is_some()
    };
    // A package without hair records no data about fur.
    let has_fur = fur.layers > 0;
    let differs = |(key, said, found, _): &(&str, String, String, &str)| has_fur && said != found && is_named(key);
    facts
        .into_iter()
        .filter(differs)
        .map(|(key, said, found, what)| Mismatch {
            key,
            reason: format!("is {said}, expected {found}: the fur in the package has {found} {what}"),
        })
        .collect()
}
