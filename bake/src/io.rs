//! File access; no other module of the library touches files.

use crate::picture::Picture;
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;
use crate::stages::import::{ImportOptions, import, import_strands, input_record};
use crate::temp_files::{TEMP_FILE_AFFIXES, TempFileGuard};
use crate::{io_guard, io_trace};
use pelage_import::BakeError;
use pelage_import::guides::read::GuideFormat;
use pelage_import::image_file::{Channels, MAX_TEXELS, decode_image, fit_images};
use pelage_import::mesh::Model;
use sha2::{Digest as _, Sha256};
use std::fs::FileType;
use std::io::{self, Read as _, Write as _};
use std::path::{Component, Path, PathBuf};

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// Size limit for input files, bytes. Real packages and models are far smaller. With a larger file, the data derived
/// from it would not fit into memory.
pub const MAX_FILE_BYTES: u64 = 2 << 30;

/// Reads a whole file that the user named, which may be a pipe.
///
/// Fails with [`BakeError::Io`], also for a folder, a device, and a file larger than [`MAX_FILE_BYTES`].
pub fn read_file(path: &Path) -> Result<Vec<u8>, BakeError> {
    read_whole(path, |kind| kind.is_file() || is_pipe(kind), || "an input".to_owned())
}

/// Reads a text file; `what` is the expected content for messages, such as `a recipe in TOML`.
///
/// Fails with the errors of [`read_file`]; [`BakeError::Input`] with the byte offset if the file is not UTF-8.
pub fn read_text(path: &Path, what: &str) -> Result<String, BakeError> {
    String::from_utf8(read_file(path)?).map_err(|error| BakeError::Input {
        file: path.display().to_string(),
        place: format!("byte {}", error.utf8_error().valid_up_to()),
        reason: format!("is not UTF-8, expected {what}"),
    })
}

/// Reads a whole file that another file names. Only regular files are accepted, because reading a pipe might block
/// forever.
///
/// Fails with the errors of [`read_file`]; [`BakeError::Io`] also for a pipe.
pub fn read_named_file(path: &Path) -> Result<Vec<u8>, BakeError> {
    read_file_named_by(path, "another input")
}

/// Reads a file as [`read_named_file`] does; `by` is the file or key that names it.
fn read_file_named_by(path: &Path, by: &str) -> Result<Vec<u8>, BakeError> {
    read_whole(path, FileType::is_file, || named_by(by))
}

/// Returns the role of a file that `by` names, for messages.
fn named_by(by: &str) -> String {
    format!("named by {by}")
}

fn read_whole(path: &Path, may_be: fn(&FileType) -> bool, role: impl FnOnce() -> String) -> Result<Vec<u8>, BakeError> {
    let bytes = read_prefix(path, MAX_FILE_BYTES + 1, may_be, role)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let text = format!("it is larger than {MAX_FILE_BYTES} bytes, the limit for one file");
        return Err(io_error(path, "read", io::Error::new(io::ErrorKind::FileTooLarge, text)));
    }
    Ok(bytes)
}

/// Reads the first `most` bytes of a file; `role` is that of the file in messages about outputs.
fn read_prefix(
    path: &Path,
    most: u64,
    may_be: fn(&FileType) -> bool,
    role: impl FnOnce() -> String,
) -> Result<Vec<u8>, BakeError> {
    let fail = |source| io_error(path, "read", source);
    // Noted before the read, because a caller may continue without a file that cannot be read.
    io_guard::record_read(path, role);
    // The file type is checked before opening, because opening a pipe waits for its writer.
    let found = std::fs::metadata(path).map_err(fail)?;
    if !may_be(&found.file_type()) {
        // Operating systems report different errors for reading a folder, some as vague as "permission denied".
        let kind = if found.is_dir() { io::ErrorKind::IsADirectory } else { io::ErrorKind::InvalidInput };
        let text = format!("it is {}, expected a file", kind_of(&found.file_type()));
        return Err(fail(io::Error::new(kind, text)));
    }
    // The length is only a hint: files under /proc report 0, and any file may grow during the read.
    let mut bytes = Vec::with_capacity(found.len().min(most) as usize);
    std::fs::File::open(path).and_then(|file| file.take(most).read_to_end(&mut bytes)).map_err(fail)?;
    io_trace::record_read(path, most, Some(&bytes));
    Ok(bytes)
}

#[cfg(unix)]
fn is_pipe(kind: &FileType) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(kind)
}

#[cfg(not(unix))]
fn is_pipe(_: &FileType) -> bool {
    false
}

