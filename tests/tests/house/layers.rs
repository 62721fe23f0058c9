//! Checks dependencies between the files of a crate: there are no cycles, and in runtime and bake a file uses only
//! lower layers.

use super::sources::{Dependencies, Module, UsedPath, dependencies, find_cycle, modules, used_paths};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Layers of the runtime, lowest first. An entry is a file or a folder of `runtime/src`; runtime/docs/house.md
/// describes each.
const RUNTIME: [&[&str]; 14] = [
    &["error", "report", "shared", "bounds"],
    &["camera", "gpu"],
    &["params"],
    &["debug", "study", "surface"],
    &["model", "light"],
    &["instance", "ink", "contours"],
    &["guide_motion", "painting"],
    &["fur_motion"],
    &["motion", "hair"],
    &["scene"],
    &["passes"],
    &["hooks"],
    &["frame"],
    &["renderer"],
];

/// Layers of the baker, lowest first: basics; masks and sampling; pictures; the recipe; the stages; strands and files
/// on disk; the order of the stages; users of the pipeline.
const BAKE: [&[&str]; 8] = [
    &["decision", "noise", "progress", "temp_files", "memo", "io_trace", "io_guard", "hexadecimal"],
    &["mask", "sample"],
    &["picture", "y4m"],
    &["recipe"],
    &["stages"],
    &["strands", "io", "recipe_mismatch"],
    &["pipeline"],
    &["reslice", "rebake", "groom_map", "environment_file", "cache"],
];

/// Returns the dependencies between the files of a crate.
fn dependencies_of(folder: &str) -> Dependencies {
    dependencies(&modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder).join("src")))
}

