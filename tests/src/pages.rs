//! The reference pages that are made from the code: of recipes and their coats, of looks and of the command line.

use crate::binary::{Sandbox, workspace};
use pelage_bake::recipe;
use pelage_stage::Look;
use std::path::PathBuf;

/// Every page with the path where it stands.
///
/// # Panics
/// Where the binary does not say what its command line is.
pub fn pages() -> Vec<(PathBuf, String)> {
    let run = Sandbox::new().with_lab().run(&["commands-page"]);
    assert_eq!(run.code, Some(0), "{run:?}");
    let page = |name: &str, text: String| (workspace().join("bake/docs").join(name), text);
    vec![
        page("commands.md", run.stdout),
        page("recipe.md", recipe::reference_page()),
        page("coats.md", recipe::coats_page(|picture| workspace().join("bake/docs").join(picture).exists())),
        page("look.md", Look::reference_page()),
    ]
}