/// Returns a description of a file that is not a regular file.
fn kind_of(kind: &FileType) -> &'static str {
    if kind.is_dir() {
        "a folder"
    } else if is_pipe(kind) {
        "a pipe"
    } else {
        "a device or a socket"
    }
}

/// Files that a model may refer to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// Files in the model's folder and below, after following links. Use this for untrusted models.
    #[default]
    OwnFolder,
    /// Any readable file, such as `../textures/fox.png`.
    Anywhere,
}

/// Reads a model and the files that it refers to, relative to its folder. All must be regular files. At most the
/// declared length of each buffer is read.
///
/// Fails with [`BakeError::Io`] if the model itself cannot be read, otherwise the errors of [`import`]. A buffer or
/// image that is missing or outside `reach` is reported as an error in the model, at its reference.
pub fn read_model(path: &Path, options: &ImportOptions, reach: Reach) -> Result<Model, BakeError> {
    read_model_noting(path, options, reach, &mut |_| ())
}

/// Reads a model as [`read_model`] does. Calls `named` with the path of each referenced file within `reach`, before the
/// file is read.
///
/// Fails with the errors of [`read_model`].
pub fn read_model_noting(
    path: &Path,
    options: &ImportOptions,
    reach: Reach,
    named: &mut dyn FnMut(&Path),
) -> Result<Model, BakeError> {
    let bytes = read_file(path)?;
    let mut resolve = resolver(path, reach, named);
    let model = import(&path.display().to_string(), &bytes, &mut resolve, options);
    // An output among the model's own files explains any other fault, for example a buffer that is overwritten.
    io_guard::check().and(model)
}

/// Returns the function that reads the files a model refers to.
fn resolver<'a>(
    model: &'a Path,
    reach: Reach,
    named: &'a mut dyn FnMut(&Path),
) -> impl FnMut(&str, u64) -> Result<Vec<u8>, BakeError> + 'a {
    let folder = model.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    move |uri: &str, most: u64| {
        let fail = |reason| BakeError::Input { file: model.display().to_string(), place: uri.to_owned(), reason };
        let relative = relative_path(uri).map_err(fail)?;
        if reach == Reach::OwnFolder && !stays_inside(folder, &relative) {
            return Err(fail(
                "it leads out of the model's folder; expected a file in that folder or below it: move it there or, if \
                 you trust the model, pass --allow-outside"
                    .to_owned(),
            ));
        }
        let path = folder.join(relative);
        named(&path);
        read_prefix(&path, most, FileType::is_file, || named_by(&model.display().to_string()))
    }
}

/// Extensions of strand files that are read as models, with each polyline as a strand.
const LINE_EXTENSIONS: [&str; 2] = ["glb", "gltf"];

/// Whether `folder` joined with `relative` is inside `folder`, both lexically and after following links. A path that
/// leaves the folder lexically is rejected even if no such file exists. So the answer does not reveal which files
/// exist.
fn stays_inside(folder: &Path, relative: &Path) -> bool {
    let mut depth = 0_usize;
    for component in relative.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => match depth.checked_sub(1) {
                Some(less) => depth = less,
                None => return false,
            },
            Component::RootDir | Component::Prefix(_) => return false,
        }
    }
    match (folder.canonicalize(), folder.join(relative).canonicalize()) {
        (Ok(folder), Ok(file)) => file.starts_with(folder),
        // The file does not exist.
        _ => true,
    }
}

