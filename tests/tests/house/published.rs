//! Checks that the crates can be published: their manifests, and that the gate checks each feature alone.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::dependencies::cargo;
use pelage_tests::binary::workspace;
use serde_json::Value;
use std::path::Path;

/// Returns the `cargo metadata` of the crates that may be published.
fn publishable_crates() -> Vec<Value> {
    let metadata: Value = serde_json::from_str(&cargo("metadata", &["--no-deps", "--format-version", "1"])).unwrap();
    // In the metadata, `publish = false` is an empty list of registries.
    let may = |package: &&Value| package["publish"].is_null();
    let packages: Vec<Value> = metadata["packages"].as_array().unwrap().iter().filter(may).cloned().collect();
    assert!(packages.len() >= 7, "{packages:?}");
    packages
}

#[test]
fn published_manifests_have_registry_metadata() {
    for package in publishable_crates() {
        let name = package["name"].as_str().unwrap();
        let count = |key: &str| package[key].as_array().unwrap().len();
        assert!((1..=5).contains(&count("keywords")) && (1..=5).contains(&count("categories")), "{name}");
        for key in ["description", "license", "documentation", "rust_version"] {
            assert!(package[key].as_str().is_some_and(|text| !text.is_empty()), "{name} has no {key}");
        }
        let folder = Path::new(package["manifest_path"].as_str().unwrap()).parent().unwrap();
        let readme = std::fs::read_to_string(folder.join(package["readme"].as_str().unwrap())).unwrap();
        assert!(readme.starts_with(&format!("# {name}\n")), "{name}: {}", readme.lines().next().unwrap());
        assert_eq!(package["metadata"]["docs"]["rs"]["all-features"], true, "{name}");
        // The licences are links to those of the repository; a published archive contains their texts.
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let text = |folder: &Path| std::fs::read_to_string(folder.join(licence)).unwrap_or_default();
            assert!(text(folder) == text(workspace()) && !text(folder).is_empty(), "{name} has no {licence}");
        }
    }
}

/// Checks that `bake/tool/built_in` has unmodified copies of the demo's files; a published package must contain all of
/// its sources.
#[test]
fn built_in_files_equal_those_in_assets() {
    let read = |path: &Path| std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut names = pelage_tests::binary::files(&workspace().join("bake/tool/built_in"));
    names.retain(|name| name != "README.md");
    assert_eq!(names.len(), 4, "{names:?}");
    for name in names {
        let folder = if name.ends_with(".glb") { "models" } else { "recipes" };
        let (copy, asset) =
            (workspace().join("bake/tool/built_in").join(&name), workspace().join("assets").join(folder).join(&name));
        assert!(read(&copy) == read(&asset), "{} differs from {}: copy it again", copy.display(), asset.display());
    }
}

/// Returns the crates and features in the script `run` that the gate lints in addition to the whole workspace.
fn selections() -> Vec<String> {
    let run = std::fs::read_to_string(workspace().join("run")).unwrap();
    let list = run.split("for selection in ").nth(1).and_then(|rest| rest.split("; do").next()).unwrap();
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_gate_checks_every_feature_on_and_off() {
    let selections = selections();
    let workspace_build = "--workspace".to_owned();
    // Each line of a tree is `NAME vVERSION (FOLDER) FEATURES`, for every crate of a selection.
    let trees: Vec<String> = selections
        .iter()
        .map(|selection| format!("--package {selection}"))
        .chain([workspace_build])
        .map(|options| {
            let words = options.split(' ').chain(["--edges", "normal", "--prefix", "none", "--format", "{p};{f}"]);
            cargo("tree", &words.collect::<Vec<_>>())
        })
        .collect();
    for package in publishable_crates() {
        let name = package["name"].as_str().unwrap();
        let seen: Vec<Vec<&str>> = trees
            .iter()
            .flat_map(|tree| tree.lines().filter(|line| line.starts_with(&format!("{name} "))))
            .map(|line| line.split(';').nth(1).unwrap_or_default().trim_end_matches(" (*)").split(',').collect())
            .collect();
        assert!(!seen.is_empty(), "./run lints nothing of {name}");
        for feature in package["features"].as_object().unwrap().keys().filter(|f| f.as_str() != "default") {
            for on in [true, false] {
                assert!(
                    seen.iter().any(|features| features.contains(&feature.as_str()) == on),
                    "{name} {feature} {on}"
                );
            }
        }
    }
}
