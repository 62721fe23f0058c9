//! Tests of the error measure of a bake with limits against pairs of pictures that a person has ranked.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::likeness::{FUR_PX, folder, likeness, pairs};

/// Checks that the error ranks every pair as a person does, by a margin above the noise of the reference image. Mean
/// FLIP alone must fail.
#[test]
fn likeness_ranks_pairs_as_people_do() {
    let (mut flip_fails, mut wrong) = (0, Vec::new());
    let all = pairs();
    for pair in &all {
        let here = folder().join(&pair.animal);
        let of = |setting: &str| likeness(&here.join(format!("{setting}.png")), &here.join("true.png"), FUR_PX);
        let (better, worse) = (of(&pair.better), of(&pair.worse));
        println!("{pair:?}: {:.4} and {:.4}, FLIP {:.4} and {:.4}", better.error, worse.error, better.flip, worse.flip);
        flip_fails += u32::from(better.flip >= worse.flip);
        if better.error > 0.98 * worse.error {
            wrong.push(format!("{pair:?}: {better:?}, {worse:?}"));
        }
    }
    assert!(all.len() >= 25, "{}", all.len());
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(flip_fails >= 10, "mean FLIP alone fails for only {flip_fails} pairs, so the pairs prove nothing");
}

/// Checks a pair that is drawn by the test: long hair in four coarse layers, which mean FLIP accepted, and the usual
/// layers with fins.
#[test]
fn ghost_outlines_score_worse_than_hair() {
    if gpu("ghost_outlines_score_worse_than_hair").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let asset = |path: &str| workspace().join("assets").join(path).display().to_string();
    let (model, recipe) = (asset("models/hare.glb"), asset("recipes/hare.toml"));
    let view = ["--size", "300x200"];
    for (name, sets) in [
        ("hair", &["slice.layers=24", "slice.tile_texels=64"][..]),
        ("ghost", &["slice.layers=4", "slice.tile_texels=32", "fins.enabled=false"]),
    ] {
        let package = format!("{name}.pelage");
        let long = ["hair.length_m=0.06", "ink.enabled=false", "pack.shell_format=rgba8", "pack.direction_format=rg8"];
        let sets = long.iter().chain(sets).flat_map(|set| ["--set", set]);
        let bake = [&model, "--recipe", &recipe, "-o", &package];
        sandbox.fixture(&bake.into_iter().chain(sets).collect::<Vec<_>>());
        let render = ["render", &package, "-q", "--hair", "shells", "-o", &format!("{name}.png")];
        assert_eq!(sandbox.run(&[&render, &view[..]].concat()).code, Some(0));
    }
    let reference = ["reference", "hair.pelage", "-q", "-o", "true.png", "--samples", "16"];
    assert_eq!(sandbox.run(&[&reference, &view[..]].concat()).code, Some(0));
    let picture = |name: &str| sandbox.path().join(name);
    let of = |name: &str| likeness(&picture(name), &picture("true.png"), 40.0);
    let (hair, ghost) = (of("hair.png"), of("ghost.png"));
    println!("hair {hair:?}, ghost {ghost:?}");
    assert!(ghost.error > 1.05 * hair.error, "hair {hair:?}, ghost {ghost:?}");
    assert!(ghost.outline > hair.outline, "hair {hair:?}, ghost {ghost:?}");
}
