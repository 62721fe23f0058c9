//! What a bake chooses where the recipe is silent, through the real binary.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_tests::binary::{Sandbox, workspace};
use serde_json::Value;

const BAKE: [&str; 8] =
    ["bake", "m.glb", "-o", "m.pelage", "--json", "--set", "slice.layers=4", "--set=slice.tile_texels=16"];

/// The decisions of a bake of a built-in model.
fn decisions(model: &str, more: &[&str]) -> Vec<Value> {
    let sandbox = Sandbox::new();
    sandbox.write("m.glb", std::fs::read(workspace().join("assets/models").join(model)).unwrap());
    let run = sandbox.run(&[&BAKE[..], more].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    let value: Value = serde_json::from_str(&run.stdout).unwrap();
    value["decisions"].as_array().unwrap().clone()
}

fn lines(decisions: &[Value]) -> Vec<&str> {
    decisions.iter().map(|decision| decision["line"].as_str().unwrap()).collect()
}

#[test]
fn what_a_recipe_leaves_open_is_said_with_the_line_that_says_the_same() {
    let open = decisions("torus.glb", &[]);
    let length = lines(&open).into_iter().find(|line| line.starts_with("hair.length_m = ")).unwrap().to_owned();
    assert!(lines(&open).iter().any(|line| line.starts_with("surface.tile_size_m = ")), "{open:?}");
    assert!(lines(&open).contains(&"model.bare = []"), "{open:?}");
    // Said in the recipe, it is no longer open.
    let said = decisions("torus.glb", &["--set", &length.replace(' ', "")]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("hair.length_m")), "{said:?}");
}

#[test]
fn the_models_own_colours_stay() {
    let root = |decisions: &[Value]| {
        let decision = decisions.iter().find(|decision| decision["what"] == "colour at the root").unwrap().clone();
        (decision["chosen"].as_str().unwrap().to_owned(), decision["line"].as_str().unwrap().to_owned())
    };
    let (why, line) = root(&decisions("hare.glb", &[]));
    assert!(why.starts_with("neutral") && line == "color.root = \"#d8d8d8\"", "{why}, {line}");
    let (why, line) = root(&decisions("hare.glb", &["--set", "color.base_color=false"]));
    assert!(why.starts_with("brown") && line == "color.root = \"#4a3624\"", "{why}, {line}");
    let said = decisions("hare.glb", &["--set", "color.root=#102030"]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("color.root")), "{said:?}");
    // Who says a colour has chosen how light it is.
    assert!(lines(&said).iter().all(|line| !line.starts_with("color.gain")), "{said:?}");
}

#[test]
fn bare_parts_are_found_and_a_list_in_the_recipe_goes_first() {
    let found = decisions("ox.glb", &[]);
    let bare = found.iter().find(|d| d["line"].as_str().unwrap().starts_with("model.bare")).unwrap();
    assert_eq!(bare["line"], "model.bare = [\"horn\", \"hoof\", \"eye\"]");
    assert!(bare["chosen"].as_str().unwrap().starts_with("2 of 5 materials furred, 3 bare: horn (by name)"), "{bare}");
    let said = decisions("ox.glb", &["--set", "model.bare=[]"]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("model.bare")), "{said:?}");
}
