//! The only module of the library that touches files.

use crate::BakeError;
use crate::image_file::{MAX_TEXELS, decode_image};
use crate::mesh::Model;
use crate::picture::Picture;
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;
use crate::stages::import::{ImportOptions, import, input_record};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// Reads a whole file.
///
/// # Errors
///
/// [`BakeError::Io`], also for a folder.
pub fn read_file(path: &Path) -> Result<Vec<u8>, BakeError> {
    // Systems differ in what reading a folder says, from a clear word to "permission denied".
    if path.is_dir() {
        let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, expected a file");
        return Err(io_error(path, "read", source));
    }
    std::fs::read(path).map_err(|source| io_error(path, "read", source))
}

/// Reads a text file; `what` says what it should be, such as `a recipe in TOML`.
///
/// # Errors
///
/// As [`read_file`]; [`BakeError::Input`] with the byte where it is no UTF-8.
pub fn read_text(path: &Path, what: &str) -> Result<String, BakeError> {
    String::from_utf8(read_file(path)?).map_err(|error| BakeError::Input {
        file: path.display().to_string(),
        place: format!("byte {}", error.utf8_error().valid_up_to()),
        reason: format!("is no UTF-8, expected {what}"),
    })
}

/// Reads a model and the files that it names, which it looks for in its own folder.
///
/// # Errors
///
/// [`BakeError::Io`] where the model itself cannot be read, else as [`import`]; a missing buffer or image is an error in the
/// model, at the place that names it.
pub fn read_model(path: &Path, options: &ImportOptions) -> Result<Model, BakeError> {
    let bytes = read_file(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut resolve = |uri: &str| {
        let relative = relative_path(uri).map_err(|reason| BakeError::Input {
            file: path.display().to_string(),
            place: uri.to_owned(),
            reason,
        })?;
        read_file(&folder.join(relative))
    };
    import(&path.display().to_string(), &bytes, &mut resolve, options)
}

/// Reads the images that a recipe names.
///
/// * `file`: the recipe as the user named it, for messages
/// * `folder`: where its paths begin
///
/// # Errors
///
/// [`BakeError::Input`] in the recipe, naming key and image, where one cannot be read or decoded.
pub fn read_map_images(file: &str, folder: &Path, recipe: &Recipe) -> Result<MapImages, BakeError> {
    let mut read = MapImages::default();
    let mut texels_left = MAX_TEXELS;
    for (key, name) in recipe.images() {
        let path = folder.join(name);
        let fail = |reason: String| BakeError::Input { file: file.to_owned(), place: key.clone(), reason };
        let bytes = read_file(&path).map_err(|error| fail(error.to_string()))?;
        let image = decode_image(&bytes, texels_left).map_err(|reason| fail(format!("{} {reason}", path.display())))?;
        texels_left -= u64::from(image.width) * u64::from(image.height);
        read.inputs.push(input_record("image", name, &bytes));
        read.images.insert(name.to_owned(), image);
    }
    Ok(read)
}

/// Reads a picture, PNG or EXR.
///
/// # Errors
///
/// [`BakeError::Io`], and [`BakeError::Input`] for what is no such picture.
pub fn read_picture(path: &Path) -> Result<Picture, BakeError> {
    let fail = |(place, reason)| BakeError::Input { file: path.display().to_string(), place, reason };
    Picture::decode(&read_file(path)?).map_err(fail)
}

/// The path that a relative URI names, or why there is none.
fn relative_path(uri: &str) -> Result<PathBuf, String> {
    let scheme = uri.split_once(':').map(|(scheme, _)| scheme).filter(|scheme| {
        let mut letters = scheme.chars();
        letters.next().is_some_and(|c| c.is_ascii_alphabetic())
            && letters.all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    });
    if let Some(scheme) = scheme {
        let drive = if scheme.len() == 1 { " (or a drive)" } else { "" };
        return Err(format!(
            "it has the scheme `{scheme}`{drive}; expected a relative path: put the file beside the model"
        ));
    }
    let decoded = urlencoding::decode(uri).map_err(|_| "its percent-encoding is no UTF-8".to_owned())?;
    if decoded.is_empty() {
        return Err("it is empty; expected a relative path".to_owned());
    }
    if decoded.contains('\0') {
        return Err("it holds a zero byte; expected a relative path".to_owned());
    }
    // Both kinds of slash, so that a model is refused alike on every system.
    if decoded.starts_with(['/', '\\']) || Path::new(&*decoded).is_absolute() {
        return Err("it is an absolute path; expected a relative one: put the file beside the model".to_owned());
    }
    Ok(PathBuf::from(&*decoded))
}

/// Writes `bytes` to a file that appears, or replaces an older one, only when it is whole.
///
/// The bytes go to a temporary file in the same folder, which is then renamed; on failure it is removed. A new file has the
/// permissions that the umask leaves. Symbolic links are followed; devices and pipes are written to directly.
///
/// # Errors
///
/// [`BakeError::Io`], naming `path` or its folder.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    write_atomic_with(path, |out| out.write_all(bytes))
}

/// As [`write_atomic`], with what `write` streams into the file.
///
/// # Errors
///
/// [`BakeError::Io`], naming `path` or its folder; also for an error of `write`.
pub fn write_atomic_with(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> io::Result<()>,
) -> Result<(), BakeError> {
    let write = |file: &std::fs::File| {
        let mut out = io::BufWriter::new(file);
        write(&mut out)?;
        out.flush()
    };
    // A link stays a link: what it points to is replaced.
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match std::fs::metadata(&target) {
        Ok(found) if found.is_dir() => {
            let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, expected a file name");
            return Err(io_error(path, "write", source));
        }
        // Renaming a file over /dev/null would replace the device.
        Ok(found) if !found.is_file() => {
            let open = std::fs::OpenOptions::new().write(true).open(&target);
            return open.and_then(|f| write(&f)).map_err(|source| io_error(path, "write", source));
        }
        _ => {}
    }
    if target.file_name().is_none() {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "it has no file name");
        return Err(io_error(path, "write", source));
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pelage-").suffix(".tmp");
    // Temporary files are private by default; the umask takes away from this what the user wants taken away.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(|source| io_error(folder, "create a file in", source))?;
    let written = write(file.as_file()).and_then(|()| file.as_file().sync_all());
    written.map_err(|source| io_error(path, "write", source))?;
    file.persist(&target).map_err(|error| io_error(path, "rename a temporary file to", error.error))?;
    Ok(())
}
