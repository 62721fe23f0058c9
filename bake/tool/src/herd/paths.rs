//! Converts paths for build files.

use crate::exit::Failure;
use pelage_import::BakeError;
use std::path::{Path, PathBuf};

/// Creates the error for a failed `action` on `path`.
pub fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> Failure {
    BakeError::Io { path: path.to_owned(), action, source }.into()
}

/// Returns the absolute path without `..` components; the file need not exist.
pub fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    if let Ok(found) = path.canonicalize() {
        return Ok(found);
    }
    // The folder of a missing path exists or will be created.
    let absolute = std::path::absolute(path).map_err(|source| io_error(path, "find", source))?;
    match (absolute.parent().and_then(|parent| parent.canonicalize().ok()), absolute.file_name()) {
        (Some(parent), Some(name)) => Ok(parent.join(name)),
        _ => Ok(absolute),
    }
}

/// Returns the path for commands that run in `folder`: relative if it is in `folder`, otherwise absolute.
pub fn relative_to(folder: &Path, path: &Path) -> Result<String, Failure> {
    let path = path.strip_prefix(folder).unwrap_or(path);
    let text = utf8(path)?;
    Ok(if text.is_empty() { ".".into() } else { text.to_owned() })
}

/// Returns a path as UTF-8.
pub fn utf8(path: &Path) -> Result<&str, Failure> {
    path.to_str()
        .ok_or_else(|| Failure::Usage(format!("{}: the path is not UTF-8, which build files require", path.display())))
}
