//! Checks the layering of the crates with `cargo tree`: which crate may depend on which.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_tests::binary::workspace;
use std::collections::BTreeSet;
use std::process::Command;

/// Runs a cargo command in this workspace without network access, and returns its stdout.
pub fn cargo(command: &str, arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .args([command, "--offline", "--locked"])
        .args(arguments)
        .current_dir(workspace())
        .output()
        .unwrap();
    assert!(output.status.success(), "cargo {command}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Returns the names of all crates that a normal build of `package` links, itself included.
fn tree(package: &str, options: &[&str]) -> BTreeSet<String> {
    let normal = ["--package", package, "--edges", "normal", "--prefix", "none", "--format", "{p}", "--target", "all"];
    let text = cargo("tree", &[&normal, options].concat());
    let names: BTreeSet<_> = text.lines().filter_map(|l| l.split_whitespace().next()).map(str::to_owned).collect();
    assert!(names.contains(package), "{package} is not in its own tree: {names:?}");
    names
}

#[track_caller]
fn assert_dependencies(package: &str, options: &[&str], knows: &[&str], never: &[&str]) {
    let names = tree(package, options);
    for name in knows {
        assert!(names.contains(*name), "{package} {options:?} should depend on {name}: {names:?}");
    }
    for name in never {
        assert!(!names.contains(*name), "{package} {options:?} must not depend on {name}");
    }
}

#[test]
fn formats_depends_on_no_gpu_thread_pool_or_tool() {
    let never = ["wgpu", "naga", "rayon", "clap", "image", "gltf", "tempfile", "pelage-runtime", "pelage-bake"];
    assert_dependencies("pelage-formats", &[], &["serde", "bincode", "ktx2", "glam"], &never);
}

#[test]
fn glb_depends_only_on_json() {
    let never = ["wgpu", "naga", "rayon", "clap", "image", "glam", "tempfile", "pelage-formats", "pelage-runtime"];
    assert_dependencies("pelage-glb", &[], &["serde_json"], &never);
    assert_dependencies("pelage-formats", &[], &[], &["pelage-glb", "serde_json"]);
}

#[test]
fn params_depends_only_on_text_crates() {
    let never = ["wgpu", "naga", "rayon", "clap", "image", "glam", "tempfile", "pelage-formats", "pelage-runtime"];
    assert_dependencies("pelage-params", &[], &["strsim", "toml"], &never);
}

#[test]
fn runtime_depends_only_on_formats_and_the_gpu() {
    let never = ["clap", "rayon", "image", "gltf", "tempfile", "indicatif", "pelage-bake"];
    assert_dependencies("pelage-runtime", &[], &["wgpu", "pelage-formats", "glam", "bytemuck"], &never);
}

#[test]
fn stage_depends_on_the_gpu_only_with_its_draw_feature() {
    let never = ["clap", "rayon", "image", "tempfile", "indicatif", "pelage-bake", "winit"];
    let knows = ["pelage-formats", "glam", "serde", "toml"];
    assert_dependencies(
        "pelage-stage",
        &[],
        &knows,
        &[&never[..], &["wgpu", "wgpu-core", "naga", "pelage-runtime"]].concat(),
    );
    assert_dependencies("pelage-stage", &["--features", "draw"], &["pelage-runtime", "wgpu"], &never);
}

#[test]
fn viewer_depends_on_windowing_and_not_on_importers() {
    let never = ["clap", "rayon", "gltf", "pelage-bake", "pelage-glb"];
    assert_dependencies("pelage-viewer", &[], &["winit", "egui", "wgpu", "pelage-stage", "pelage-runtime"], &never);
    // Without the window feature, the tool can draw but links no window crate.
    assert_dependencies("pelage-tool", &["--no-default-features"], &["wgpu"], &["winit", "egui", "pelage-viewer"]);
}

#[test]
fn web_depends_on_the_stage_and_adds_nothing_to_native_builds() {
    let never = ["clap", "rayon", "image", "tempfile", "indicatif", "pelage-bake", "winit"];
    assert_dependencies("pelage-web", &[], &["pelage-stage", "wasm-bindgen", "wgpu"], &never);
    let native = ["tree", "--package", "pelage-web", "--edges", "normal", "--prefix", "none"];
    assert_eq!(cargo(native[0], &native[1..]).lines().count(), 1, "the native build must add no other crate");
}

#[test]
fn binder_and_module_use_the_same_wasm_bindgen() {
    let version = |manifest: &str, name: &str| {
        let text = std::fs::read_to_string(workspace().join(manifest)).unwrap();
        let line = text.lines().find(|line| line.starts_with(&format!("{name} = "))).map(str::to_owned);
        line.and_then(|line| Some(line.split_once("\"=")?.1.trim_end_matches('"').to_owned()))
    };
    let module = version("Cargo.toml", "wasm-bindgen");
    assert!(module.is_some(), "the root manifest pins wasm-bindgen");
    assert_eq!(module, version("runtime/web/binder/Cargo.toml", "wasm-bindgen-cli-support"));
}

#[test]
fn importer_depends_only_on_formats_and_codecs() {
    let never = ["wgpu", "clap", "rayon", "pelage-stage", "pelage-bake"];
    assert_dependencies("pelage-import", &[], &["pelage-formats", "draco-core", "image"], &never);
}

#[test]
fn baker_and_reference_depend_on_no_gpu() {
    let never = ["wgpu", "wgpu-core", "naga", "pelage-runtime", "winit"];
    assert_dependencies(
        "pelage-bake",
        &[],
        &["pelage-formats", "pelage-import", "rayon"],
        &[&never[..], &["pelage-truth"]].concat(),
    );
    assert_dependencies(
        "pelage-truth",
        &[],
        &["pelage-bake", "obvhs"],
        &[&never[..], &["pelage-tool", "pelage-lab"]].concat(),
    );
    assert_dependencies("pelage-herd", &[], &["fast-glob"], &[&never[..], &["pelage-bake", "pelage-tool"]].concat());
}

#[test]
fn asset_models_depend_only_on_the_gltf_writer() {
    let never = [
        "wgpu",
        "rayon",
        "clap",
        "gltf",
        "pelage-formats",
        "pelage-params",
        "pelage-stage",
        "pelage-runtime",
        "pelage-bake",
        "pelage-tests",
    ];
    assert_dependencies("pelage-assets", &[], &["glam", "image", "libm", "pelage-glb"], &never);
}

#[test]
fn tool_depends_on_the_runtime_and_not_on_the_lab() {
    // Negative control: in the full tree, the same check finds wgpu and the window crates.
    assert_dependencies("pelage-tool", &[], &["pelage-runtime", "wgpu", "pelage-viewer"], &["pelage-lab"]);
    assert_dependencies("pelage-lab", &[], &["pelage-tool", "plotters"], &[]);
}

/// Checks that published forms of formulas are compiled only for the laboratory.
#[test]
fn shipped_packages_lack_the_study_feature() {
    for (package, expected) in
        [("pelage-tool", false), ("pelage-viewer", false), ("pelage-web", false), ("pelage-lab", true)]
    {
        let features = ["--package", package, "--edges", "normal,features", "--prefix", "none", "--target", "all"];
        assert_eq!(cargo("tree", &features).contains("feature \"study\""), expected, "{package}");
    }
}
