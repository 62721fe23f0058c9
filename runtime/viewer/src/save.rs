//! Files written by a window. Existing files are never overwritten, and files are written completely or not at all.

use image::{ImageFormat, RgbaImage};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

/// Largest number tried for a file name.
const MOST: u32 = 10_000;

/// Returns the first unused name `stem-0001.ext` in a folder.
///
/// Fails if all names are in use.
pub fn free(folder: &Path, stem: &str, ext: &str) -> Result<PathBuf, String> {
    let name = |number| folder.join(format!("{stem}-{number:04}.{ext}"));
    let found = (1..MOST).map(name).find(|path| !path.exists());
    found.ok_or_else(|| format!("{}: all names up to {stem}-{MOST}.{ext} are taken", folder.display()))
}

/// Writes a file atomically: writes to a temporary file in the same folder, then renames it.
///
/// Fails with the file name, and the system's message.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let fail = |error: std::io::Error| format!("{}: cannot write: {error}", path.display());
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let written =
        std::fs::File::create(&part).and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()));
    written.and_then(|()| std::fs::rename(&part, path)).map_err(|error| {
        // The temporary file is incomplete and useless.
        let _ = std::fs::remove_file(&part);
        fail(error)
    })
}

/// Writes a picture as PNG.
///
/// Fails like [`write`].
pub fn write_png(path: &Path, picture: &RgbaImage) -> Result<(), String> {
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, ImageFormat::Png).map_err(|error| format!("{}: {error}", path.display()))?;
    write(path, png.get_ref())
}

/// Returns the stem of a file name, on which names of saved files are based.
pub fn stem(name: &str) -> String {
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    stem.filter(|stem| !stem.is_empty()).unwrap_or_else(|| "picture".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn saving_overwrites_nothing_and_leaves_no_temporary_files() {
        let folder = tempfile::tempdir().unwrap();
        let first = free(folder.path(), "fox", "png").unwrap();
        assert_eq!(first, folder.path().join("fox-0001.png"));
        write_png(&first, &RgbaImage::new(2, 3)).unwrap();
        let second = free(folder.path(), "fox", "png").unwrap();
        assert_eq!(second, folder.path().join("fox-0002.png"));
        assert_eq!(image::open(&first).unwrap().width(), 2);
        let error = write(&folder.path().join("no/such.png"), b"").unwrap_err();
        assert!(error.contains("such.png: cannot write"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!((stem("a/fox.pelage"), stem("")), ("fox".into(), "picture".into()));
    }
}
