//! Paths for build files.

use crate::exit::Failure;
use pelage_import::BakeError;
use std::path::{Path, PathBuf};

/// Creates an error of the file system or of a program.
pub fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> Failure {
    BakeError::Io { path: path.to_owned(), action, source }.into()
}

/// Returns an absolute path without `..`.
pub fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    if let Ok(found) = path.canonicalize() {
        return Ok(found);
    }
    // A path that does not exist yet is in a folder that exists or will be created.
    let absolute = std::path::absolute(path).map_err(|source| io_error(path, "find", source))?;
    match (absolute.parent().and_then(|parent| parent.canonicalize().ok()), absolute.file_name()) {
        (Some(parent), Some(name)) => Ok(parent.join(name)),
        _ => Ok(absolute),
    }
}

/// Returns a path as commands in `folder` name it: relative if it is below `folder`.
pub fn relative_to(folder: &Path, path: &Path) -> Result<String, Failure> {
    let path = path.strip_prefix(folder).unwrap_or(path);
    let text = utf8(path)?;
    Ok(if text.is_empty() { ".".into() } else { text.to_owned() })
}

/// Returns a path as text.
pub fn utf8(path: &Path) -> Result<&str, Failure> {
    path.to_str()
        .ok_or_else(|| Failure::Usage(format!("{}: the path is not UTF-8, which build files require", path.display())))
}