/// Returns the folders of all crates, from the manifest of the workspace.
fn crates() -> Vec<String> {
    let manifest = include_str!("../../../Cargo.toml");
    let list = manifest.split("members = [").nth(1).and_then(|rest| rest.split(']').next()).unwrap_or_default();
    list.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Returns the dependencies that do not lead to a lower layer, and the number of all dependencies. Crate roots may use
/// every entry and have no layer.
fn upward_dependencies(arrows: &Dependencies, floors: &[&[&str]]) -> (Vec<String>, usize) {
    let floor =
        |module: &Module| floors.iter().position(|rooms| module.first().is_some_and(|r| rooms.contains(&r.as_str())));
    let (mut faults, mut count) = (Vec::new(), 0);
    for (file, targets) in arrows.iter().filter(|(file, _)| !file.is_empty() && file[0] != "main") {
        for target in targets {
            let below = matches!((floor(file), floor(target)), (Some(here), Some(there)) if there < here);
            if !below && target.first() != file.first() {
                faults.push(format!("{} names {}", file.join("::"), target.join("::")));
            }
            count += 1;
        }
    }
    let homeless = arrows.keys().filter(|file| !file.is_empty() && file[0] != "main" && floor(file).is_none());
    faults.extend(homeless.map(|file| format!("{} belongs to no layer", file.join("::"))));
    (faults, count)
}

#[test]
fn files_have_no_import_cycles() {
    let crates = crates();
    assert!(crates.len() >= 8, "{crates:?}");
    let (mut files, mut count) = (0, 0);
    for folder in crates {
        let arrows = dependencies_of(&folder);
        (files, count) = (files + arrows.len(), count + arrows.values().map(BTreeSet::len).sum::<usize>());
        assert_eq!(find_cycle(&arrows), None, "{folder}");
    }
    assert!(files > 300 && count > 800, "{files} files and {count} dependencies were read");
}

/// Returns the dependencies between the top-level files and folders of a crate's `src`.
fn folder_graph(arrows: &Dependencies) -> Dependencies {
    let room = |module: &Module| module[..module.len().min(1)].to_vec();
    let mut out = Dependencies::new();
    for (file, targets) in arrows.iter().filter(|(file, _)| !file.is_empty() && file[0] != "main") {
        let others = targets.iter().map(room).filter(|target| !target.is_empty() && *target != room(file));
        out.entry(room(file)).or_default().extend(others);
    }
    out
}

/// Crates whose folders still have cyclic dependencies. No crate may be added.
const CIRCLES: [&str; 2] = ["formats", "bake/lab"];

#[test]
fn folders_have_no_import_cycles() {
    let circles: Vec<_> =
        crates().into_iter().filter_map(|c| Some((find_cycle(&folder_graph(&dependencies_of(&c)))?, c))).collect();
    assert_eq!(circles.iter().map(|(_, folder)| folder).collect::<Vec<_>>(), CIRCLES.each_ref(), "{circles:?}");
    // In this example, the files have no cyclic dependency. The folder `a` and the file `d` beside it have one.
    let module = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Module>();
    let files = Dependencies::from([
        (module(&["a", "b"]), BTreeSet::from([module(&["d"])])),
        (module(&["a", "c"]), BTreeSet::new()),
        (module(&["d"]), BTreeSet::from([module(&["a", "c"])])),
    ]);
    assert!(find_cycle(&files).is_none() && find_cycle(&folder_graph(&files)).is_some());
}

#[test]
fn files_import_only_from_lower_layers() {
    for (folder, floors, least) in [("runtime", &RUNTIME[..], 100), ("bake", &BAKE[..], 400)] {
        let (faults, count) = upward_dependencies(&dependencies_of(folder), floors);
        assert!(faults.is_empty(), "{folder}: {faults:#?}");
        assert!(count > least, "{folder}: {count} dependencies were read");
    }
}

#[test]
fn imports_are_found() {
    let own = ["scene".to_string(), "ink".to_string()];
    let code = "use crate::{a::{B, c}, d};\nuse super::seen::Seen;\nlet x = crate::e::f();\n\
                mycrate::no; use super::{self, g};\n\
                pub(in crate::nothing) fn part::of();\npub use part::Line as L;\n\
                mod within { use super::h; use super::super::i; }";
    let found = used_paths(code, &own, &BTreeSet::from(["part".to_string()]));
    let paths: Vec<String> = found.iter().map(|n| n.path.join("::")).collect();
    let expected = [
        "a::B",
        "a::c",
        "d",
        "e::f",
        "scene",
        "scene::g",
        "scene::i",
        "scene::ink::h",
        "scene::ink::part::Line",
        "scene::ink::part::of",
        "scene::seen::Seen",
    ];
    assert_eq!(paths, expected);
    let handed_on: Vec<&UsedPath> = found.iter().filter(|n| n.handed_on).collect();
    assert!(handed_on.len() == 1 && handed_on[0].called == "L", "{handed_on:?}");
}

/// Returns the dependencies of a crate with three files.
fn three_file_crate(root: &str, a: &str, b: &str) -> Dependencies {
    let module = |name: &str| if name.is_empty() { Vec::new() } else { vec![name.to_string()] };
    dependencies(&BTreeMap::from([(module(""), root.into()), (module("a"), a.into()), (module("b"), b.into())]))
}

#[test]
fn import_cycles_and_upward_imports_are_found() {
    let fine = three_file_crate("pub mod a;\nmod b;\npub use b::B;", "use crate::B;", "pub struct B;");
    assert_eq!(find_cycle(&fine), None, "re-exports of the root are not its own items");
    assert_eq!(upward_dependencies(&fine, &[&["b"], &["a"]]), (Vec::new(), 1));
    let (faults, _) = upward_dependencies(&fine, &[&["a"], &["b"]]);
    assert_eq!(faults, ["a names b"]);
    let (faults, _) = upward_dependencies(&fine, &[&["b"]]);
    assert_eq!(faults, ["a names b", "a belongs to no layer"]);
    for (root, a, b) in [
        ("", "use crate::b::B;", "use super::a;"),
        ("pub use b::B;", "crate::B::new()", "fn f() { super::a::g() }"),
        ("fn x() { b::y() }", "", "use super::x;"),
    ] {
        assert!(find_cycle(&three_file_crate(root, a, b)).is_some_and(|c| c.len() == 2), "{root:?} {a:?} {b:?}");
    }
}
