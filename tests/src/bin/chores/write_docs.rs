//! Writes the reference pages that are generated from the code: `chores write-docs`.

use anyhow::Context as _;
use pelage_tests::pages::pages;

pub fn run() -> anyhow::Result<()> {
    for (path, text) in pages() {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).with_context(|| format!("{}: cannot create", folder.display()))?;
        }
        std::fs::write(&path, text).with_context(|| format!("{}: cannot write", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}
