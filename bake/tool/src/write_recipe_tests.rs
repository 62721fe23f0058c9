//! Tests of the written recipe's text and path.

use super::*;

fn chosen<'a>(asked: &'a Recipe, recipe: &'a Recipe) -> RecipeChoices<'a> {
    RecipeChoices { model: "fox", asked, recipe, options: "--max-error 0.05" }
}

#[test]
fn chosen_values_are_written_with_a_comment_above() {
    let asked = Recipe::parse("r.toml", "[hair]\ncoat = \"wool\"\nlean = 0.25\n").unwrap();
    let mut fitted = asked.clone();
    fitted.slice.layers = 11;
    // The bake fills in this value without recording a decision.
    let mut recorded = fitted.clone();
    (recorded.hair.length_m, recorded.ink.fur) = (Some(0.031), Some(0.0));
    let decisions = [Decision::length("length of hair", "hair.length_m", 0.031)];
    let text = chosen(&asked, &fitted).text(&recorded.to_toml(), &decisions).unwrap();
    assert!(text.contains("\n# chosen by the bake: length of hair, 31 mm\nlength_m = 0.031\n"), "{text}");
    assert!(text.contains("\n# chosen by the bake: for --max-error 0.05\nlayers = 11\n"), "{text}");
    assert!(text.contains("\n# chosen by the bake\nfur = 0.0\n"), "{text}");
    assert_eq!(text.matches("\n# chosen by the bake").count(), 3);
    assert_eq!(Recipe::parse("r.toml", &text).unwrap(), recorded);
}

#[test]
fn decisions_with_unknown_keys_are_internal_errors() {
    let recipe = Recipe::default();
    let broken = Decision { what: "length", chosen: "3".into(), line: "hair.lenth_m = 3".into() };
    let error = chosen(&recipe, &recipe).text(&recipe.to_toml(), &[broken]).unwrap_err();
    assert!(matches!(&error, BakeError::Internal(text) if text.contains("hair.lenth_m")), "{error}");
}

#[test]
fn choosing_options_are_printed_as_typed() {
    let limits = Limits { max_error: Some(0.05), max_bytes: Some(90_000), ..Limits::default() };
    assert_eq!(options(&limits, &PictureArgs::default()), "--max-error 0.05 --max-bytes 90000");
    assert_eq!(
        options(&Limits::default(), &PictureArgs { for_size: "834x424".parse().ok(), for_distance: Some(2.5) }),
        "--for-size 834x424 --for-distance 2.5"
    );
}
