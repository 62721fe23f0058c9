//! What the README says about recipes and commands, held against the code.
#![allow(clippy::unwrap_used, reason = "in tests a panic is the report")]

use pelage_bake::recipe::{Recipe, keys};
use pelage_runtime::PassId;
use pelage_tests::binary::{Sandbox, workspace};

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
