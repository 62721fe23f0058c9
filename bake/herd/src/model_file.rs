//! Models on disk.

use std::path::Path;

/// Placeholder in the file name of a recipe; replaced by the stem of the model's file name.
pub const NAME: &str = "{name}";

/// Model on disk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModelFile {
    /// Path relative to the herd file's folder, with slashes.
    pub path: String,
    /// Size of the file, bytes.
    pub bytes: u64,
}

impl ModelFile {
    /// Returns `file` with [`NAME`] replaced by the stem of the model's file name.
    pub(super) fn expand_name(&self, file: &str) -> String {
        file.replace(NAME, &Path::new(&self.path).file_stem().unwrap_or_default().to_string_lossy())
    }
}
