//! Tests with the real binary: decisions of a bake about keys that the recipe does not set.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_needs::data;
use pelage_tests::binary::{Sandbox, workspace};
use serde_json::Value;
use std::path::Path;

const BAKE: [&str; 8] =
    ["bake", "m.glb", "-o", "m.pelage", "--json", "--set", "slice.layers=4", "--set=slice.tile_texels=16"];

/// Returns the decisions of a bake of one of the built-in models.
fn decisions(model: &str, more: &[&str]) -> Vec<Value> {
    decisions_on(&workspace().join("assets/models").join(model), more)
}

fn decisions_on(model: &Path, more: &[&str]) -> Vec<Value> {
    let sandbox = Sandbox::new();
    sandbox.write("m.glb", std::fs::read(model).unwrap());
    let run = sandbox.run(&[&BAKE[..], more].concat());
    assert_eq!(run.code, Some(0), "{run:?}");
    let value: Value = serde_json::from_str(&run.stdout).unwrap();
    value["decisions"].as_array().unwrap().clone()
}

fn lines(decisions: &[Value]) -> Vec<&str> {
    decisions.iter().map(|decision| decision["line"].as_str().unwrap()).collect()
}

#[test]
fn decisions_are_printed_with_the_equivalent_recipe_line() {
    let open = decisions("torus.glb", &[]);
    let length = lines(&open).into_iter().find(|line| line.starts_with("hair.length_m = ")).unwrap().to_owned();
    assert!(lines(&open).iter().any(|line| line.starts_with("surface.tile_size_m = ")), "{open:?}");
    assert!(lines(&open).contains(&"model.bare = []"), "{open:?}");
    // A value that is set in the recipe must not be reported as a decision.
    let said = decisions("torus.glb", &["--set", &length.replace(' ', "")]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("hair.length_m")), "{said:?}");
}

#[test]
fn model_colours_are_kept_by_default() {
    let root = |decisions: &[Value]| {
        let decision = decisions.iter().find(|decision| decision["what"] == "colour at the root").unwrap().clone();
        (decision["chosen"].as_str().unwrap().to_owned(), decision["line"].as_str().unwrap().to_owned())
    };
    let (why, line) = root(&decisions("hare.glb", &[]));
    assert!(why.starts_with("neutral") && line == "color.root = \"#ffffff\"", "{why}, {line}");
    let (why, line) = root(&decisions("hare.glb", &["--set", "color.base_color=false"]));
    assert!(why.starts_with("brown") && line == "color.root = \"#4a3624\"", "{why}, {line}");
    let said = decisions("hare.glb", &["--set", "color.root=#102030"]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("color.root")), "{said:?}");
    // A recipe that sets a colour also sets its brightness.
    assert!(lines(&said).iter().all(|line| !line.starts_with("color.gain")), "{said:?}");
}

#[test]
fn bare_parts_are_detected_unless_the_recipe_lists_them() {
    let found = decisions("ox.glb", &[]);
    let bare = found.iter().find(|d| d["line"].as_str().unwrap().starts_with("model.bare")).unwrap();
    assert_eq!(bare["line"], "model.bare = [\"horn\", \"hoof\", \"eye\"]");
    assert!(bare["chosen"].as_str().unwrap().starts_with("2 of 5 materials furred, 3 bare: horn (by name)"), "{bare}");
    let said = decisions("ox.glb", &["--set", "model.bare=[]"]);
    assert!(lines(&said).iter().all(|line| !line.starts_with("model.bare")), "{said:?}");
}

#[test]
fn bare_parts_of_known_animals_are_detected() {
    let Some(data) = data("bare_parts_of_known_animals_are_detected") else { return };
    // Exactly these parts must be bare. The nose of the dog and the claws of the reptile are parts of "Black".
    for (animal, bare) in [
        ("quaternius_Wolf", "[\"Eyes_Black\", \"Nose\"]"),
        ("quaternius_ShibaInu", "[\"Black/eye rims\", \"Eyes_White\", \"Eyes_Pupil\", \"Eyes_Black\", \"Black/nose\"]"),
        ("quaternius_Alpaca", "[\"Hooves\", \"Eyes_Black\", \"Eyes_White\"]"),
        ("quaternius_Cow", "[\"Hooves\", \"Eye_Black\", \"Eye_White\", \"Horns\"]"),
        ("quaternius_Horse", "[\"Hooves\", \"Eye_Black\", \"Eye_White\"]"),
        ("quaternius_Velociraptor", "[\"Black/claws\"]"),
        ("Fox", "[]"),
    ] {
        let less = ["visibility.enabled=false", "hair.density=20", "slice.layers=4", "slice.tile_texels=32"];
        let more = less.map(|set| ["--set", set]).concat();
        let found = decisions_on(&data.join(format!("meshes/skinned/{animal}.glb")), &more);
        assert!(lines(&found).contains(&&*format!("model.bare = {bare}")), "{animal}: {:?}", lines(&found));
    }
}

