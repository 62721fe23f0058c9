//! The only module of the library that touches files.

use crate::picture::Picture;
use crate::recipe::Recipe;
use crate::stages::groom::MapImages;
use crate::stages::import::{ImportOptions, import, import_strands, input_record};
use crate::traffic;
use crate::unfinished::Unfinished;
use pelage_import::BakeError;
use pelage_import::guides::read::GuideFormat;
use pelage_import::image_file::{MAX_TEXELS, decode_image};
use pelage_import::mesh::Model;
use sha2::{Digest as _, Sha256};
use std::fs::FileType;
use std::io::{self, Read as _, Write as _};
use std::path::{Component, Path, PathBuf};

fn io_error(path: &Path, action: &'static str, source: io::Error) -> BakeError {
    BakeError::Io { path: path.to_owned(), action, source }
}

/// The largest file that is read, bytes. Packages and models that people make are far below; what is larger would not fit into memory beside what is
/// made of it.
pub const MAX_FILE_BYTES: u64 = 2 << 30;

/// Reads a whole file that the user named. It may be a pipe, which ends when its writer says so.
///
/// # Errors
///
/// [`BakeError::Io`], also for a folder, a device, and what is larger than [`MAX_FILE_BYTES`].
pub fn read_file(path: &Path) -> Result<Vec<u8>, BakeError> {
    whole(path, |kind| kind.is_file() || is_pipe(kind))
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

/// Reads a whole file that another file names. Only regular files are read: a pipe might never end, and never begin.
///
/// # Errors
///
/// As [`read_file`], also for a pipe.
pub fn read_named_file(path: &Path) -> Result<Vec<u8>, BakeError> {
    whole(path, FileType::is_file)
}

fn whole(path: &Path, may_be: fn(&FileType) -> bool) -> Result<Vec<u8>, BakeError> {
    let bytes = start(path, MAX_FILE_BYTES + 1, may_be)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let text = format!("it is larger than the {MAX_FILE_BYTES} bytes that are read of a file");
        return Err(io_error(path, "read", io::Error::new(io::ErrorKind::FileTooLarge, text)));
    }
    Ok(bytes)
}

/// Reads the first `most` bytes of a file.
fn start(path: &Path, most: u64, may_be: fn(&FileType) -> bool) -> Result<Vec<u8>, BakeError> {
    let fail = |source| io_error(path, "read", source);
    // Asked by name before it is opened: opening a pipe waits for its writer.
    let found = std::fs::metadata(path).map_err(fail)?;
    if !may_be(&found.file_type()) {
        // Systems differ in what reading a folder says, from a clear word to "permission denied".
        let kind = if found.is_dir() { io::ErrorKind::IsADirectory } else { io::ErrorKind::InvalidInput };
        let text = format!("it is {}, expected a file", kind_of(&found.file_type()));
        return Err(fail(io::Error::new(kind, text)));
    }
    // What the system says of the length is a hint: files under /proc say 0, and any file may grow meanwhile.
    let mut bytes = Vec::with_capacity(found.len().min(most) as usize);
    std::fs::File::open(path).and_then(|file| file.take(most).read_to_end(&mut bytes)).map_err(fail)?;
    traffic::read(path, most, Some(&bytes));
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

/// What is no regular file, in words.
fn kind_of(kind: &FileType) -> &'static str {
    if kind.is_dir() {
        "a folder"
    } else if is_pipe(kind) {
        "a pipe"
    } else {
        "a device or a socket"
    }
}

/// Which files a model may name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// Those in its own folder and below it, wherever links lead. This is what a program wants that bakes models of people it does not know.
    #[default]
    OwnFolder,
    /// Any file that can be read: `../textures/fox.png`.
    Anywhere,
}

/// Reads a model and the files that it names, which it looks for from its own folder. All of them are regular files; of a buffer no more is read
/// than the model declares.
///
/// # Errors
///
/// [`BakeError::Io`] where the model itself cannot be read, else as [`import`]; a buffer or image that is missing, or out of `reach`, is an error in
/// the model, at the place that names it.
pub fn read_model(path: &Path, options: &ImportOptions, reach: Reach) -> Result<Model, BakeError> {
    read_model_noting(path, options, reach, &mut |_| ())
}

/// As [`read_model`]; `named` is called with the path of each file that the model names and that is in `reach`, before it is read.
///
/// # Errors
///
/// As [`read_model`].
pub fn read_model_noting(
    path: &Path,
    options: &ImportOptions,
    reach: Reach,
    named: &mut dyn FnMut(&Path),
) -> Result<Model, BakeError> {
    let bytes = read_file(path)?;
    let mut resolve = beside(path, reach, named);
    import(&path.display().to_string(), &bytes, &mut resolve, options)
}

/// What reads the files that a model names.
fn beside<'a>(
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
                "it leads out of the model's folder; expected a file in that folder or below it: move it there, or, if you trust the model, \
                 give --allow-outside"
                    .to_owned(),
            ));
        }
        let path = folder.join(relative);
        named(&path);
        start(&path, most, FileType::is_file)
    }
}

/// Extensions of models whose lines are read as strands.
const OF_LINES: [&str; 2] = ["glb", "gltf"];

/// Whether `folder` joined with `relative` names a file in `folder` or below it, by its words and, where it is there, by where links lead. A path that
/// leads out by its words is outside also where nothing is there: the answer must not tell which files a machine has.
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
        // Nothing is there to be read.
        _ => true,
    }
}

