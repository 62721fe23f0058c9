//! Tests with the real binary: hair that follows the body, and values for single joints.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_formats::{Limits, Package};
use pelage_tests::binary::{Sandbox, workspace};
use serde_json::Value;

const BAKE: [&str; 10] = [
    "bake",
    "m.glb",
    "-o",
    "m.pelage",
    "--json",
    "--set=slice.layers=4",
    "--set=slice.tile_texels=16",
    "--set=visibility.enabled=false",
    "--recipe",
    "r.toml",
];

/// Bakes a built-in model. Returns the report, and the fur height of each vertex relative to the greatest.
fn bake(model: &str, recipe: &str) -> (Value, Vec<f32>) {
    let sandbox = Sandbox::new();
    sandbox.write("m.glb", std::fs::read(workspace().join("assets/models").join(model)).unwrap());
    // The coat `natural` does not enable that hair follows the body. Hair must follow it only if `recipe` enables this.
    sandbox.write("r.toml", format!("[hair]\ncoat = \"natural\"\n{recipe}"));
    let run = sandbox.run(&BAKE);
    assert_eq!(run.code, Some(0), "{run:?}");
    let bytes = std::fs::read(sandbox.path().join("m.pelage")).unwrap();
    assert_eq!(Package::validate(&bytes, &Limits::default()), []);
    let package = Package::open(&bytes, &Limits::default()).unwrap();
    let height_m = package.manifest().fur.height_m;
    let shares = package.mesh().unwrap().unwrap().geometry().map(|v| v.fur_height / height_m).collect();
    (serde_json::from_str(&run.stdout).unwrap(), shares)
}

fn range(shares: &[f32]) -> (f32, f32) {
    shares.iter().fold((f32::INFINITY, 0.0), |(low, high), v| (low.min(*v), high.max(*v)))
}

fn lines(said: &Value) -> Vec<&str> {
    said["decisions"].as_array().unwrap().iter().map(|decision| decision["line"].as_str().unwrap()).collect()
}

#[test]
fn hair_on_limbs_is_shortened_and_reported() {
    let (said, even) = bake("hare.glb", "");
    assert!(lines(&said).iter().all(|line| !line.starts_with("groom.by_body")), "{said}");
    let (said, shares) = bake("hare.glb", "[groom]\nby_body = 1\n");
    assert!(lines(&said).contains(&"groom.by_body = 1"), "{said}");
    let (shortest, longest) = range(&shares);
    assert!((longest - range(&even).1).abs() < 1e-3, "the longest hair keeps its length: {longest}");
    assert!(shortest < 0.6 * longest, "{shortest} {longest}");
    // A torus has no limbs, so the bake must not report a decision, and the hair has the same length everywhere.
    let (said, shares) = bake("torus.glb", "[groom]\nby_body = 1\n");
    assert!(lines(&said).iter().all(|line| !line.starts_with("groom.by_body")), "{said}");
    assert!(range(&shares).1 - range(&shares).0 < 1e-3);
}

#[test]
fn joint_tables_without_effect_give_a_warning() {
    let (said, _) = bake("torus.glb", "[[groom.joint]]\nname = \"head*\"\nlength = 0.5\n");
    assert!(said["warnings"].to_string().contains("groom.joint: the model has no skeleton"), "{said}");
}
