//! Finds the models of a herd on disk.

use super::paths::utf8;
use crate::exit::Failure;
use pelage_herd::{HerdFile, ModelFile};
use pelage_import::BakeError;
use pelage_stage::TomlText;
use std::collections::BTreeMap;
use std::path::Path;
use walkdir::WalkDir;

/// Finds the models of a herd, sorted by path. Skips the output folder, and folders whose names begin with a dot.
///
/// * `source`: the herd file, for messages
/// * `folder`: folder of the herd file
/// * `out`: output folder, relative to `folder`
pub fn find(source: TomlText<'_>, file: &HerdFile, folder: &Path, out: &str) -> Result<Vec<ModelFile>, Failure> {
    let results = folder.join(out);
    let mut found: BTreeMap<String, u64> = BTreeMap::new();
    for (base, key) in file.folders() {
        let from = folder.join(&base);
        if !from.is_dir() {
            let reason = format!("{base:?} is not a folder, expected one relative to the folder of {}", source.name);
            return Err(HerdFile::fault(source, &key, reason).into());
        }
        let hidden = |name: &std::ffi::OsStr| name.to_string_lossy().starts_with('.');
        let walk = WalkDir::new(&from).follow_links(true).into_iter().filter_entry(|entry| {
            entry.depth() == 0 || !hidden(entry.file_name()) && (out == "." || entry.path() != results)
        });
        for entry in walk {
            let entry = entry.map_err(|error| {
                let path = error.path().unwrap_or(&from).to_owned();
                let source =
                    error.into_io_error().unwrap_or_else(|| std::io::Error::other("symbolic links form a loop"));
                BakeError::Io { path, action: "read", source }
            })?;
            if !entry.file_type().is_file() {
                continue;
            }
            let inside = utf8(entry.path().strip_prefix(&from).unwrap_or(entry.path()))?.replace('\\', "/");
            let path = match base.as_str() {
                "" => inside,
                "/" => format!("/{inside}"),
                base => format!("{base}/{inside}"),
            };
            if file.rules.model(&path).is_some() {
                found.insert(path, entry.metadata().map_or(0, |metadata| metadata.len()));
            }
        }
    }
    Ok(found.into_iter().map(|(path, bytes)| ModelFile { path, bytes }).collect())
}
