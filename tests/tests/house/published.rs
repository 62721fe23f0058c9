//! Crates that a registry takes: what their manifests say, and that the gate checks each of their features alone.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use super::dependencies::cargo;
use pelage_tests::binary::workspace;
use serde_json::Value;
use std::path::Path;

/// The crates that may be published, as `cargo metadata` describes them.
fn published() -> Vec<Value> {
    let metadata: Value = serde_json::from_str(&cargo("metadata", &["--no-deps", "--format-version", "1"])).unwrap();
    // `publish = false` is an empty list of registries.
    let may = |package: &&Value| package["publish"].is_null();
    let packages: Vec<Value> = metadata["packages"].as_array().unwrap().iter().filter(may).cloned().collect();
    assert!(packages.len() >= 7, "{packages:?}");
    packages
}

#[test]
fn manifests_say_what_a_registry_shows() {
    for package in published() {
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
        // Links to the repository's own; what a registry is sent has their texts.
        for licence in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let text = |folder: &Path| std::fs::read_to_string(folder.join(licence)).unwrap_or_default();
            assert!(text(folder) == text(workspace()) && !text(folder).is_empty(), "{name} has no {licence}");
        }
    }
}

/// A package holds all that it is built from, so `bake/built_in` has copies of what the demo shows.
#[test]
fn what_comes_with_the_binary_is_what_stands_in_assets() {
    let read = |path: &Path| std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut names = pelage_tests::binary::files(&workspace().join("bake/built_in"));
    names.retain(|name| name != "README.md");
    assert_eq!(names.len(), 4, "{names:?}");
    for name in names {
        let folder = if name.ends_with(".glb") { "models" } else { "recipes" };
        let (copy, asset) =
            (workspace().join("bake/built_in").join(&name), workspace().join("assets").join(folder).join(&name));
        assert!(
            read(&copy) == read(&asset),
            "{} is another file than {}: copy it anew",
            copy.display(),
            asset.display()
        );
    }
}

#[test]
fn the_gate_checks_every_feature_alone() {
    let run = std::fs::read_to_string(workspace().join("run")).unwrap();
    for package in published() {
        let name = package["name"].as_str().unwrap();
        let features = package["features"].as_object().unwrap();
        // With a default that is not nothing, nothing has to be asked for.
        let bare = if features.contains_key("default") { " --no-default-features" } else { "" };
        let mut selections = vec![format!("\"{name}{bare}\"")];
        selections.extend(
            features
                .keys()
                .filter(|f| f.as_str() != "default")
                .map(|feature| format!("\"{name} --features {feature}\"")),
        );
        for selection in selections {
            assert!(run.contains(&selection), "./run does not check {selection}");
        }
    }
}