/// Reads the images and strand files that a recipe names.
///
/// * `file`: path of the recipe as the user gave it, for messages
/// * `place`: maps a name in the recipe to a path
///
/// Fails with [`BakeError::Input`] in the recipe, with key and image, if a file cannot be read or decoded.
pub fn read_map_images(file: &str, place: &dyn Fn(&str) -> PathBuf, recipe: &Recipe) -> Result<MapImages, BakeError> {
    let mut read = MapImages::default();
    let mut texels_left = MAX_TEXELS;
    for (key, name) in recipe.images() {
        let path = place(name);
        let fail = |reason: String| BakeError::Input { file: file.to_owned(), place: key.clone(), reason };
        let by = format!("{file}, {key}");
        let bytes = read_file_named_by(&path, &by).map_err(|error| fail(error.to_string()))?;
        let channels =
            if key.ends_with("color") || key.ends_with("pattern") { Channels::Color } else { Channels::Values };
        let decoded = decode_image(&bytes, &mut texels_left, channels);
        let (image, note) = decoded.map_err(|reason| fail(format!("{} {reason}", path.display())))?;
        read.warnings.extend(note.map(|note| format!("{key}: {} {note}", path.display())));
        read.inputs.push(input_record("image", name, &bytes));
        read.images.insert(name.to_owned(), image);
        let mut images: Vec<_> = read.images.values_mut().collect();
        let warning = fit_images(&mut images, Channels::Values);
        read.warnings.extend(warning.filter(|warning| !read.warnings.contains(warning)));
    }
    for (key, name) in recipe.strand_files() {
        let path = place(name);
        let fail = |reason: String| BakeError::Input { file: file.to_owned(), place: key.clone(), reason };
        let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        let format = GuideFormat::of_extension(&extension);
        if format.is_none() && !LINE_EXTENSIONS.iter().any(|known| extension.eq_ignore_ascii_case(known)) {
            let known = GuideFormat::EXTENSIONS.map(|(extension, _)| extension);
            let known: Vec<String> = known.iter().chain(&LINE_EXTENSIONS).map(|e| format!(".{e}")).collect();
            return Err(fail(format!("{}: expected a name that ends in {}", path.display(), known.join(", "))));
        }
        let by = format!("{file}, {key}");
        let bytes = read_file_named_by(&path, &by).map_err(|error| fail(error.to_string()))?;
        let shown = path.display().to_string();
        let (strands, inputs) = match format {
            Some(format) => (format.read(&shown, &bytes)?, vec![input_record("strands", name, &bytes)]),
            None => import_strands(&shown, &bytes, &mut resolver(&path, Reach::OwnFolder, &mut |_| ()))?,
        };
        read.strands.insert(name.to_owned(), strands);
        read.inputs.extend(inputs);
    }
    io_guard::check()?;
    Ok(read)
}

/// Reads a PNG or EXR image.
///
/// Fails with [`BakeError::Io`]; [`BakeError::Input`] for a file that is neither.
pub fn read_picture(path: &Path) -> Result<Picture, BakeError> {
    let fail = |(place, reason)| BakeError::Input { file: path.display().to_string(), place, reason };
    Picture::decode(&read_file(path)?).map_err(fail)
}

/// Converts a relative URI to a path, or returns the reason why it is not accepted.
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
    let decoded = percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| "its percent-encoding is not UTF-8".to_owned())?;
    if decoded.is_empty() {
        return Err("it is empty; expected a relative path".to_owned());
    }
    if decoded.contains('\0') {
        return Err("it contains a NUL byte; expected a relative path".to_owned());
    }
    // Check for both kinds of slash, so that every operating system rejects the same models.
    if decoded.starts_with(['/', '\\']) || Path::new(&*decoded).is_absolute() {
        return Err("it is an absolute path; expected a relative one: put the file beside the model".to_owned());
    }
    Ok(PathBuf::from(&*decoded))
}

/// Writes a file atomically, replacing an existing one. A file that already has these bytes keeps its modification
/// time, so that build systems do not rebuild its dependents.
///
/// The bytes go to a temporary file in the same folder, which is then renamed, or removed on failure. A new file has
/// the permissions that the umask leaves. Symbolic links are followed; devices and pipes are written to directly.
///
/// Fails with [`BakeError::Io`], naming `path` or its folder. [`BakeError::SameFile`] for a file that a guarded command
/// has read ([`crate::io_guard`]).
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    write_atomic_with(path, |out| out.write_all(bytes))
}

/// Writes a file as [`write_atomic`] does, even if the command has read it: an edit that the user asked for.
///
/// Fails with [`BakeError::Io`], naming `path` or its folder.
pub fn rewrite_atomic(path: &Path, bytes: &[u8]) -> Result<(), BakeError> {
    write_unguarded(path, |out| out.write_all(bytes))?.map_or(Ok(()), PendingFile::commit)
}

/// Fails if a file cannot be written: its folder is missing or read-only, or it is a folder itself.
///
/// Fails with the errors of [`write_atomic`].
pub fn require_writable(path: &Path) -> Result<(), BakeError> {
    let is_device = std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    // Dropping the pending file removes it.
    if is_device { Ok(()) } else { write_temporary(path, |_| Ok(())).map(drop) }
}

/// Writes a file as [`write_atomic`] does, with the contents that `write` streams.
///
/// Fails with [`BakeError::Io`], naming `path` or its folder; also for an error of `write`.
pub fn write_atomic_with(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> io::Result<()>,
) -> Result<(), BakeError> {
    write_temporary(path, write)?.map_or(Ok(()), PendingFile::commit)
}

