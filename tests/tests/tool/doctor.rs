//! Tests of `pelage doctor` with the real binary, compared with the counts of `pelage bench` on an adapter.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::schema;
use serde_json::Value;

fn doctor(sandbox: &Sandbox, args: &[&str]) -> Value {
    schema::parse_success(&sandbox.run(&[&["doctor", "a.pelage", "--json"], args].concat()), "doctor")
}

fn bake(sandbox: &Sandbox, name: &str, sets: &[&str]) {
    let asset =
        |folder: &str, kind: &str| workspace().join(format!("assets/{folder}/{name}.{kind}")).display().to_string();
    let (model, recipe) = (asset("models", "glb"), asset("recipes", "toml"));
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    sandbox.fixture(&[&[&model, "--recipe", &recipe, "-o", "a.pelage"], &sets[..]].concat());
}

#[test]
fn doctor_predictions_match_adapter_counts() {
    let Some(gpu) = gpu("doctor_predictions_match_adapter_counts") else { return };
    let software = gpu.info.device_type == pelage_runtime::wgpu::DeviceType::Cpu;
    let sandbox = Sandbox::new();
    // Software adapters store these formats unchanged. Fibres do not change the number of fragments.
    let plain = [
        "shading.model=kajiya-kay",
        "pack.shell_format=rgba8",
        "pack.direction_format=rgba8",
        "pack.base_color_format=rgba8",
        "ink.enabled=false",
        "fins.enabled=true",
        "detail.enabled=false",
    ];
    let mut baked = "";
    for (name, view) in [
        ("hare", &["--size", "500x300"][..]),
        // The camera looks almost straight down, along the body and at close range. If the view were turned by a
        // quarter, it would show a different part of the hare.
        ("hare", &["--size", "600x200", "--camera", "0.02,0.9,0/0,0.2,0/14"]),
        ("knot", &["--size", "300x300"]),
        ("torus", &["--size", "400x300", "--camera", "1,1,2.5/0,0.1,0/35"]),
    ] {
        if baked != name {
            bake(&sandbox, name, &plain);
            baked = name;
        }
        let found = doctor(&sandbox, view);
        // The prediction is for layers in a frame without motion.
        let still = ["bench", "a.pelage", "--json", "--frames", "1", "--hair", "shells", "--hair-motion", "off"];
        let args = [&still, view].concat();
        let counted = schema::parse_success(&sandbox.run(&args), "bench");
        let bytes = |v: &Value| v["gpu_bytes"].as_f64().unwrap();
        // The prediction does not include uniform blocks.
        let ratio = bytes(&found) / bytes(&counted);
        assert!((0.99..=1.0).contains(&ratio), "{name}: {ratio} of the bytes");
        let mut compared = 0;
        let count = |v: &Value| v["passes"].as_array().unwrap().len();
        assert_eq!(count(&found), count(&counted), "both list the passes of a furry frame");
        for (a, b) in found["passes"].as_array().unwrap().iter().zip(counted["passes"].as_array().unwrap()) {
            assert_eq!(a["name"], b["name"]);
            // Not all adapters count fragments.
            let Some(counted) = b["fragments"].as_f64().filter(|n| *n > 0.0) else { continue };
            let predicted = a[if software { "fragments_in_blocks" } else { "fragments" }].as_f64().unwrap();
            let ratio = predicted / counted;
            println!("{name}, {}: {predicted} predicted, {counted} counted: {ratio:.4}", a["name"]);
            // Software rasterisers shade whole blocks of pixels. Other adapters may or may not test for hidden pixels
            // before shading.
            let bounds = if software { 0.98..=1.02 } else { 0.5..=2.0 };
            assert!(bounds.contains(&ratio), "{name}, {}: {predicted} predicted, {counted} counted", a["name"]);
            compared += 1;
        }
        assert!(compared == 3 || !software, "{counted}");
    }
}

/// Checks the predicted number of layers. The renderer derives the distance of the nearest hair from the model's
/// bounds, while `doctor` derives it from the vertices.
#[test]
fn doctor_predicts_reduced_layers() {
    if gpu("doctor_predicts_reduced_layers").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    bake(&sandbox, "hare", &["ink.enabled=false"]);
    let size = ["--size", "400x200"];
    let found = doctor(&sandbox, &size);
    let args = [&["bench", "a.pelage", "--json", "--frames", "1", "--strand-edges", "samples"], &size[..]].concat();
    let counted = schema::parse_success(&sandbox.run(&args), "bench");
    let layers = [&found["on_screen"]["layers_drawn"], &counted["detail"][0]["layers"]].map(|n| n.as_i64().unwrap());
    assert!((layers[0] - layers[1]).abs() <= 1 && (1..15).contains(&layers[0]), "{layers:?}");
}

