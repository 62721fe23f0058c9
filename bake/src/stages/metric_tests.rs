use super::*;

fn bounds(radius: f32) -> Bounds {
    Bounds { radius, ..Bounds::default() }
}

fn recipe(sets: &[&str]) -> Recipe {
    let mut recipe = crate::recipe::natural();
    sets.iter().for_each(|set| recipe.set(set).unwrap());
    recipe
}

fn refused(sets: &[&str]) -> String {
    to_tile_units(&recipe(sets), &bounds(0.5)).unwrap_err().to_string()
}

#[test]
fn recipes_without_metric_values_are_unchanged() {
    let own = recipe(&["hair.density=900", "hair.root_radius=0.01"]);
    assert_eq!(to_tile_units(&own, &bounds(0.5)).unwrap(), TileRecipe { recipe: own, ..TileRecipe::default() });
}

#[test]
fn strand_count_of_a_fixed_tile_follows_its_area() {
    let own = recipe(&["hair.density_mm2=2", "underfur.density_mm2=0.5", "surface.tile_size_m=0.05"]);
    let found = to_tile_units(&own, &bounds(0.5)).unwrap();
    assert_eq!((found.recipe.hair.density, found.recipe.underfur.density), (5000, 1250));
    assert_eq!((found.recipe.hair.density_mm2, found.recipe.underfur.density_mm2), (None, None));
    assert_eq!(found.recipe.surface, own.surface, "nothing of it was open");
    let said: Vec<&str> = found.decisions.iter().map(|d| d.line.as_str()).collect();
    assert_eq!(said, ["hair.density = 5000", "underfur.density = 1250"]);
    assert_eq!(found.decisions[0].chosen, "5000, 2 per mm² on 2500.0 mm² of skin");
    // A second conversion changes nothing.
    assert_eq!(to_tile_units(&found.recipe, &bounds(0.5)).unwrap().recipe, found.recipe);
    assert!(to_tile_units(&found.recipe, &bounds(0.5)).unwrap().decisions.is_empty());
}

#[test]
fn chosen_tile_fits_the_strands_and_resolves_each_hair() {
    let of = |sets: &[&str]| to_tile_units(&recipe(sets), &bounds(0.5)).unwrap();
    // The width 0.15 m is derived from the model's size.
    assert_eq!(of(&["hair.density_mm2=0.1"]).recipe.surface.tile_size_m, Some(0.15));
    assert_eq!(of(&["hair.density_mm2=0.1"]).recipe.hair.density, 2250);
    let dense = of(&["hair.density_mm2=20"]).recipe;
    let strands = f64::from(dense.hair.density);
    assert!((strands / MOST_STRANDS - 1.0).abs() < 1e-3, "{strands}");
    assert!((strands / (20.0 * f64::from(dense.surface.tile_size_m.unwrap()).powi(2) * MM2) - 1.0).abs() < 1e-3);
    let fine = of(&["hair.density_mm2=20", "hair.root_radius_m=0.00003", "slice.tile_texels=256"]);
    let tile_m = fine.recipe.surface.tile_size_m.unwrap();
    assert!((tile_m / (256.0 * 0.00006) - 1.0).abs() < 1e-5, "{tile_m}");
    assert!((fine.recipe.hair.root_radius * 256.0 - 0.5).abs() < 1e-4, "half a texel");
    assert_eq!(fine.warnings, [""; 0]);
    assert!(
        fine.decisions[0].chosen.ends_with("at which each of 256 texels is as wide as a hair of 60 µm"),
        "{fine:?}"
    );
    // Underfur with a density per tile uses up part of the permitted strands.
    let shared = of(&["hair.density_mm2=20", "underfur.density=5000"]).recipe;
    assert!((f64::from(shared.hair.density) / (MOST_STRANDS - 5000.0) - 1.0).abs() < 1e-3);
}

#[test]
fn patch_and_comb_sizes_in_metres_do_not_depend_on_the_tile() {
    let own = recipe(&["hair.density_mm2=20"]);
    let found = to_tile_units(&own, &bounds(0.5)).unwrap().recipe.surface;
    let [ours, ordinary] = [found.tile_size_m.unwrap(), 0.15];
    assert!(ours < 0.1);
    assert!((found.patch_size * ours / (own.surface.patch_size * ordinary) - 1.0).abs() < 1e-5);
    assert!((found.comb_smoothing * ours / (own.surface.comb_smoothing * ordinary) - 1.0).abs() < 1e-5);
}

#[test]
fn impossible_metric_values_are_refused_with_possible_ones() {
    let many = refused(&["hair.density_mm2=2000", "surface.tile_size_m=0.2"]);
    for word in ["hair.density_mm2", "found 2000", "80000002 strands", "200 mm wide", "2.500e1 per mm²"] {
        assert!(many.contains(word), "{word}: {many}");
    }
    let none = refused(&["hair.density_mm2=0.00001", "surface.tile_size_m=0.01"]);
    assert!(none.contains("0 strands") && none.contains("1.000e-2"), "{none}");
    assert!(to_tile_units(&recipe(&["underfur.density_mm2=0", "surface.tile_size_m=0.01"]), &bounds(0.5)).is_ok());
    let thick = refused(&["hair.tip_radius_m=0.05", "surface.tile_size_m=0.1"]);
    for word in ["hair.tip_radius_m", "found 50 mm", "25 mm", "100 mm wide"] {
        assert!(thick.contains(word), "{word}: {thick}");
    }
}

#[test]
fn subtexel_hair_is_reported_with_a_sufficient_tile_size() {
    let of = |sets: &[&str]| to_tile_units(&recipe(sets), &bounds(0.5)).unwrap().warnings;
    let warnings = of(&["hair.root_radius_m=0.00005", "surface.tile_size_m=0.05"]);
    assert_eq!(warnings.len(), 1);
    for word in ["hair is 100 µm wide", "391 µm", "slice.tile_texels = 512", "surface.tile_size_m = 1.28e-2"] {
        assert!(warnings[0].contains(word), "{word}: {warnings:?}");
    }
    assert_eq!(of(&["hair.root_radius_m=0.00005", "surface.tile_size_m=0.05", "slice.tile_texels=512"]), [""; 0]);
}
