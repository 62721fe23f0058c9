//! Packages and what messages call them.

use crate::StageError;
use pelage_formats::{FormatError, Limits, Package};
use std::borrow::Cow;

/// A package's bytes and the name that messages use. The bytes may be borrowed.
#[derive(Clone)]
pub struct NamedPackage<'a> {
    /// As the user named it.
    pub name: String,
    /// All of it.
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> NamedPackage<'a> {
    /// Names some bytes; opens nothing yet.
    pub fn new(name: impl Into<String>, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }

    /// Opens the package: header, table and manifest.
    ///
    /// # Errors
    ///
    /// [`StageError::Package`] with the name.
    pub fn open(&self) -> Result<Package<'_>, StageError> {
        Package::open(&self.bytes, &Limits::default()).map_err(|e| self.fault(e))
    }

    /// `source` with the package's name.
    pub fn fault(&self, source: FormatError) -> StageError {
        StageError::Package { file: self.name.clone(), source }
    }
}

impl std::fmt::Debug for NamedPackage<'_> {
    /// Says how large the package is, not its megabytes.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NamedPackage").field("name", &self.name).field("bytes", &self.bytes.len()).finish()
    }
}
