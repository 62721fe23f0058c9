//! Checks documents against the code and against each other.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use pelage_bake::recipe::Recipe;
use pelage_runtime::PassId;
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::documents::{
    anchors, cited_formulas, documents, links, named_documents, named_paths, numbered_headings, resolve,
};
use pelage_tests::pages::pages;

#[test]
fn reference_pages_are_up_to_date() {
    let pages = pages();
    assert!(pages.iter().all(|(_, page)| page.lines().count() > 100), "a page is nearly empty");
    for (path, page) in pages {
        let there = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            there == page,
            "{} is not what the code says: cargo run -p pelage-tests --bin chores -- write-docs",
            path.display()
        );
    }
}

#[test]
fn the_readme_names_every_subcommand() {
    let readme = std::fs::read_to_string(workspace().join("README.md")).unwrap();
    let help = Sandbox::new().run(&["--help"]).stdout;
    let commands = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    // A line with a command is indented by two spaces; continuation lines of its description are indented further.
    let names: Vec<_> = commands
        .lines()
        .filter_map(|l| l.strip_prefix("  ").filter(|l| !l.starts_with(' '))?.split_whitespace().next())
        .collect();
    assert!(names.contains(&"bake") && names.contains(&"render"), "{help}");
    for name in names.into_iter().filter(|n| *n != "help") {
        assert!(readme.contains(&format!("`pelage {name} ")), "README.md does not explain `pelage {name}`");
    }
}

/// Checks that ARCHITECTURE.md lists the passes of a frame.
#[test]
fn the_architecture_lists_every_pass() {
    let document = std::fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap();
    let row = |pass: PassId| format!("| `{}` | {} | {} |\n", pass.name(), pass.does(), pass.runs_when());
    let table: String = PassId::all().map(row).collect();
    let table = format!("| pass | does | runs when |\n|---|---|---|\n{table}");
    assert!(
        table.lines().count() > 10 && document.contains(&table),
        "ARCHITECTURE.md should hold this table:\n{table}"
    );
}

/// Checks that every section of the formula sheet cited by code or documents exists.
#[test]
fn every_cited_formula_exists() {
    const SHEET: &str = "formats/docs/formulas.md";
    let sheet = std::fs::read_to_string(workspace().join(SHEET)).unwrap();
    let sections = numbered_headings(&sheet);
    let mut cited = 0;
    // The tests of the citation parser contain fictitious citations.
    let all = documents(&["rs", "wgsl", "md", "toml"]).into_iter().filter(|d| d.path != "tests/src/documents.rs");
    for document in all {
        for section in cited_formulas(&document.text) {
            assert!(
                sections.contains(&section),
                "{} cites formulas {section}, which {SHEET} does not have",
                document.path
            );
            cited += 1;
        }
    }
    assert!(sections.len() > 30 && cited > 10, "{} sections, {cited} citations", sections.len());
}

/// Checks that sources and documents name only documents of the repository.
#[test]
fn every_named_document_is_in_the_repository() {
    let there: Vec<String> = documents(&["md"]).into_iter().map(|d| d.path).collect();
    let is_there = |name: &str| {
        let name = name.trim_start_matches(['.', '/']);
        there.iter().any(|path| path == name || path.ends_with(&format!("/{name}")))
    };
    let mut named = 0;
    for document in documents(&["rs", "wgsl", "md", "toml"]) {
        // The tests in this file contain fictitious names of documents.
        if document.path == "tests/src/documents.rs" {
            continue;
        }
        for name in named_documents(&document.text) {
            assert!(is_there(&name), "{} names {name}, which is not in the repository", document.path);
            named += 1;
        }
    }
    assert!(named > 20, "only {named} names of documents found");
}

