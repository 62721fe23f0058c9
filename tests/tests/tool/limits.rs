//! Tests of `pelage bake` with limits and of `pelage chart shells`, with the real binary. The chosen package is
//! measured again independently.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::{Run, Sandbox, workspace};
use pelage_tests::gpu::gpu;
use pelage_tests::likeness::likeness;
use pelage_tests::schema;
use serde_json::Value;

/// Bake settings for fast measurements: small pictures, uncompressed texels, and no light between fibres. Ink textures
/// are disabled: limits do not affect them, and their size would dominate that of the package.
const SMALL: [&str; 7] = [
    "judge.width=120",
    "judge.height=72",
    "judge.samples=8",
    "pack.shell_format=rgba8",
    "pack.direction_format=rg8",
    "ink.enabled=false",
    "shading.model=kajiya-kay",
];

/// Runs `pelage bake` on the built-in torus with additional arguments.
fn bake(sandbox: &Sandbox, more: &[&str]) -> Run {
    let path = |name: &str| workspace().join(name).display().to_string();
    let (model, recipe) = (path("assets/models/torus.glb"), path("assets/recipes/torus.toml"));
    let mut args = vec!["bake", &model, "--recipe", &recipe, "-o", "torus.pelage"];
    args.extend(SMALL.iter().flat_map(|set| ["--set", set]));
    args.extend(more);
    sandbox.run(&args)
}

fn file_size(sandbox: &Sandbox, name: &str) -> u64 {
    std::fs::metadata(sandbox.path().join(name)).unwrap().len()
}

/// Returns the number of fragments in a frame of the baked package, from `pelage doctor`.
fn fragments(sandbox: &Sandbox) -> f64 {
    let found =
        schema::parse_success(&sandbox.run(&["doctor", "torus.pelage", "--size", "120x72", "--json"]), "doctor");
    // Passes that do not draw into the picture have no fragments.
    let fragments: f64 = found["passes"].as_array().unwrap().iter().filter_map(|pass| pass["fragments"].as_f64()).sum();
    assert!(fragments > 0.0, "{found}");
    fragments
}

