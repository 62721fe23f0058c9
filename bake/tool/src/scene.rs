//! Scene files on disk, with the packages and the look that they name.

use super::exit::Failure;
use super::look_args;
use super::package_file;
use pelage_bake::io::read_text;
use pelage_formats::MAGIC;
use pelage_stage::{LoadedScene, Look, SceneFile};
use std::path::Path;

/// A scene file with its packages.
pub struct Scene {
    /// The file.
    pub file: SceneFile,
    /// Its packages, and who stands where.
    pub loaded: LoadedScene,
    /// How it says that it wants to be seen.
    pub look: Look,
}

impl Scene {
    /// Reads all of it; `bytes` are those of the file at `path`.
    ///
    /// # Errors
    ///
    /// Line and key of what is wrong with the scene, or the file that it names.
    pub fn read(path: &Path, bytes: Vec<u8>) -> Result<Self, Failure> {
        let file = SceneFile::parse(&path.display().to_string(), bytes)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut look = file.look(|path| {
            let path = folder.join(path);
            let text = read_text(&path, look_args::LOOK).map_err(|error| error.to_string())?;
            Ok((path.display().to_string(), text))
        })?;
        look.files_in(folder);
        let loaded = file.load(&package_file::Folder(folder))?;
        Ok(Self { file, loaded, look })
    }
}

/// Whether the bytes of a file speak of models and are no package: whatever its name is, every scene has a model.
pub fn speaks_of_models(bytes: &[u8]) -> bool {
    !bytes.starts_with(&MAGIC) && std::str::from_utf8(bytes).is_ok_and(|text| text.contains("[[model]]"))
}