#[test]
fn doctor_gives_applicable_advice() {
    let sandbox = Sandbox::new();
    bake(&sandbox, "hare", &["slice.tile_texels=64"]);
    let run = sandbox.run(&["doctor", "a.pelage"]);
    assert!(run.code == Some(0) && run.stdout.contains("nothing to change"), "{run:?}");
    // At close range to the hare's flank, the layers are visibly separate. The advice about this comes before all
    // advice that saves cost.
    let near = ["--size", "64x64", "--camera", "0.25,0.2,0.6/0,0.2,0/1"];
    let found = doctor(&sandbox, &near);
    let advice = found["advice"].as_array().unwrap();
    let first = &advice[0];
    assert!(first["saved"].is_null() && first["found"].as_str().unwrap().contains("pixels apart"), "{first}");
    assert!(found["on_screen"]["near_m"].as_f64().unwrap() > 0.0, "{found}");
    assert_eq!(advice.iter().filter(|a| a["saved"].is_null()).count(), 1, "{advice:?}");
    // All other advice saves something; the largest saving is first.
    bake(&sandbox, "hare", &["pack.shell_format=rgba8", "pack.direction_format=rg8"]);
    let found = doctor(&sandbox, &["--size", "64x64", "--instances", "100", "--shadow-map", "0"]);
    assert_eq!((&found["memory"]["shadow_maps"], &found["instances"]), (&0.into(), &100.into()));
    let advice = found["advice"].as_array().unwrap();
    let saved = |a: &Value| ["fragments", "vertices", "bytes"].map(|what| a["saved"][what].as_u64().unwrap());
    assert!(advice.len() >= 2 && advice.iter().all(|a| saved(a) != [0; 3]), "{advice:?}");
    assert!(advice.iter().map(saved).is_sorted_by(|a, b| a >= b), "{advice:?}");
    assert!(advice.iter().all(|a| !a["change"].as_str().unwrap().starts_with("hair.")), "{advice:?}");
    let run = sandbox.run(&["doctor", "a.pelage", "--size", "64x64"]);
    for change in advice.iter().map(|a| a["change"].as_str().unwrap()) {
        assert!(run.stdout.contains(&format!("advice: {change}")), "{run:?}");
    }
}

/// Checks that advice is tested if there is an adapter. A hare 64 pixels high shows four layers, all less than half a
/// pixel apart. If fewer than sixteen layers were baked, the difference would still be visible. Half as many texels
/// would make no visible difference.
#[test]
fn doctor_omits_advice_that_raises_the_error() {
    if gpu("doctor_omits_advice_that_raises_the_error").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    for layers in ["16", "64"] {
        bake(&sandbox, "hare", &[&format!("slice.layers={layers}"), "ink.enabled=false", "color.at_root=false"]);
        let found = doctor(&sandbox, &["--size", "64x64"]);
        assert!(found["on_screen"]["layer_gap_px"].as_f64().unwrap() < 0.5, "sizes alone would advise it: {found}");
        let advice = found["advice"].as_array().unwrap();
        let found = |key: &str| advice.iter().find(|a| a["change"].as_str().unwrap().starts_with(key));
        assert!(found("slice.layers=").is_none() || layers == "64", "{layers} layers: {advice:?}");
        assert!(found("slice.tile_texels=").is_some(), "{layers} layers: {advice:?}");
        for tried in advice.iter().filter(|a| a["error"].is_object()) {
            let [before, after] = ["before", "after"].map(|when| tried["error"][when].as_f64().unwrap());
            assert!(after <= 1.02 * before && before > 0.0, "{layers} layers: {tried}");
        }
    }
}

#[test]
fn invalid_doctor_requests_are_refused() {
    let sandbox = Sandbox::new();
    sandbox.write("b.pelage", "no package");
    for (args, code, words) in [
        (&["doctor"][..], 1, "<PKG>"),
        (&["doctor", "b.pelage", "--size", "0x0"], 1, "1 to 8192"),
        (&["doctor", "b.pelage", "--instances", "0"], 1, "--instances"),
        (&["doctor", "b.pelage", "--camera", "0,0,0/0,0,0/40"], 1, "same point"),
        (&["doctor", "none.pelage"], 2, "none.pelage: cannot read"),
        (&["doctor", "b.pelage"], 3, "b.pelage"),
    ] {
        let run = sandbox.run(args);
        assert!(run.code == Some(code) && run.stderr.contains(words), "{args:?}: {run:?}");
    }
}
