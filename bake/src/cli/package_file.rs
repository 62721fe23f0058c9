//! Reading packages from disk.

use super::exit::Failure;
use pelage_bake::BakeError;
use pelage_bake::io::read_file;
use pelage_formats::{FormatError, Limits, Package};
use std::path::Path;

/// A package's bytes and the name that messages use.
pub struct PackageFile {
    /// As the user named it.
    pub name: String,
    /// All of it.
    pub bytes: Vec<u8>,
}

impl PackageFile {
    /// Reads the file; opens nothing yet.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self { name: path.display().to_string(), bytes: read_file(path)? })
    }

    /// Opens the package: header, table and manifest.
    pub fn open(&self) -> Result<Package<'_>, Failure> {
        Package::open(&self.bytes, &Limits::default()).map_err(|e| self.fault(e))
    }

    /// `error` with the file's name.
    pub fn fault(&self, source: FormatError) -> Failure {
        BakeError::Package { file: self.name.clone(), source }.into()
    }
}
