//! Edits a recipe file. Keys get new values, and everything else in the file is unchanged.

use pelage_bake::{io, recipe};
use pelage_import::BakeError;
use std::path::Path;
use toml_edit::{DocumentMut, Item, Table};

/// Writes the changes (`key=value`) into a recipe file, which is created if missing.
pub fn change(path: &Path, edits: &[String]) -> Result<(), BakeError> {
    let file = path.display().to_string();
    let text = if path.exists() { io::read_text(path, "a recipe in TOML")? } else { String::new() };
    let changed =
        with(&text, edits).map_err(|(place, reason)| BakeError::Input { file: file.clone(), place, reason })?;
    // The changed text is validated before the file is written.
    recipe::Recipe::parse(&file, &changed)?;
    io::rewrite_atomic(path, changed.as_bytes())
}

/// Returns the text with the changes applied.
fn with(text: &str, edits: &[String]) -> Result<String, (String, String)> {
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
        let before = text.get(..error.span().map_or(0, |span| span.start)).unwrap_or_default();
        (format!("line {}", before.lines().count().max(1)), error.message().to_owned())
    })?;
    for edit in edits {
        let fail = |reason: &str| (edit.clone(), reason.to_owned());
        let (name, value) = edit.split_once('=').ok_or_else(|| fail("found no `=`, expected key=value"))?;
        let (table, key) = name.split_once('.').ok_or_else(|| fail("found no table, expected table.key=value"))?;
        let knob = recipe::keys().find(|knob| knob.name == name).ok_or_else(|| fail("unknown key"))?;
        // Strings need no quotes, as on the command line.
        let value: toml_edit::Value = value.parse().unwrap_or_else(|_| value.into());
        let at = document.entry(table).or_insert_with(|| Item::Table(Table::new()));
        let at = at
            .as_table_like_mut()
            .ok_or_else(|| fail("the part before the . is a value in this file, expected a table"))?;
        knob.was.iter().for_each(|old| drop(at.remove(old)));
        match at.get_mut(key).and_then(Item::as_value_mut) {
            Some(old) => {
                let decor = old.decor().clone();
                *old = value;
                // The comment at the end of the line is kept.
                *old.decor_mut() = decor;
            }
            None => drop(at.insert(key, Item::Value(value))),
        }
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_keep_comments_and_order() {
        let text =
            "# My fox.\n[hair] # all of it\ncoat = \"winter\"\nlean = 0.4 # not too much\n\n[fins]\nenabled = false\n";
        let edits = ["hair.lean=0.25", "color.root=\"#804020\"", "hair.seed=7"].map(String::from);
        let changed = with(text, &edits).unwrap();
        assert_eq!(
            changed,
            "# My fox.\n[hair] # all of it\ncoat = \"winter\"\nlean = 0.25 # not too much\nseed = 7\n\n\
             [fins]\nenabled = false\n\n[color]\nroot = \"#804020\"\n"
        );
        assert_eq!(with("", &edits[..1]).unwrap(), "[hair]\nlean = 0.25\n");
    }

    #[test]
    fn invalid_edits_are_reported_and_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fox.toml");
        std::fs::write(&path, "[hair]\nlean = 0.4\n").unwrap();
        let error = change(&path, &["hair.lean=7.0".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("fox.toml") && error.contains("hair.lean"), "{error}");
        std::fs::write(&path, "[hair]\nlean = = 0.4\n").unwrap();
        let error = change(&path, &["hair.lean=0.3".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("line 2"), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "[hair]\nlean = = 0.4\n");
    }
}