/// Writes several files. They appear only after all of them were written completely; if writing fails, none appears.
///
/// Fails with the errors of [`write_atomic`]. If renaming a file fails, the files before it already exist.
pub fn write_all_atomic(files: &[(&Path, &[u8])]) -> Result<(), BakeError> {
    let whole = files.iter().map(|(path, bytes)| write_temporary(path, |out| out.write_all(bytes)));
    let whole = whole.collect::<Result<Vec<_>, _>>()?;
    whole.into_iter().flatten().try_for_each(PendingFile::commit)
}

/// Complete temporary file that has not been renamed yet.
struct PendingFile {
    // Fields are dropped in the order of declaration, so the file is removed before its name is unregistered.
    file: tempfile::NamedTempFile,
    unfinished: TempFileGuard,
    target: PathBuf,
    /// Path as the caller gave it.
    named: PathBuf,
}

impl PendingFile {
    fn commit(self) -> Result<(), BakeError> {
        let Self { file, unfinished, target, named } = self;
        io_trace::record_written(&named, || digest(file.path(), u64::MAX).ok());
        if same_bytes(file.path(), &target).unwrap_or(false) {
            // Dropping the handle removes the temporary file.
            io_guard::record_written(&named);
            return Ok(());
        }
        let renamed =
            file.persist(&target).map_err(|error| io_error(&target, "rename a temporary file to", error.error));
        drop(unfinished);
        renamed.map(|_| io_guard::record_written(&named))
    }
}

/// Writes a temporary file next to the target; `None` if the target was written to directly. Fails for a target that
/// the command has read.
fn write_temporary(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> io::Result<()>,
) -> Result<Option<PendingFile>, BakeError> {
    io_guard::check_write(path)?;
    write_unguarded(path, write)
}

fn write_unguarded(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> io::Result<()>,
) -> Result<Option<PendingFile>, BakeError> {
    let write = |file: &std::fs::File| {
        let mut out = io::BufWriter::new(file);
        write(&mut out)?;
        out.flush()
    };
    // A symbolic link is kept; the file that it points to is replaced.
    let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    match std::fs::metadata(&target) {
        Ok(found) if found.is_dir() => {
            let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, expected a file name");
            return Err(io_error(path, "write", source));
        }
        // Renaming a file over /dev/null would replace the device.
        Ok(found) if !found.is_file() => {
            let open = std::fs::OpenOptions::new().write(true).open(&target);
            return match open.and_then(|f| write(&f)) {
                Ok(()) => Ok(None),
                Err(source) => Err(io_error(path, "write", source)),
            };
        }
        _ => {}
    }
    if target.file_name().is_none() {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "it has no file name");
        return Err(io_error(path, "write", source));
    }
    let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMP_FILE_AFFIXES.0).suffix(TEMP_FILE_AFFIXES.1);
    // Temporary files are private by default. Request the usual permissions, from which the umask subtracts.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let (file, unfinished) = TempFileGuard::create(|| builder.tempfile_in(folder))
        .map_err(|source| io_error(folder, "create a file in", source))?;
    let written = write(file.as_file()).and_then(|()| file.as_file().sync_all());
    written.map_err(|source| io_error(path, "write", source))?;
    Ok(Some(PendingFile { file, unfinished, target, named: path.to_owned() }))
}

/// Returns the SHA-256 of the first `most` bytes of a file.
///
/// Fails with the operating system's error if the file cannot be read.
pub fn digest(path: &Path, most: u64) -> io::Result<io_trace::Digest> {
    let mut hash = Sha256::new();
    io::copy(&mut std::fs::File::open(path)?.take(most), &mut hash)?;
    Ok(hash.finalize().into())
}

/// Whether two files have the same contents.
fn same_bytes(a: &Path, b: &Path) -> io::Result<bool> {
    let (mut a, mut b) = (std::fs::File::open(a)?, std::fs::File::open(b)?);
    let length = a.metadata()?.len();
    if length != b.metadata()?.len() {
        return Ok(false);
    }
    let (mut here, mut there) = (vec![0; 1 << 16], vec![0; 1 << 16]);
    let mut left = length;
    while left > 0 {
        let part = left.min(here.len() as u64) as usize;
        a.read_exact(&mut here[..part])?;
        b.read_exact(&mut there[..part])?;
        if here[..part] != there[..part] {
            return Ok(false);
        }
        left -= part as u64;
    }
    Ok(true)
}
