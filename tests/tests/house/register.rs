//! Checks that no test is lost: each test file belongs to a binary, and each test that requires a resource is
//! registered.
//!
//! `./run test` checks the log of a run against the register.

use pelage_needs::Need;
use pelage_needs::register::{Entry, REGISTER, entries};
use pelage_tests::binary::{walk, workspace};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Functions with which a test requests a resource; the argument is the test's name as a literal.
const ASKED: [(&str, Need); 7] = [
    ("gpu(", Need::Gpu),
    ("data(", Need::Data),
    ("shared(", Need::Data),
    ("cases(", Need::Data),
    ("Desktop::open(", Need::Desktop),
    ("browser(", Need::Browser),
    ("ninja(", Need::Ninja),
];

/// Returns the files whose tests may request resources.
fn sources() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for folder in ["formats/tests", "runtime/src", "runtime/bevy/tests", "runtime/web/tests", "tests/tests"] {
        walk(&workspace().join(folder), &mut files);
    }
    // Excludes files installed by npm, and this file, which contains the function names and fictitious tests.
    files.retain(|f| {
        let is_ours = !f.ends_with("house/register.rs") && !f.iter().any(|part| part == "node_modules");
        is_ours && f.extension().is_some_and(|e| e == "rs" || e == "mjs")
    });
    let read = |f: PathBuf| {
        let text = std::fs::read_to_string(&f).unwrap_or_else(|e| panic!("{}: {e}", f.display()));
        (f, text)
    };
    files.into_iter().map(read).collect()
}

/// Returns the resources that code requests, with the names of the tests.
fn requests(code: &str) -> BTreeSet<Entry> {
    let mut found = BTreeSet::new();
    for (word, need) in ASKED {
        for (at, _) in code.match_indices(word) {
            let part_of_a_name = code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
            let name = code[at + word.len()..].strip_prefix('"').and_then(|rest| rest.split('"').next());
            if let Some(name) = name.filter(|_| !part_of_a_name) {
                found.insert((need, name.to_owned()));
            }
        }
    }
    found
}

/// Returns whether the code contains the name, as a literal or as a whole word.
fn mentions(code: &str, name: &str) -> bool {
    let in_a_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(name)
        .any(|(at, _)| !code[..at].ends_with(in_a_word) && !code[at + name.len()..].starts_with(in_a_word))
}

#[test]
fn tests_that_request_resources_match_the_register() {
    let registered = entries(REGISTER).unwrap_or_else(|e| panic!("tests/needs/register.txt: {e}"));
    let sources = sources();
    let mut count = 0;
    for (file, code) in &sources {
        for (need, test) in requests(code) {
            count += 1;
            let entry = format!("{} {test}", need.name());
            assert!(registered.contains(&(need, test)), "{}: `{entry}` is not in the register", file.display());
        }
    }
    assert!(count > 100, "only {count} tests request a resource");
    for (need, test) in &registered {
        let there = sources.iter().any(|(_, code)| mentions(code, test));
        assert!(there, "no source names {test:?}, which the register has as a {} test", need.name());
    }
}

#[test]
fn requests_for_resources_are_found() {
    let code =
        r#"let Some(gpu) = gpu("one") else { return }; gpu(name); to_data("no"); data("two"); shared("three", path)"#;
    let two = [(Need::Data, "two".to_owned()), (Need::Data, "three".to_owned())];
    assert_eq!(requests(code), two.into_iter().chain([(Need::Gpu, "one".to_owned())]).collect());
    assert!(mentions("rows!(shells, ink);", "ink") && !mentions("drawn_ink inky", "ink"));
}

/// Returns the modules that are in the folder of a crate root or `mod.rs`, but are not declared in that file.
fn orphans(root: &str, beside: &[String]) -> Vec<String> {
    let declared = |line: &str| {
        let line = line.trim();
        Some(line.strip_prefix("pub ").unwrap_or(line).strip_prefix("mod ")?.strip_suffix(';')?.to_owned())
    };
    let named: BTreeSet<_> = root.lines().filter_map(declared).collect();
    beside.iter().filter(|module| !named.contains(*module)).cloned().collect()
}

fn stem(path: &Path) -> Option<String> {
    Some(path.file_stem()?.to_string_lossy().into_owned())
}

#[test]
fn every_file_of_tests_is_part_of_its_binary() {
    let mut roots = 0;
    for crates_tests in ["bake/tests", "formats/tests", "runtime/bevy/tests", "tests/tests"] {
        let folder = workspace().join(crates_tests);
        let mut files = Vec::new();
        walk(&folder, &mut files);
        files.retain(|f| f.extension().is_some_and(|e| e == "rs"));
        // Cargo makes a binary from each file directly in the folder, and from each folder with a `main.rs`.
        let is_root = |f: &Path| f.ends_with("main.rs") || f.ends_with("mod.rs") || f.parent() == Some(&folder);
        for root in files.iter().filter(|f| is_root(f)) {
            let text = std::fs::read_to_string(root).unwrap_or_else(|e| panic!("{}: {e}", root.display()));
            let module = |f: &PathBuf| match f.parent() {
                parent if f.ends_with("mod.rs") && parent.and_then(Path::parent) == root.parent() => stem(parent?),
                parent if parent == root.parent() && !is_root(f) => stem(f),
                _ => None,
            };
            let orphans = orphans(&text, &files.iter().filter_map(module).collect::<Vec<_>>());
            assert!(orphans.is_empty(), "{} does not name {orphans:?}: their tests never run", root.display());
            roots += 1;
        }
    }
    assert!(roots >= 10, "only {roots} files declare modules");
}

#[test]
fn orphaned_test_files_are_found() {
    let files = ["common", "frames", "lost"].map(str::to_owned);
    assert_eq!(orphans("//! Doc.\n\n#[path = \"x\"]\npub mod common;\nmod frames;\n", &files), ["lost"]);
}