/// Checks that the index lists every page of decisions, and that every decision has the required parts.
#[test]
fn every_decision_states_reason_and_revision_criterion() {
    let index = std::fs::read_to_string(workspace().join("formats/docs/decisions.md")).unwrap();
    let listed: Vec<String> = links(&index).into_iter().map(|(path, _)| path).collect();
    let mut decisions = 0;
    for document in documents(&["md"]).into_iter().filter(|d| d.path.contains("/docs/decisions/")) {
        let name = document.path.rsplit('/').next().unwrap();
        assert!(listed.iter().any(|path| path.ends_with(name)), "the index does not list {}", document.path);
        for decision in document.text.split("\n## ").skip(1) {
            for part in ["Context", "Choice", "Figure", "What would change it"] {
                assert!(decision.contains(&format!("- **{part}.** ")), "{}: {decision}\nhas no {part}", document.path);
            }
            decisions += 1;
        }
    }
    assert!(decisions >= 43, "only {decisions} decisions");
}

/// Checks that all files, folders and link targets in documents exist.
#[test]
fn paths_and_links_in_documents_exist() {
    let mut pointed = 0;
    for document in documents(&["md"]) {
        for path in named_paths(&document.text) {
            let there = workspace().join(&path).exists() || resolve(&document, &path).exists();
            assert!(there, "{} names `{path}`, which does not exist", document.path);
            pointed += 1;
        }
        for (path, anchor) in links(&document.text) {
            let found = if path.is_empty() { workspace().join(&document.path) } else { resolve(&document, &path) };
            assert!(found.exists(), "{} links to {path}, which does not exist", document.path);
            if !anchor.is_empty() {
                let there = anchors(&std::fs::read_to_string(&found).unwrap());
                assert!(there.contains(&anchor), "{} links to {path}#{anchor}: {there:?}", document.path);
            }
            pointed += 1;
        }
    }
    assert!(pointed > 100, "only {pointed} paths and links found");
}

/// Checks the length of the two documents that are read first.
#[test]
fn documents_read_first_stay_short() {
    for path in ["README.md", "ARCHITECTURE.md"] {
        let lines = std::fs::read_to_string(workspace().join(path)).unwrap().lines().count();
        assert!(lines <= 150, "{path} has {lines} lines, expected at most 150");
    }
}

/// Checks that all recipes, keys and options on the pages for artists and scripts are valid.
#[test]
fn commands_in_documents_are_valid() {
    let sandbox = Sandbox::new().with_lab();
    let mut options = String::new();
    for command in [
        "bake",
        "render",
        "reference",
        "export",
        "bench",
        "doctor",
        "compare",
        "chart",
        "demo",
        "inspect",
        "groom",
        "sky",
    ] {
        options += &sandbox.run(&[command, "--help"]).stdout;
    }
    // These options belong to cargo, not to pelage.
    let others =
        ["path", "release", "locked", "bin", "example", "no-default-features", "workspace", "bench", "exhaustive"];
    let (mut recipes, mut keys_set, mut options_named) = (0, 0, 0);
    for path in [
        "README.md",
        "bake/docs/artists.md",
        "bake/docs/painting.md",
        "bake/docs/scripts.md",
        "runtime/docs/performance.md",
    ] {
        let text = std::fs::read_to_string(workspace().join(path)).unwrap();
        for block in text.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()) {
            if let Err(error) = Recipe::parse(path, block) {
                panic!("{error}\n{block}");
            }
            recipes += 1;
        }
        for assignment in text.split("--set ").skip(1) {
            // An assignment is quoted if the shell would split it.
            let end: &[char] = if assignment.starts_with('\'') { &['\''] } else { &[' ', '`', '\n'] };
            let assignment = assignment.trim_start_matches('\'').split(end).next().unwrap();
            if assignment != "key=value" {
                assert!(Recipe::default().set(assignment).is_ok(), "{path}: {:?}", Recipe::default().set(assignment));
                keys_set += 1;
            }
        }
        for (at, _) in text.match_indices("--") {
            let name: String = text[at + 2..].chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '-').collect();
            let begins = text[..at].ends_with([' ', '`', '\n']) && name.starts_with(|c: char| c.is_ascii_lowercase());
            if begins && !others.contains(&name.as_str()) {
                assert!(options.contains(&format!("--{name}")), "{path} names --{name}, which no command has");
                options_named += 1;
            }
        }
    }
    assert!(recipes > 5 && keys_set > 20 && options_named > 50, "{recipes}, {keys_set}, {options_named}");
}
