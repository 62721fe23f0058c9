//! Reads packages from disk.

use super::exit::Failure;
use pelage_bake::io::read_file;
use pelage_bake::io::read_named_file;
use pelage_stage::NamedPackage;
use pelage_stage::PackageSource;
use std::path::Path;
use std::path::PathBuf;

/// Reads the bytes of a package file; does not validate them.
pub fn read(path: &Path) -> Result<NamedPackage<'static>, Failure> {
    Ok(NamedPackage::new(path.display().to_string(), read_file(path)?))
}

/// Folder of the packages that a scene names; subfolders are included.
pub struct Folder<'a>(pub &'a Path);

impl PackageSource for Folder<'_> {
    fn read(&self, path: &str) -> Result<NamedPackage<'static>, String> {
        let path = self.0.join(path);
        let bytes = read_named_file(&path).map_err(|error| error.to_string())?;
        Ok(NamedPackage::new(path.display().to_string(), bytes))
    }

    fn identity(&self, path: &str) -> PathBuf {
        let path = self.0.join(path);
        // If the file is missing, reading it reports the error.
        std::fs::canonicalize(&path).unwrap_or(path)
    }
}
