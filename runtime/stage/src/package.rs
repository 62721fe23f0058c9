//! Packages, with their names for messages.

use crate::StageError;
use pelage_formats::{FormatError, Limits, Package};
use std::borrow::Cow;

/// Bytes of a package and its name for messages. The bytes may be borrowed.
#[derive(Clone)]
pub struct NamedPackage<'a> {
    /// File name as given by the user.
    pub name: String,
    /// Contents of the package.
    pub bytes: Cow<'a, [u8]>,
}

impl<'a> NamedPackage<'a> {
    /// Attaches a name to the bytes of a package, without opening it.
    pub fn new(name: impl Into<String>, bytes: impl Into<Cow<'a, [u8]>>) -> Self {
        Self { name: name.into(), bytes: bytes.into() }
    }

    /// Opens the package: header, table and manifest.
    ///
    /// Fails with [`StageError::Package`] with the name.
    pub fn open(&self) -> Result<Package<'_>, StageError> {
        Package::open(&self.bytes, &Limits::default()).map_err(|e| self.fault(e))
    }

    /// Converts `source` to an error that includes the package's name.
    pub fn fault(&self, source: FormatError) -> StageError {
        StageError::Package { file: self.name.clone(), source }
    }
}

impl std::fmt::Debug for NamedPackage<'_> {
    /// Prints the size of the package instead of its bytes.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("NamedPackage").field("name", &self.name).field("bytes", &self.bytes.len()).finish()
    }
}
