//! The runtime's house, read off its sources: a file knows only files of lower floors, and no files know each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Floors from the lowest up: a room is a file or a folder of `runtime/src`. ARCHITECTURE.md says what each is for.
const FLOORS: [&[&str]; 12] = [
    &["error", "report", "shared", "bounds"],
    &["camera", "gpu"],
    &["params"],
    &["study", "surface"],
    &["model", "light"],
    &["instance", "ink"],
    &["motion", "hair"],
    &["scene"],
    &["passes"],
    &["hooks"],
    &["frame"],
    &["renderer"],
];

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the runtime's sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// Module path of a file below `src`: `passes/skin/mod.rs` is `passes::skin`.
fn module_of(file: &Path, source: &Path) -> Vec<String> {
    let inside = file.strip_prefix(source).expect("inside the sources").with_extension("");
    let mut names: Vec<String> = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if names.last().is_some_and(|name| name == "mod" || name == "lib") {
        names.pop();
    }
    names
}

/// Code without comments and strings, and without what only tests compile.
fn code_of(text: &str) -> String {
    let end = text.find("#[cfg(test)]\n#[allow").unwrap_or(text.len());
    text[..end].lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Paths that code names, `crate::…` and `super::…`, with braces of imports taken apart.
fn paths_in(code: &str, own: &[String]) -> BTreeSet<Vec<String>> {
    let mut found = BTreeSet::new();
    for (start, _) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        let before = code[..start].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == ':') {
            continue;
        }
        unfold(&code[start..], Vec::new(), own, &mut found);
    }
    found
}

/// Adds what a path stands for, `a::b`, `a::{b, c::d}` or `a::*`, and returns how far it reaches.
fn unfold(text: &str, mut path: Vec<String>, own: &[String], found: &mut BTreeSet<Vec<String>>) -> usize {
    let mut at = 0;
    loop {
        let name: String = text[at..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        at += name.len();
        match name.as_str() {
            "" => {}
            "crate" => path.clear(),
            "self" if path.is_empty() => path = own.to_vec(),
            "self" => {}
            // The first of several leads from this file, each other one a step up.
            "super" if path.is_empty() => path = own[..own.len().saturating_sub(1)].to_vec(),
            "super" => drop(path.pop()),
            _ => path.push(name),
        }
        if text[at..].starts_with("::{") {
            at += 3;
            loop {
                at += text[at..].len() - text[at..].trim_start().len();
                if text[at..].starts_with('}') || text[at..].is_empty() {
                    return at + 1;
                }
                at += unfold(&text[at..], path.clone(), own, found);
                at += text[at..].len() - text[at..].trim_start().len();
                if text[at..].starts_with(',') {
                    at += 1;
                }
            }
        }
        if !text[at..].starts_with("::") {
            found.insert(path);
            return at;
        }
        at += 2;
    }
}

/// Each file's module with the modules of the files that it names.
fn arrows() -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../runtime/src");
    let mut files = Vec::new();
    rust_files(&source, &mut files);
    files.retain(|f| !f.to_string_lossy().ends_with("_tests.rs") && !f.to_string_lossy().contains("/probe/"));
    // The file that stands in for another without its feature is read with it: both know the same rooms.
    let modules: BTreeSet<_> = files.iter().map(|f| module_of(f, &source)).collect();
    let mut out = BTreeMap::new();
    for file in &files {
        let own = module_of(file, &source);
        let text = std::fs::read_to_string(file).expect("a source file");
        let named = paths_in(&code_of(&text), &own);
        let home =
            |path: &Vec<String>| (0..=path.len()).rev().map(|n| path[..n].to_vec()).find(|m| modules.contains(m));
        let targets: BTreeSet<_> = named.iter().filter_map(home).filter(|target| *target != own).collect();
        out.insert(own, targets);
    }
    out
}

fn floor_of(module: &[String]) -> Option<usize> {
    FLOORS.iter().position(|rooms| module.first().is_some_and(|room| rooms.contains(&room.as_str())))
}

/// Files that lead back to themselves.
fn circle(arrows: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Option<Vec<Vec<String>>> {
    let (mut done, mut way) = (BTreeSet::new(), Vec::new());
    fn walk(
        at: &Vec<String>,
        arrows: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
        done: &mut BTreeSet<Vec<String>>,
        way: &mut Vec<Vec<String>>,
    ) -> Option<Vec<Vec<String>>> {
        if let Some(from) = way.iter().position(|seen| seen == at) {
            return Some(way[from..].to_vec());
        }
        if !done.insert(at.clone()) {
            return None;
        }
        way.push(at.clone());
        let found = arrows.get(at).into_iter().flatten().find_map(|next| walk(next, arrows, done, way));
        way.pop();
        found
    }
    arrows.keys().find_map(|start| walk(start, arrows, &mut done, &mut way))
}

#[test]
fn a_file_knows_only_lower_floors_and_none_in_a_circle() {
    let arrows = arrows();
    assert!(arrows.len() > 50, "{} files were read", arrows.len());
    let mut count = 0;
    for (file, targets) in &arrows {
        // The crate's root lists all rooms and has none of its own.
        let Some(floor) = floor_of(file) else {
            assert!(file.is_empty(), "{file:?} stands on no floor");
            continue;
        };
        for target in targets {
            let below = floor_of(target).unwrap_or_else(|| panic!("{file:?} names {target:?}, the root or no floor"));
            assert!(below < floor || target.first() == file.first(), "{file:?} (floor {floor}) names {target:?}");
            count += 1;
        }
    }
    assert!(count > 100, "{count} arrows were read");
    assert_eq!(circle(&arrows), None);
}

#[test]
fn circles_and_imports_are_found() {
    let own = ["scene".to_string(), "ink".to_string()];
    let code = "use crate::{a::{B, c}, d};\nuse super::seen::Seen;\nlet x = crate::e::f();\nmycrate::no; use super::{self, g};";
    let found: Vec<String> = paths_in(code, &own).iter().map(|p| p.join("::")).collect();
    assert_eq!(found, ["a::B", "a::c", "d", "e::f", "scene", "scene::g", "scene::seen::Seen"]);
    let name = |n: &str| vec![n.to_string()];
    let mut graph = BTreeMap::from([
        (name("a"), BTreeSet::from([name("b")])),
        (name("b"), BTreeSet::from([name("c")])),
        (name("c"), BTreeSet::new()),
    ]);
    assert_eq!(circle(&graph), None);
    graph.insert(name("c"), BTreeSet::from([name("a")]));
    assert_eq!(circle(&graph).map(|c| c.len()), Some(3));
}
