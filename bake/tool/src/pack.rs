//! `pelage pack`: converts an unpacked folder back to a package.

use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::output::{Output, require_parent};
use super::unpacked;
use pelage_bake::io::{read_named_file, write_atomic};
use pelage_bake::io_trace;
use pelage_bake::recipe::Recipe;
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use serde::Serialize;
use serde_json::Value;
use std::io;
use std::path::PathBuf;

/// Pack an unpacked folder; without edits the package is identical to the one unpacked, byte for byte
///
/// Mesh data come from mesh.glb, skeleton and clips from animation.json, strands and guides from the .hair files, whose
/// numbers of strands and points must not change. recipe.toml only records how the fur was made: an edit that describes
/// different fur than the folder holds is refused.
#[derive(Debug, clap::Args)]
pub struct PackArgs {
    /// Folder written by `pelage unpack`
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Package to write
    #[arg(value_name = "PKG")]
    package: OutputFile,
}

/// Package that was written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PackResult {
    output: String,
    bytes: usize,
}

/// Runs the subcommand.
pub fn run(args: &PackArgs, output: &mut Output) -> Result<Exit, Failure> {
    require_parent(&args.package)?;
    if !args.folder.is_dir() {
        let (kind, text) = if args.folder.exists() {
            (io::ErrorKind::NotADirectory, "found a file, expected a folder written by `pelage unpack`")
        } else {
            (io::ErrorKind::NotFound, "no such folder")
        };
        let source = io::Error::new(kind, text);
        return Err(BakeError::Io { path: args.folder.clone(), action: "read", source }.into());
    }
    let folder = args.folder.display().to_string();
    let bytes = unpacked::pack(&folder, &mut |name| {
        let path = args.folder.join(name);
        if !io_trace::exists(&path) {
            return Ok(None);
        }
        read_named_file(&path).map(Some)
    })?;
    report_leftovers(args, &bytes, output);
    write_atomic(&args.package, &bytes)?;
    let result = PackResult { output: args.package.display().to_string(), bytes: bytes.len() };
    output.result(&format!("{} ({} bytes)\n", result.output, result.bytes), &result)?;
    Ok(Exit::Done)
}

/// Prints notes about edits without effect: unused files, and an unreadable recipe.
fn report_leftovers(args: &PackArgs, bytes: &[u8], output: &Output) {
    let document: Value = std::fs::read(args.folder.join(unpacked::MANIFEST))
        .ok()
        .and_then(|text| serde_json::from_slice(&text).ok())
        .unwrap_or_default();
    let known = unpacked::files_of(&document);
    let entries = std::fs::read_dir(&args.folder).into_iter().flatten().flatten();
    let mut unused: Vec<_> =
        entries.map(|e| e.file_name().to_string_lossy().into_owned()).filter(|name| !known.contains(name)).collect();
    unused.sort();
    for name in unused {
        output.note(&format!(
            "note: {}: not packed, because {} does not name it",
            args.folder.join(name).display(),
            unpacked::MANIFEST
        ));
    }
    if let Ok(package) = Package::open(bytes, &Limits::default())
        && let Err(e) = Recipe::parse_recorded("recipe.toml", &package.manifest().recipe)
    {
        output.note(&format!("note: {e}"));
    }
}