/// Reads the images and the files of strands that a recipe names.
///
/// * `file`: the recipe as the user named it, for messages
/// * `place`: where the image of a name is
///
/// # Errors
///
/// [`BakeError::Input`] in the recipe, naming key and image, where one cannot be read or decoded.
pub fn read_map_images(file: &str, place: &dyn Fn(&str) -> PathBuf, recipe: &Recipe) -> Result<MapImages, BakeError> {
    let mut read = MapImages::default();
    let mut texels_left = MAX_TEXELS;
    for (key, name) in recipe.images() {
        let path = place(name);
        let fail = |reason: String| BakeError::Input { file: file.to_owned(), place: key.clone(), reason };
        let bytes = read_named_file(&path).map_err(|error| fail(error.to_string()))?;
        let image = decode_image(&bytes, texels_left).map_err(|reason| fail(format!("{} {reason}", path.display())))?;
        texels_left -= u64::from(image.width) * u64::from(image.height);
        read.inputs.push(input_record("image", name, &bytes));
        read.images.insert(name.to_owned(), image);
    }
    for (key, name) in recipe.strand_files() {
        let path = place(name);
        let fail = |reason: String| BakeError::Input { file: file.to_owned(), place: key.clone(), reason };
        let extension = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        let format = GuideFormat::of_extension(&extension);
        if format.is_none() && !OF_LINES.iter().any(|known| extension.eq_ignore_ascii_case(known)) {
            let known = GuideFormat::EXTENSIONS.map(|(extension, _)| extension);
            let known: Vec<String> = known.iter().chain(&OF_LINES).map(|e| format!(".{e}")).collect();
            return Err(fail(format!("{}: expected a name that ends in {}", path.display(), known.join(", "))));
        }
        let bytes = read_named_file(&path).map_err(|error| fail(error.to_string()))?;
        let shown = path.display().to_string();
        let (strands, inputs) = match format {
            Some(format) => (format.read(&shown, &bytes)?, vec![input_record("strands", name, &bytes)]),
            None => import_strands(&shown, &bytes, &mut beside(&path, Reach::OwnFolder, &mut |_| ()))?,
        };
        read.strands.insert(name.to_owned(), strands);
        read.inputs.extend(inputs);
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
    let decoded = percent_encoding::percent_decode_str(uri)
        .decode_utf8()
        .map_err(|_| "its percent-encoding is no UTF-8".to_owned())?;
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

/// Writes `bytes` to a file that appears, or replaces an older one, only when it is whole. An older one that has the same bytes stays, and keeps its time:
/// then build systems make nothing of it anew.
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
    prepare(path, write)?.map_or(Ok(()), Prepared::appear)
}

/// Writes several files, which appear only when all of them are whole: an error before that leaves none of them.
///
/// # Errors
///
/// As [`write_atomic`]. Where the system refuses to rename one that is whole, those before it stand already.
pub fn write_all_atomic(files: &[(&Path, &[u8])]) -> Result<(), BakeError> {
    let whole = files.iter().map(|(path, bytes)| prepare(path, |out| out.write_all(bytes)));
    let whole = whole.collect::<Result<Vec<_>, _>>()?;
    whole.into_iter().flatten().try_for_each(Prepared::appear)
}

/// How the name of a file begins and ends while it is written.
pub const TEMPORARY: (&str, &str) = (".pelage-", ".tmp");

/// A file that is whole, and has yet to get its name.
struct Prepared {
    // Dropped in this order: a name is forgotten when its file is gone.
    file: tempfile::NamedTempFile,
    unfinished: Unfinished,
    target: PathBuf,
    /// As the caller named it.
    named: PathBuf,
}

impl Prepared {
    fn appear(self) -> Result<(), BakeError> {
        let Self { file, unfinished, target, named } = self;
        traffic::written(&named, || digest(file.path(), u64::MAX).ok());
        if same_bytes(file.path(), &target).unwrap_or(false) {
            // The temporary file goes with its handle.
            return Ok(());
        }
        let renamed =
            file.persist(&target).map_err(|error| io_error(&target, "rename a temporary file to", error.error));
        drop(unfinished);
        renamed.map(drop)
    }
}

/// Writes a file under a temporary name beside its own; `None` for what is written to directly.
fn prepare(
    path: &Path,
    write: impl FnOnce(&mut dyn std::io::Write) -> io::Result<()>,
) -> Result<Option<Prepared>, BakeError> {
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
    builder.prefix(TEMPORARY.0).suffix(TEMPORARY.1);
    // Temporary files are private by default; the umask takes away from this what the user wants taken away.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder).map_err(|source| io_error(folder, "create a file in", source))?;
    let unfinished = Unfinished::new(file.path());
    let written = write(file.as_file()).and_then(|()| file.as_file().sync_all());
    written.map_err(|source| io_error(path, "write", source))?;
    Ok(Some(Prepared { file, unfinished, target, named: path.to_owned() }))
}

/// SHA-256 of the first `most` bytes of a file.
///
/// # Errors
///
/// What the system says where it cannot be read.
pub fn digest(path: &Path, most: u64) -> io::Result<traffic::Digest> {
    let mut hash = Sha256::new();
    io::copy(&mut std::fs::File::open(path)?.take(most), &mut hash)?;
    Ok(hash.finalize().into())
}

/// Whether two files hold the same bytes.
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
