//! Finds the models of a herd on disk.

use super::paths::utf8;
use crate::exit::Failure;
use pelage_herd::{HerdFile, ModelFile};
use pelage_stage::TomlText;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use walkdir::{DirEntry, WalkDir};

/// Finds the models of a herd, sorted by path. Also returns notes about links and folders that cannot be followed.
/// Skips the output folder, and folders whose names begin with a dot.
///
/// * `source`: the herd file, for messages
/// * `folder`: folder of the herd file
/// * `out`: output folder, relative to `folder`
pub fn find(
    source: TomlText<'_>,
    file: &HerdFile,
    folder: &Path,
    out: &str,
) -> Result<(Vec<ModelFile>, Vec<String>), Failure> {
    let results = folder.join(out);
    let notes = RefCell::new(BTreeSet::new());
    let mut found: BTreeMap<String, u64> = BTreeMap::new();
    for (base, key) in file.folders() {
        let from = folder.join(&base);
        if !from.is_dir() {
            let reason = format!("{base:?} is not a folder, expected one relative to the folder of {}", source.name);
            return Err(HerdFile::fault(source, &key, reason).into());
        }
        let hidden = |name: &std::ffi::OsStr| name.to_string_lossy().starts_with('.');
        let walk = WalkDir::new(&from).follow_links(true).into_iter().filter_entry(|entry| {
            if entry.depth() == 0 {
                return true;
            }
            let above = folder_above(entry);
            notes.borrow_mut().extend(above.as_ref().map(|above| loop_note(entry.path(), above)));
            above.is_none() && !hidden(entry.file_name()) && (out == "." || entry.path() != results)
        });
        for entry in walk {
            let entry = match entry {
                Ok(entry) => entry,
                Err(error) => {
                    notes.borrow_mut().insert(left_out(&error, &from));
                    continue;
                }
            };
            if !entry.file_type().is_file() {
                continue;
            }
            let inside = entry.path().strip_prefix(&from).unwrap_or(entry.path());
            let shown = inside.to_string_lossy().replace('\\', "/");
            let path = match base.as_str() {
                "" => shown,
                "/" => format!("/{shown}"),
                base => format!("{base}/{shown}"),
            };
            if file.rules.model(&path).is_some() {
                // Only the names of models have to be UTF-8.
                utf8(inside)?;
                found.insert(path, entry.metadata().map_or(0, |metadata| metadata.len()));
            }
        }
    }
    let models = found.into_iter().map(|(path, bytes)| ModelFile { path, bytes }).collect();
    Ok((models, notes.into_inner().into_iter().collect()))
}

/// Returns the target of a link to a folder that contains the link; `None` for any other entry.
fn folder_above(entry: &DirEntry) -> Option<PathBuf> {
    let target = Some(entry.path()).filter(|_| entry.path_is_symlink())?.canonicalize().ok()?;
    let parent = entry.path().parent()?.canonicalize().ok()?;
    parent.starts_with(&target).then_some(target)
}

fn loop_note(link: &Path, target: &Path) -> String {
    format!("{link:?} is left out: it links to {target:?}, a folder above it")
}

/// Returns a note about an entry of a folder that cannot be followed; `from` is the folder that is searched.
fn left_out(error: &walkdir::Error, from: &Path) -> String {
    let path = error.path().unwrap_or(from);
    match (error.loop_ancestor(), error.io_error()) {
        (Some(above), _) => loop_note(path, above),
        (None, Some(source)) if path.is_symlink() => {
            format!("{path:?} is left out: its link cannot be followed: {source}")
        }
        (None, Some(source)) => format!("{path:?} is left out: it cannot be read: {source}"),
        (None, None) => format!("{path:?} is left out: {error}"),
    }
}
