//! Models on disk.

use std::path::Path;

/// Stands for the name of a model's file, without its extension, in the name of a recipe.
pub const NAME: &str = "{name}";

/// A model on disk.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// From the herd file's folder, with slashes.
    pub path: String,
    /// Of the file.
    pub bytes: u64,
}

impl Found {
    /// A file of its own name: [`NAME`] stands for that.
    pub(super) fn named(&self, file: &str) -> String {
        file.replace(NAME, &Path::new(&self.path).file_stem().unwrap_or_default().to_string_lossy())
    }
}
