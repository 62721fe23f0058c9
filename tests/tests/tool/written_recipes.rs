//! Tests of `pelage bake --write-recipe` with the real binary: the written recipe gives the same package.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_bake::recipe::{Coat, Recipe, keys};
use pelage_tests::binary::{Run, Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;

/// Returns a folder with the torus, a recipe that names a pattern image, and that image.
fn sandbox() -> Sandbox {
    let sandbox = Sandbox::new();
    let asset = |name: &str| std::fs::read(workspace().join("assets").join(name)).unwrap();
    sandbox.write("torus.glb", asset("models/torus.glb"));
    sandbox.write("recipes/spots.png", asset("patterns/spots.png"));
    let recipe = "[hair]\ncoat = \"wool\"\nlean = 0.4 # mine\n[color]\npattern = \"spots.png\"\npattern_texels = 512\n\
        [pack]\nbase_color_format = \"rgba8\"\n[fins]\nenabled = true\n[slice]\nlayers = 4\ntile_texels = 16\n";
    sandbox.write("recipes/mine.toml", recipe);
    sandbox
}

fn bake(sandbox: &Sandbox, package: &str, more: &[&str]) -> Run {
    sandbox.run(&[&["bake", "torus.glb", "-o", package], more].concat())
}

/// Bakes with `--write-recipe`, asserts that the written recipe gives the same package, and returns the recipe.
fn bake_with_written(sandbox: &Sandbox, path: &str, more: &[&str]) -> String {
    bake_with_written_and_run(sandbox, path, more).0
}

/// Same as [`bake_with_written`], but also returns the run that wrote the recipe.
fn bake_with_written_and_run(sandbox: &Sandbox, path: &str, more: &[&str]) -> (String, Run) {
    let first = bake(sandbox, "first.pelage", &[&["--write-recipe", path], more].concat());
    assert_eq!(first.code, Some(0), "{first:?}");
    assert!(first.stdout.contains(path), "{first:?}");
    let text = String::from_utf8(sandbox.read(path)).unwrap();
    let second = bake(sandbox, "second.pelage", &["--recipe", path]);
    assert_eq!(second.code, Some(0), "{second:?}");
    let same = sandbox.read("first.pelage") == sandbox.read("second.pelage");
    assert!(same, "the written recipe gives another package: {text}");
    assert_eq!(sandbox.run(&["validate", "first.pelage"]).code, Some(0));
    (text, first)
}

const SMALL: [&str; 4] = ["--set", "slice.layers=4", "--set", "slice.tile_texels=16"];

#[test]
fn the_written_recipe_gives_the_same_package() {
    let sandbox = sandbox();
    let text = bake_with_written(&sandbox, "whole.toml", &SMALL);
    let recipe = Recipe::parse("whole.toml", &text).unwrap();
    assert!(recipe.hair.length_m.is_some() && recipe.surface.tile_size_m.is_some(), "{text}");
    assert_eq!(recipe.slice.layers, 4);
    // Every key must be present, with a value or as a comment, and chosen values must be marked.
    for key in keys() {
        let there = [format!("\n{} = ", key.key()), format!("\n# {} =\n", key.key())];
        assert!(there.iter().any(|line| text.contains(line)), "{} is missing: {text}", key.name);
    }
    assert!(
        text.contains("\n# chosen by the bake: length of hair, ") && text.contains("\n# chosen by the bake\nfur = ")
    );
    // The next bake must overwrite the recipe, which is an output like the package.
    let again = bake_with_written(&sandbox, "whole.toml", &[&SMALL[..], &["--set", "hair.length_m=0.01"]].concat());
    assert!(!again.contains("length of hair, "), "{again}");
}

#[test]
fn recipe_with_a_coat_and_images_is_written_completely() {
    let sandbox = sandbox();
    let text = bake_with_written(&sandbox, "recipes/whole.toml", &["--recipe", "recipes/mine.toml"]);
    let recipe = Recipe::parse("whole.toml", &text).unwrap();
    let wool = Recipe::parse("wool.toml", "[hair]\ncoat = \"wool\"\n").unwrap();
    assert_eq!((recipe.hair.coat, recipe.hair.lean), (Coat::Wool, 0.4));
    assert_eq!(recipe.hair.curl_radius, wool.hair.curl_radius);
    assert_eq!(recipe.images(), [("color.pattern".to_owned(), "spots.png")]);
    // These are choices of the bake that have no explanation of their own.
    assert!(
        text.contains("\n# chosen by the bake\npattern_size_m = ") && text.contains("\n# chosen by the bake\ndepth = ")
    );
}

#[test]
fn written_recipe_contains_values_chosen_by_options() {
    let sandbox = sandbox();
    let text = bake_with_written(&sandbox, "whole.toml", &["--for-size", "120x72"]);
    assert!(text.contains("\n# chosen by the bake: for --for-size 120x72\nlayers = "), "{text}");
}

#[test]
fn written_recipe_contains_values_chosen_by_limits() {
    if gpu("written_recipe_contains_values_chosen_by_limits").is_none() {
        return;
    }
    let sandbox = sandbox();
    let small = ["judge.width=60", "judge.height=36", "judge.samples=8", "ink.enabled=false", "slice.layers=64"];
    let sets: Vec<&str> = small.iter().flat_map(|set| ["--set", set]).collect();
    let limits = [&["--max-error", "1", "--json"], &sets[..]].concat();
    let (text, run) = bake_with_written_and_run(&sandbox, "whole.toml", &limits);
    assert!(text.contains("\n# chosen by the bake: for --max-error 1\nlayers = "), "{text}");
    // The package must equal that of a bake without measurements. The report contains the measurements.
    let object = schema::parse_success(&run, "bake");
    assert!(object["choice"].is_object() && object["recipe"] == "whole.toml", "{object}");
    let inspected = sandbox.run(&["inspect", "first.pelage", "--json"]);
    let inspected: serde_json::Value = serde_json::from_str(&inspected.stdout).unwrap();
    assert!(inspected["choice"].is_null(), "{inspected}");
}

#[test]
fn recipe_that_would_lose_its_files_is_not_written() {
    let sandbox = sandbox();
    let refused = |path: &str, words: &[&str]| {
        let before = sandbox.files();
        let run = bake(&sandbox, "p.pelage", &["--recipe", "recipes/mine.toml", "--write-recipe", path]);
        assert_eq!(run.code, Some(1), "{run:?}");
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{words:?}: {run:?}");
        assert_eq!(sandbox.files(), before, "{path} left something behind");
    };
    refused("whole.toml", &["color.pattern", "spots.png", "copy the files", "--recipe"]);
    // A file `spots.png` beside the written recipe contains a different image.
    sandbox.write("spots.png", std::fs::read(workspace().join("assets/patterns/zebra.png")).unwrap());
    refused("whole.toml", &["whole.toml", "another file", "spots.png"]);
    // If the file `spots.png` beside the written recipe contains the same image, the recipe can be written.
    sandbox.write("spots.png", sandbox.read("recipes/spots.png"));
    bake_with_written(&sandbox, "whole.toml", &["--recipe", "recipes/mine.toml"]);
}

#[test]
fn written_recipe_never_overwrites_an_input() {
    let sandbox = sandbox();
    let before = (sandbox.files(), sandbox.read("recipes/mine.toml"));
    for path in ["recipes/../recipes/mine.toml", "p.pelage", "torus.glb"] {
        let run = bake(&sandbox, "p.pelage", &["--recipe", "recipes/mine.toml", "--write-recipe", path]);
        assert_eq!(run.code, Some(1), "{path}: {run:?}");
        assert!(run.stderr.contains(path), "{path}: {run:?}");
        assert_eq!((sandbox.files(), sandbox.read("recipes/mine.toml")), before, "{path}");
    }
}

#[test]
fn package_and_recipe_are_written_together_or_not_at_all() {
    let sandbox = sandbox();
    let before = sandbox.files();
    for (path, place) in [("none/r.toml", "none: "), ("recipes", "recipes: ")] {
        let run = bake(&sandbox, "p.pelage", &[&SMALL[..], &["--write-recipe", path]].concat());
        assert_eq!(run.code, Some(2), "{path}: {run:?}");
        assert!(run.stderr.contains(place), "{path}: {run:?}");
        assert_eq!(sandbox.files(), before, "{path}");
    }
}