#[test]
fn bare_margin_is_chosen_only_with_bare_parts() {
    let margin = |decisions: &[Value]| {
        let found = lines(decisions).into_iter().find_map(|line| line.strip_prefix("groom.bare_margin_m = "));
        found.map(|metres| metres.parse::<f32>().unwrap())
    };
    assert_eq!(margin(&decisions("torus.glb", &[])), None);
    let [short, long] = ["0.002", "0.01"]
        .map(|length| margin(&decisions("hare.glb", &["--set", &format!("hair.length_m={length}")])).unwrap());
    assert!(0.0 < short && short < long && long < 0.05, "{short} {long}");
    assert_eq!(margin(&decisions("hare.glb", &["--set", "groom.bare_margin_m=0"])), None);
}

#[test]
fn metric_hair_values_determine_the_tile() {
    let said = ["--set", "hair.density_mm2=3", "--set", "hair.root_radius_m=0.0002"];
    let found = decisions("hare.glb", &said);
    let number = |key: &str| -> f64 {
        let line = lines(&found).into_iter().find_map(|line| line.strip_prefix(key)).unwrap();
        line.strip_prefix(" = ").unwrap().parse().unwrap()
    };
    let (tile_m, strands) = (number("surface.tile_size_m"), number("hair.density"));
    assert!((tile_m / (16.0 * 0.0004) - 1.0).abs() < 1e-3, "16 texels as wide as a hair: {tile_m}");
    assert_eq!(strands, (3e6 * tile_m * tile_m).round());

    let sandbox = Sandbox::new();
    sandbox.write("m.glb", std::fs::read(workspace().join("assets/models/hare.glb")).unwrap());
    let run = sandbox.run(&[&BAKE[..], &["--set=hair.density_mm2=900", "--set=surface.tile_size_m=0.1"]].concat());
    assert_eq!(run.code, Some(3), "{run:?}");
    assert!(run.stderr.contains("hair.density_mm2") && run.stderr.contains("expected"), "{run:?}");
}

#[test]
fn for_distance_fits_layers_to_the_viewing_distance() {
    let sandbox = Sandbox::new();
    sandbox.write("m.glb", std::fs::read(workspace().join("assets/models/hare.glb")).unwrap());
    let slices = |more: &[&str]| {
        let run = sandbox.run(
            &[
                &["bake", "m.glb", "-o", "m.pelage", "--set=hair.coat=natural", "--set=visibility.enabled=false"][..],
                more,
            ]
            .concat(),
        );
        assert_eq!(run.code, Some(0), "{run:?}");
        let run = sandbox.run(&["inspect", "m.pelage", "--json"]);
        let fur: Value = serde_json::from_str(&run.stdout).unwrap();
        ["layers", "tile_texels"].map(|key| fur["fur"][key].as_u64().or(fur[key].as_u64()).unwrap())
    };
    let [near, far] = ["0.5", "30"].map(|metres| slices(&["--for-distance", metres]));
    assert!(near[0] > far[0] && near[1] > far[1], "{near:?} {far:?}");
    assert_eq!(far[0], 4, "must choose the minimum number of layers");
    // A picture of twice the height from twice the distance shows the fur at the same size.
    assert_eq!(slices(&["--for-distance", "1", "--for-size", "834x848"]), near);
    let bad = sandbox.run(&["bake", "m.glb", "-o", "m.pelage", "--for-distance", "-1"]);
    assert!(bad.code == Some(1) && bad.stderr.contains("expected a number above 0"), "{bad:?}");
    let both = sandbox.run(&["bake", "m.glb", "-o", "m.pelage", "--for-distance", "1", "--max-error", "1"]);
    assert_eq!(both.code, Some(1), "{both:?}");
}
