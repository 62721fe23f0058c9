//! Reference pages that are generated from the code: recipes and coats, looks, the command line and its JSON schemas.

use crate::binary::{Sandbox, workspace};
use pelage_bake::recipe;
use pelage_stage::Look;
use serde_json::Value;
use std::path::PathBuf;

/// Returns the path and text of every page.
///
/// # Panics
/// If the binary does not describe its command line.
pub fn pages() -> Vec<(PathBuf, String)> {
    let run = Sandbox::new().with_lab().run(&["commands-page", "--json"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let said: Value = serde_json::from_str(&run.stdout).unwrap_or_else(|e| panic!("{e}: {run:?}"));
    let page = |name: &str, text: String| (workspace().join("bake/docs").join(name), text);
    vec![
        page("commands.md", format!("{}\n", said["page"].as_str().unwrap_or_default().trim_end())),
        page("schemas.json", format!("{:#}\n", said["schemas"])),
        page("recipe.md", recipe::reference_page()),
        page("coats.md", recipe::coats_page(|picture| workspace().join("bake/docs").join(picture).exists())),
        page("look.md", Look::reference_page()),
    ]
}
