//! What the README says about recipes and commands, held against the code.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_bake::recipe::{Recipe, keys};
use pelage_runtime::PassId;
use pelage_tests::binary::{Sandbox, workspace};
use pelage_tests::documents::{cited_formulas, documents, links, named_documents, numbered_headings};
use pelage_tests::pages::pages;

/// The README's table of recipe keys.
fn recipe_table() -> String {
    let defaults = Recipe::default();
    let mut table = "| key | default | expects | meaning |\n|---|---|---|---|\n".to_owned();
    for key in keys() {
        let value = key.value(&defaults).map_or("from the model".to_owned(), |v| format!("`{v}`"));
        let doc = key.doc.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        table += &format!("| `{}` | {value} | {} | {doc} |\n", key.name, (key.expected)());
    }
    table
}

#[test]
fn the_readme_lists_every_recipe_key() {
    let readme = std::fs::read_to_string(workspace().join("README.md")).unwrap();
    let table = recipe_table();
    assert!(table.lines().count() > 20, "{table}");
    assert!(readme.contains(&table), "README.md, \"Recipes\", should hold this table:\n{table}");
}

#[test]
fn the_reference_pages_are_what_the_code_says() {
    let pages = pages();
    assert!(pages.iter().all(|(_, page)| page.lines().count() > 100), "a page is nearly empty");
    for (path, page) in pages {
        let there = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            there == page,
            "{} is not what the code says: cargo run -p pelage-tests --bin write_docs",
            path.display()
        );
    }
}

#[test]
fn the_readme_names_every_subcommand() {
    let readme = std::fs::read_to_string(workspace().join("README.md")).unwrap();
    let help = Sandbox::new().run(&["--help"]).stdout;
    let commands = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    // A command stands two spaces in; the lines that its description goes on in stand further in.
    let names: Vec<_> = commands
        .lines()
        .filter_map(|l| l.strip_prefix("  ").filter(|l| !l.starts_with(' '))?.split_whitespace().next())
        .collect();
    assert!(names.contains(&"bake") && names.contains(&"render"), "{help}");
    for name in names.into_iter().filter(|n| *n != "help") {
        assert!(readme.contains(&format!("`pelage {name} ")), "README.md does not explain `pelage {name}`");
    }
}

/// The passes of a frame as ARCHITECTURE.md lists them.
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

/// Every section of the formula sheet that code or a document cites.
#[test]
fn every_cited_formula_stands_in_the_sheet() {
    const SHEET: &str = "formats/docs/formulas.md";
    let sheet = std::fs::read_to_string(workspace().join(SHEET)).unwrap();
    let sections = numbered_headings(&sheet);
    let mut cited = 0;
    // This crate's own reader of citations has made-up ones in its tests.
    let all = documents(&["rs", "wgsl", "md", "toml"]).into_iter().filter(|d| d.path != "tests/src/documents.rs");
    for document in all {
        for section in cited_formulas(&document.text) {
            assert!(sections.contains(&section), "{} cites formulas {section}, which {SHEET} has not", document.path);
            cited += 1;
        }
    }
    assert!(sections.len() > 30 && cited > 10, "{} sections, {cited} citations", sections.len());
}

/// Sources and documents name no document that a reader of the repository does not have.
#[test]
fn every_named_document_is_in_the_repository() {
    let there: Vec<String> = documents(&["md"]).into_iter().map(|d| d.path).collect();
    let is_there = |name: &str| {
        let name = name.trim_start_matches(['.', '/']);
        there.iter().any(|path| path == name || path.ends_with(&format!("/{name}")))
    };
    let mut named = 0;
    for document in documents(&["rs", "wgsl", "md", "toml"]) {
        // Tests write documents that never were.
        if document.path == "tests/src/documents.rs" {
            continue;
        }
        for name in named_documents(&document.text) {
            assert!(is_there(&name), "{} names {name}, which is not in the repository", document.path);
            named += 1;
        }
    }
    assert!(named > 20, "only {named} found");
}

/// The pages of decisions: each is in the index, and each decision says what it must.
#[test]
fn every_decision_says_why_and_what_would_change_it() {
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
