//! `pelage unpack`: converts a package to a folder of files for other tools.

use super::exit::{Exit, Failure};
use super::output::{Output, require_parent};
use super::package_file;
use super::unpacked::{self, File};
use pelage_bake::io_guard;
use pelage_bake::temp_files::{TEMP_FILE_AFFIXES, TempFileGuard};
use pelage_import::BakeError;
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

/// Unpack a package: manifest as JSON, textures as .ktx2, mesh as .glb, strands as .hair; `pelage pack` is the inverse
///
/// Hair guides are in hair_0_NAME.hair, at their positions on the mesh at rest. The strands of the tile are in
/// strands.hair, as on a flat surface. Units are metres, y up. Data that such files cannot hold are in hair.json and
/// strands.json beside them.
#[derive(Debug, clap::Args)]
pub struct UnpackArgs {
    /// Package to unpack
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// Folder to write; created if missing, replaced if it contains only an unpacked package
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Write into a folder that contains other files, overwriting files of the same names
    #[arg(long)]
    force: bool,
}

/// Files that were written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnpackResult {
    output: String,
    files: Vec<UnpackedFile>,
}

/// A file of an unpacked package.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct UnpackedFile {
    name: String,
    bytes: usize,
}

/// Runs the subcommand.
pub fn run(args: &UnpackArgs, output: &mut Output) -> Result<Exit, Failure> {
    let input = package_file::read(&args.package)?;
    let package = input.open()?;
    let files = unpacked::unpack(&input.name, &package)?;
    write_folder(&args.folder, &files, args.force)?;
    let mut text = String::new();
    for (name, bytes) in &files {
        let _ = writeln!(text, "{} ({} bytes)", args.folder.join(name).display(), bytes.len());
    }
    let files = files.into_iter().map(|(name, bytes)| UnpackedFile { name, bytes: bytes.len() }).collect();
    output.result(&text, &UnpackResult { output: args.folder.display().to_string(), files })?;
    Ok(Exit::Done)
}

fn fail(path: &Path, action: &'static str) -> impl FnOnce(io::Error) -> Failure {
    move |source| BakeError::Io { path: path.to_owned(), action, source }.into()
}

/// Writes all files or none. They are written into a temporary folder beside the target, which is then renamed.
fn write_folder(folder: &Path, files: &[File], force: bool) -> Result<(), Failure> {
    let target = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let exists = target.exists();
    if exists && !target.is_dir() {
        let source = io::Error::new(io::ErrorKind::NotADirectory, "found a file, expected a folder");
        return Err(fail(folder, "write into")(source));
    }
    let replaceable = !exists || is_replaceable(&target).map_err(fail(folder, "read"))?;
    if !replaceable && !force {
        let text = "it has files that `unpack` did not write; name another folder, or use --force to write among them";
        return Err(fail(folder, "replace")(io::Error::new(io::ErrorKind::DirectoryNotEmpty, text)));
    }
    require_parent(&target)?;
    let replaced = std::fs::read_dir(&target).into_iter().flatten().flatten().map(|entry| entry.path());
    let replaced = replaced.filter(|_| replaceable).chain(files.iter().map(|(name, _)| target.join(name)));
    replaced.into_iter().try_for_each(|path| io_guard::check_write(&path))?;
    let parent = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(TEMP_FILE_AFFIXES.0).suffix(TEMP_FILE_AFFIXES.1);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    // The temporary folder is removed with its remaining contents when this function returns.
    // The guard protects only against interruption while files are written. Afterwards the folder may briefly hold the
    // old contents.
    let (work, unfinished) =
        TempFileGuard::create(|| builder.tempdir_in(parent)).map_err(fail(parent, "create a folder in"))?;
    let fresh = work.path().join("new");
    std::fs::create_dir(&fresh).map_err(fail(&fresh, "create"))?;
    for (name, bytes) in files {
        let path = fresh.join(name);
        std::fs::write(&path, bytes).map_err(fail(&path, "write"))?;
    }
    drop(unfinished);
    if !exists {
        return std::fs::rename(&fresh, &target).map_err(fail(folder, "rename a temporary folder to"));
    }
    if replaceable {
        let old = work.path().join("old");
        std::fs::rename(&target, &old).map_err(fail(folder, "replace"))?;
        return std::fs::rename(&fresh, &target).map_err(|error| {
            // Only the first error is reported, so the result of moving the old folder back is ignored.
            let _ = std::fs::rename(&old, &target);
            fail(folder, "replace")(error)
        });
    }
    for (name, _) in files {
        let path = target.join(name);
        std::fs::rename(fresh.join(name), &path).map_err(fail(&path, "replace"))?;
    }
    Ok(())
}

/// Returns true if the folder is empty, or contains only a manifest of `unpack` and files named in that manifest.
fn is_replaceable(folder: &Path) -> io::Result<bool> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        names.push(entry?.file_name());
    }
    if names.is_empty() {
        return Ok(true);
    }
    let Ok(text) = std::fs::read(folder.join(unpacked::MANIFEST)) else { return Ok(false) };
    let document: Value = serde_json::from_slice(&text).unwrap_or_default();
    let known = unpacked::files_of(&document);
    Ok(!known.is_empty() && names.iter().all(|n| n.to_str().is_some_and(|n| known.iter().any(|k| k == n))))
}
