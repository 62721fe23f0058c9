//! No test may vanish: none may stand in a file that no binary names, and none that needs something may be left out of the register.
//!
//! What a run says of the register is held against it by `./run test`.

use pelage_needs::Need;
use pelage_needs::register::{Entry, REGISTER, entries};
use pelage_tests::binary::{walk, workspace};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The functions by which a test asks for what it needs; its name is the argument, as a literal.
const ASKED: [(&str, Need); 7] = [
    ("gpu(", Need::Gpu),
    ("data(", Need::Data),
    ("shared(", Need::Data),
    ("cases(", Need::Data),
    ("Desktop::open(", Need::Desktop),
    ("browser(", Need::Browser),
    ("ninja(", Need::Ninja),
];

/// Files with tests that may ask.
fn sources() -> Vec<(PathBuf, String)> {
    let mut files = Vec::new();
    for folder in
        ["formats/tests", "runtime/src", "runtime/bevy/tests", "runtime/web/tests", "bake/tests", "tests/tests"]
    {
        walk(&workspace().join(folder), &mut files);
    }
    // This file names functions, and tests that there are not; what npm installs is none of ours.
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

/// Needs and names that code asks by.
fn asked(code: &str) -> BTreeSet<Entry> {
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

/// Whether code has the name as a literal, or as a word by itself.
fn names(code: &str, name: &str) -> bool {
    let in_a_word = |c: char| c.is_alphanumeric() || c == '_';
    code.match_indices(name)
        .any(|(at, _)| !code[..at].ends_with(in_a_word) && !code[at + name.len()..].starts_with(in_a_word))
}

#[test]
fn every_test_that_asks_is_registered_and_every_registered_one_is_there() {
    let registered = entries(REGISTER).unwrap_or_else(|e| panic!("tests/needs/register.txt: {e}"));
    let sources = sources();
    let mut count = 0;
    for (file, code) in &sources {
        for (need, test) in asked(code) {
            count += 1;
            let entry = format!("{} {test}", need.word());
            assert!(registered.contains(&(need, test)), "{}: `{entry}` is not in the register", file.display());
        }
    }
    assert!(count > 100, "{count} tests ask for something");
    for (need, test) in &registered {
        let there = sources.iter().any(|(_, code)| names(code, test));
        assert!(there, "no source names {test:?}, which the register has as a {} test", need.word());
    }
}

#[test]
fn askers_are_found() {
    let code =
        r#"let Some(gpu) = gpu("one") else { return }; gpu(name); to_data("no"); data("two"); shared("three", path)"#;
    let two = [(Need::Data, "two".to_owned()), (Need::Data, "three".to_owned())];
    assert_eq!(asked(code), two.into_iter().chain([(Need::Gpu, "one".to_owned())]).collect());
    assert!(names("rows!(shells, ink);", "ink") && !names("drawn_ink inky", "ink"));
}

/// The files of a binary's folder that its `main.rs` does not name, with the names of its modules.
fn orphans(main: &str, files: &[String]) -> Vec<String> {
    let named: BTreeSet<_> =
        main.lines().filter_map(|l| l.trim().strip_prefix("mod ")?.strip_suffix(';')).map(str::to_owned).collect();
    files.iter().filter(|f| *f != "main" && !named.contains(*f)).cloned().collect()
}

fn stem(path: &Path) -> Option<String> {
    Some(path.file_stem()?.to_string_lossy().into_owned())
}

#[test]
fn every_file_of_tests_is_part_of_its_binary() {
    let mut binaries = 0;
    for crates_tests in ["formats/tests", "runtime/bevy/tests", "bake/tests", "tests/tests"] {
        let mut files = Vec::new();
        walk(&workspace().join(crates_tests), &mut files);
        for main in files.iter().filter(|f| f.ends_with("main.rs")) {
            let text = std::fs::read_to_string(main).unwrap_or_else(|e| panic!("{}: {e}", main.display()));
            let beside = files.iter().filter(|f| f.parent() == main.parent() && f.extension() == main.extension());
            let orphans = orphans(&text, &beside.filter_map(|f| stem(f)).collect::<Vec<_>>());
            assert!(orphans.is_empty(), "{} does not name {orphans:?}: their tests never run", main.display());
            binaries += 1;
        }
    }
    assert!(binaries >= 6, "{binaries} binaries of several files");
}

#[test]
fn files_that_no_binary_names_are_found() {
    let files = ["main", "frames", "lost"].map(str::to_owned);
    assert_eq!(orphans("//! Doc.\n\n#[path = \"x\"]\nmod common;\nmod frames;\n", &files), ["lost"]);
}
