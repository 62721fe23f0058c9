//! Reads scene files with their packages and looks.

use super::exit::Failure;
use super::{look_args, package_file};
use pelage_bake::io::read_text;
use pelage_formats::MAGIC;
use pelage_stage::{LoadedScene, Look, SceneFile};
use std::path::Path;

/// Scene file with its packages.
pub struct Scene {
    /// Parsed file.
    pub file: SceneFile,
    /// Packages, and the positions and poses of all instances.
    pub loaded: LoadedScene,
    /// Look of the scene.
    pub look: Look,
}

impl Scene {
    /// Reads a scene and its packages; `bytes` are the contents of the file at `path`.
    ///
    /// Fails for an invalid scene, with line and key, and for an unreadable file that it names.
    pub fn read(path: &Path, bytes: Vec<u8>) -> Result<Self, Failure> {
        let file = SceneFile::parse(&path.display().to_string(), bytes)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut look = file.look(|path| {
            let path = folder.join(path);
            let text = read_text(&path, look_args::LOOK).map_err(|error| error.to_string())?;
            Ok((path.display().to_string(), text))
        })?;
        look.resolve_files(folder);
        let loaded = file.load(&package_file::Folder(folder))?;
        Ok(Self { file, loaded, look })
    }
}

/// Returns true if the bytes are a scene, not a package: text that contains `[[model]]`. The file name is ignored.
pub fn is_scene(bytes: &[u8]) -> bool {
    !bytes.starts_with(&MAGIC) && std::str::from_utf8(bytes).is_ok_and(|text| text.contains("[[model]]"))
}