#[test]
fn error_limit_holds_in_a_fresh_measurement() {
    if gpu("error_limit_holds_in_a_fresh_measurement").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    // The limit is a tenth above the error of the recipe's own settings, which leaves room for savings.
    let trial = schema::parse_success(&bake(&sandbox, &["--max-error", "1", "--json"]), "bake");
    let own = &trial["choice"]["trials"][0];
    let limit = 1.1 * own["error"].as_f64().unwrap();
    let object = schema::parse_success(&bake(&sandbox, &["--max-error", &limit.to_string(), "--json"]), "bake");
    let choice = &object["choice"];
    let chosen = &choice["trials"][choice["chosen"].as_u64().unwrap() as usize];
    assert!(chosen["error"].as_f64().unwrap() <= limit, "{choice}");
    // The cost is counted instead of timed. The search itself is tested with deterministic judges (`judge/decide`).
    let plain = Sandbox::new();
    assert_eq!(bake(&plain, &["-q"]).code, Some(0));
    let (fragments_chosen, fragments_own) = (fragments(&sandbox), fragments(&plain));
    println!("fragments: {fragments_chosen} chosen, {fragments_own} with the recipe's own settings");
    assert!(fragments_chosen <= 1.5 * fragments_own, "{fragments_chosen} of {fragments_own}: {choice}");
    assert!(choice["trials"].as_array().unwrap().len() > 2, "{choice}");
    assert_eq!(choice["views"].as_array().unwrap().len(), 2);

    // The package must contain the choice as reported, with its evidence, and the chosen settings.
    assert_eq!(sandbox.run(&["unpack", "torus.pelage", "folder", "-q"]).code, Some(0));
    let manifest: Value =
        serde_json::from_slice(&std::fs::read(sandbox.path().join("folder/manifest.json")).unwrap()).unwrap();
    assert_eq!(&manifest["manifest"]["choice"], choice);
    let recipe = std::fs::read_to_string(sandbox.path().join("folder/recipe.toml")).unwrap();
    for word in chosen["settings"].as_array().unwrap() {
        let (key, value) = word.as_str().unwrap().split_once('=').unwrap();
        let line = format!("{} = {value}", key.split_once('.').unwrap().1);
        assert!(recipe.lines().any(|l| l == line), "{line} in {recipe}");
    }

    // The views listed in the choice are drawn, traced and compared again with the other subcommands.
    let (mut errors, mut flips) = (Vec::new(), Vec::new());
    for view in choice["views"].as_array().unwrap() {
        let words: Vec<&str> = view.as_str().unwrap().split(' ').collect();
        let size = ["--size", "120x72"];
        // The bake measures frames with the runtime's own parameters, whose strands have sampled edges.
        let render = ["render", "torus.pelage", "-o", "drawn.png", "--samples", "1", "--strand-edges", "samples"];
        let drawn = sandbox.run(&[&render, &words[..], &size].concat());
        assert_eq!(drawn.code, Some(0), "{drawn:?}");
        let command = ["reference", "torus.pelage", "-o", "true.png", "--samples", "8"];
        let traced = sandbox.run(&[&command, &words[..], &size].concat());
        assert_eq!(traced.code, Some(0), "{traced:?}");
        let compared = schema::parse_success(&sandbox.run(&["compare", "drawn.png", "true.png", "--json"]), "compare");
        flips.push(compared["flip"]["mean"].as_f64().unwrap());
        let picture = |name: &str| sandbox.path().join(name);
        // The fur of the torus is less than 20 pixels high.
        errors.push(likeness(&picture("drawn.png"), &picture("true.png"), 20.0).error);
    }
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (error, flip) = (mean(&errors), mean(&flips));
    assert!((error / chosen["error"].as_f64().unwrap() - 1.0).abs() < 0.01, "{error}, {chosen}");
    let judged = &object["judged"][choice["chosen"].as_u64().unwrap() as usize];
    assert!((flip - judged["flip"].as_f64().unwrap()).abs() < 1e-4, "{flip}, {judged}");
}

#[test]
fn cost_limits_are_met() {
    if gpu("cost_limits_are_met").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    // The scattering table of the fibre alone takes 64 KiB.
    let limit = 215_000;
    let bytes = limit.to_string();
    let object =
        schema::parse_success(&bake(&sandbox, &["--max-bytes", &bytes, "--max-frame-ms", "10000", "--json"]), "bake");
    assert!(file_size(&sandbox, "torus.pelage") <= limit);
    assert_eq!(object["bytes"], file_size(&sandbox, "torus.pelage"));
    let choice = &object["choice"];
    assert_eq!(choice["binding"], "max_bytes", "{choice}");
    // The chosen trial must be the most accurate within the limit.
    let trials = choice["trials"].as_array().unwrap();
    let chosen = &trials[choice["chosen"].as_u64().unwrap() as usize];
    let error = |trial: &Value| trial["error"].as_f64().unwrap();
    let within = trials.iter().filter(|t| t["bytes"].as_u64().unwrap() <= limit);
    // Errors that differ by at most 1 % are a tie, which the smaller package wins.
    assert!(within.clone().count() > 0 && within.clone().all(|t| 1.01 * error(t) >= error(chosen)), "{choice}");
    // The next better trial must cost more, and the next cheaper one must have a larger error.
    let ms = |trial: &Value| trial["frame_ms"].as_f64().unwrap();
    if let Some(better) = choice["next_better"].as_u64().map(|i| &trials[i as usize]) {
        assert!(error(better) < error(chosen) && ms(better) >= ms(chosen), "{choice}");
    }
    if let Some(cheaper) = choice["next_cheaper"].as_u64().map(|i| &trials[i as usize]) {
        assert!(ms(cheaper) < ms(chosen) && error(cheaper) >= error(chosen), "{choice}");
    }
    // Each trial lists the components of its error. The chosen trial was timed alternately with others, and its time
    // must be within the quartiles.
    let judged = object["judged"].as_array().unwrap();
    assert_eq!(judged.len(), trials.len());
    for (parts, trial) in judged.iter().zip(trials) {
        let of = |part: &str| parts[part].as_f64().unwrap();
        assert!(of("flip") > 0.0 && of("outline") > 0.0 && of("contrast") > 0.0, "{parts}");
        assert!(error(trial) > 0.4 * of("flip"), "{trial}, {parts}");
    }
    let spread = &judged[choice["chosen"].as_u64().unwrap() as usize]["frame_ms_quartiles"];
    let [low, high] = [0, 1].map(|i| spread[i].as_f64().unwrap());
    assert!(low < high && (low..=high).contains(&ms(chosen)), "{spread}, {chosen}");
    // The text output must contain the same result.
    let run = bake(&sandbox, &["--max-bytes", &bytes]);
    for word in [
        "chosen:",
        "--max-bytes binds",
        "next better:",
        "next cheaper:",
        "measured ",
        "outline off by",
        "contrast",
        " to ",
    ] {
        assert!(run.stdout.contains(word), "{word}: {run:?}");
    }
}

