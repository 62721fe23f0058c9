//! Tests of the coats' files and of recipes that name a coat.

use super::Coat;
use crate::recipe::{Recipe, keys};
use std::path::Path;

fn of(coat: Coat) -> Recipe {
    Recipe::parse("r.toml", &format!("[hair]\ncoat = {:?}\n", coat.word())).unwrap()
}

#[test]
fn every_coat_has_a_file_with_different_defaults() {
    let animal = Recipe::default();
    assert_eq!(of(Coat::Animal), animal);
    for coat in &Coat::ALL[1..] {
        let mut said = Recipe::default();
        pelage_params::read(&mut said, coat.toml()).unwrap();
        assert_ne!(said, animal, "{coat:?} changes nothing");
        assert_eq!(said.hair.coat, Coat::Animal, "{coat:?} sets hair.coat");
        assert_eq!((said.hair.length_m, said.surface.tile_size_m), (None, None), "{coat:?} sets a length in metres");
        assert_eq!(of(*coat), Recipe { hair: crate::recipe::HairParams { coat: *coat, ..said.hair.clone() }, ..said });
        let others = Coat::ALL.iter().filter(|other| *other != coat);
        assert!(others.clone().all(|other| other.toml() != coat.toml()), "{coat:?} equals another coat");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/recipe/coats");
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().file_name()).collect();
    let mut words: Vec<std::ffi::OsString> =
        Coat::ALL[1..].iter().map(|coat| format!("{}.toml", coat.word()).into()).collect();
    files.sort();
    words.sort();
    assert_eq!(files, words);
}

/// Checks that no coat sets an optional key: `to_toml` could not write the key back as absent.
#[test]
fn coats_set_keys_that_always_have_a_value() {
    let animal = Recipe::default();
    for coat in &Coat::ALL[1..] {
        let changed: Vec<_> = keys().filter(|key| key.value(&of(*coat)) != key.value(&animal)).collect();
        assert!(changed.iter().all(|key| key.value(&animal).is_some()), "{coat:?}: {changed:?}");
        assert!(changed.len() > 4, "{coat:?}: {changed:?}");
    }
}

#[test]
fn recipe_keys_override_the_coat() {
    let animal = Recipe::default();
    let winter = of(Coat::Winter);
    // The text sets keys before and after the coat, and one key to exactly the value that the coat replaces.
    let text =
        format!("[slice]\nlayers = 9\n[hair]\ndensity = {}\ncoat = \"winter\"\nlean = 0.1\n", animal.hair.density);
    let recipe = Recipe::parse("r.toml", &text).unwrap();
    assert_eq!((recipe.slice.layers, recipe.hair.lean, recipe.hair.density), (9, 0.1, animal.hair.density));
    assert_ne!(winter.hair.density, animal.hair.density);
    assert_eq!(recipe.hair.root_radius, winter.hair.root_radius);
    assert_eq!(Recipe::parse("r.toml", &recipe.to_toml()).unwrap(), recipe);
}

#[test]
fn changing_the_coat_replaces_the_values_of_the_previous_coat() {
    let mut recipe = Recipe::parse("r.toml", "[hair]\ncoat = \"wool\"\nlean = 0.33\n").unwrap();
    recipe.set("hair.coat=wet").unwrap();
    let wet = of(Coat::Wet);
    assert_eq!(recipe.hair, crate::recipe::HairParams { lean: 0.33, ..wet.hair.clone() });
    assert_eq!(recipe.surface, wet.surface);
    recipe.set("hair.lean=0.5").unwrap();
    recipe.set("hair.coat=animal").unwrap();
    assert_eq!((recipe.hair.lean, recipe.hair.density), (0.5, Recipe::default().hair.density));
    recipe.merge("more.toml", "[hair]\ncoat = \"short\"\ndensity = 700\n").unwrap();
    assert_eq!((recipe.hair.density, recipe.hair.tip_radius), (700, of(Coat::Short).hair.tip_radius));
}

#[test]
fn unknown_coat_errors_list_all_coats() {
    for error in [
        Recipe::parse("r.toml", "[hair]\ncoat = \"wolly\"\n").unwrap_err().to_string(),
        Recipe::default().set("hair.coat=wolly").unwrap_err().to_string(),
    ] {
        assert!(error.contains("hair.coat") && error.contains("wolly"), "{error}");
        assert!(Coat::ALL.iter().all(|coat| error.contains(coat.word())), "{error}");
    }
}

#[test]
fn recorded_recipes_without_a_coat_keep_the_old_defaults() {
    let recorded = Recipe::parse_recorded("old", "[hair]\nlean = 0.7\n").unwrap();
    let mut natural = of(Coat::Natural);
    natural.shading.model = crate::recipe::ShadingModel::KajiyaKay;
    assert_eq!(recorded, Recipe { hair: crate::recipe::HairParams { lean: 0.7, ..natural.hair.clone() }, ..natural });
    assert_eq!((recorded.underfur.density, recorded.hair.density, recorded.groom.by_body), (0, 700, 0.0));
    // Recipes that are recorded today name every key.
    for coat in Coat::ALL {
        let recipe = of(*coat);
        assert_eq!(Recipe::parse_recorded("new", &recipe.to_toml()).unwrap(), recipe);
    }
}
