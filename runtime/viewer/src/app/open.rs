//! Opening of files: named, dropped, or the next in a folder.

use super::state::App;
use std::path::{Path, PathBuf};

/// File name extensions that the search for the next file considers.
const OPENED: [&str; 4] = ["pelage", "glb", "gltf", "obj"];

fn is_named(path: &Path, extensions: &[&str]) -> bool {
    let own = path.extension().unwrap_or_default();
    extensions.iter().any(|extension| own.eq_ignore_ascii_case(extension))
}

/// Returns the text of a look file. A look file is recognised by a table that recipes do not have.
fn look_in(path: &Path) -> Option<String> {
    let text = std::fs::read_to_string(path).ok().filter(|_| is_named(path, &["toml"]))?;
    let speaks = ["[picture]", "[light]", "[shadow]", "[fur]"]
        .iter()
        .any(|table| text.lines().any(|line| line.trim() == *table));
    speaks.then_some(text)
}

impl App {
    /// Opens a named or dropped file. Looks are read here; the workshop opens everything else.
    pub fn open(&mut self, path: &Path) {
        let mut look = self.look_base.clone();
        if look_in(path).is_some_and(|text| look.read(&text).is_ok()) {
            self.look_base = look;
            self.look_edits.forget();
            self.look_changed();
            return self.say(format!("look of {}", path.display()));
        }
        if !is_named(path, &["toml"]) {
            self.recipe_edits.forget();
        }
        self.opened = Some(path.to_owned());
        self.workers.open(path.to_owned());
    }

    /// Opens the next or previous supported file of the same folder, cyclically.
    pub fn open_next(&mut self, back: bool) {
        let Some(opened) = &self.opened else { return };
        let folder = opened.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let entries =
            std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| folder.join(entry.file_name()));
        let mut files: Vec<PathBuf> = entries.filter(|path| is_named(path, &OPENED) && path.is_file()).collect();
        files.sort();
        let at = files.iter().position(|path| path.file_name() == opened.file_name());
        let step = if back { files.len().saturating_sub(1) } else { 1 };
        let next = at.map_or(0, |at| (at + step) % files.len().max(1));
        if let Some(path) = files.get(next).cloned() {
            self.open(&path);
        }
    }
}