#[test]
fn unreachable_limits_write_no_package_and_name_the_nearest() {
    if gpu("unreachable_limits_write_no_package_and_name_the_nearest").is_none() {
        return;
    }
    let sandbox = Sandbox::new();
    let run = bake(&sandbox, &["--max-error", "0.0001"]);
    assert_eq!(run.code, Some(3), "{run:?}");
    for word in ["torus.glb", "--max-error 0.0001", "nearest: ", "error 0.", "--set slice.layers="] {
        assert!(run.stderr.contains(word), "{word}: {run:?}");
    }
    assert!(sandbox.files().is_empty(), "{:?}", sandbox.files());
}

#[test]
fn invalid_limits_are_usage_errors() {
    let sandbox = Sandbox::new();
    for more in [
        &["--max-error", "0"][..],
        &["--max-error", "nan"],
        &["--max-frame-ms", "-1"],
        &["--max-bytes", "many"],
        &["--exhaustive"],
    ] {
        let run = bake(&sandbox, more);
        assert_eq!(run.code, Some(1), "{more:?}: {run:?}");
    }
}

#[test]
fn shells_chart_is_written() {
    if gpu("shells_chart_is_written").is_none() {
        return;
    }
    let sandbox = Sandbox::new().with_lab();
    let sets: Vec<&str> = SMALL.iter().flat_map(|set| ["--set", set]).collect();
    let run = sandbox.run(&[&["chart", "shells", "-o", "out", "--rows", "1,2,9", "--json"], &sets[..]].concat());
    let object = schema::parse_success(&run, "chart");
    let rows = object["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[0]["default"], true);
    assert_eq!(rows[1]["fins.enabled"], "false");
    for row in rows {
        assert!((0.001..0.5).contains(&row["flip"].as_f64().unwrap()), "{row}");
        assert!(row["flip_covered"].as_f64() > row["flip"].as_f64(), "{row}");
        for column in ["rmse", "coverage_error", "frame_milliseconds", "package_bytes", "gpu_bytes", "bake_seconds"] {
            assert!(row[column].as_f64().unwrap() > 0.0, "{column}: {row}");
        }
    }
    // The package must contain everything needed to slice it again.
    assert_eq!(bake(&sandbox, &["-q"]).code, Some(0));
    let run = sandbox.run(&["chart", "shells", "torus.pelage", "-o", "again", "--rows", "1,2", "--json"]);
    let own = schema::parse_success(&run, "chart");
    assert_eq!(own["rows"][0]["fins.enabled"], "false");
    assert!(own["rows"][0]["flip"].as_f64() > own["rows"][0]["coverage_error"].as_f64(), "{own}");
    // More layers must cost more, and the chart must be drawn.
    assert!(rows[2]["slice.layers"].as_f64() > rows[0]["slice.layers"].as_f64(), "{rows:?}");
    assert!(rows[2]["package_bytes"].as_f64() != rows[0]["package_bytes"].as_f64());
    assert!(std::fs::read_to_string(sandbox.path().join("out/shells.svg")).unwrap().contains("<svg"));
}
