//! `pelage validate`: lists all faults of a package with their locations.

use super::exit::{Exit, Failure};
use super::output::Output;
use super::package_file;
use pelage_bake::recipe::Recipe;
use pelage_bake::recipe_mismatch::mismatches;
use pelage_formats::{FormatError, Limits, MAGIC, Package, Tag};
use pelage_stage::NamedPackage;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Check a package and list each fault with its section and byte offset
///
/// For each fault, reports whether the runtime refuses to draw the package because of it. Exits with 0 for a valid
/// package, 7 if faults were found, and 3 if the file is not a package or has a newer version.
#[derive(Debug, clap::Args)]
pub struct ValidateArgs {
    /// Package to check
    #[arg(value_name = "PKG")]
    package: PathBuf,
}

/// All faults of a package. The exit code is 0 without faults, else 7.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ValidateResult<'a> {
    package: &'a str,
    bytes: usize,
    valid: bool,
    faults: Vec<Fault>,
}

/// A fault of a package.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Fault {
    /// Tag of the section, or `head` for the header and the section table.
    section: String,
    /// Byte offset in the package; null if the fault has no location.
    offset: Option<u64>,
    message: String,
    /// Whether the runtime refuses to draw the package because of the fault.
    stops_drawing: bool,
}

/// Runs the subcommand.
pub fn run(args: &ValidateArgs, output: &mut Output) -> Result<Exit, Failure> {
    let file = package_file::read(&args.package)?;
    output.progress("checking");
    let faults = find(&file)?;
    let mut text = String::new();
    for fault in &faults {
        let place = fault.offset.map_or("no byte".to_owned(), |o| format!("byte {o}"));
        let word = if fault.stops_drawing { "" } else { " (does not stop drawing: no picture depends on it)" };
        let _ = writeln!(text, "{}: section {}, {place}: {}{word}", file.name, fault.section, fault.message);
    }
    let _ = match faults.len() {
        0 => writeln!(text, "{}: valid, {} bytes", file.name, file.bytes.len()),
        1 => writeln!(text, "{}: 1 fault", file.name),
        n => writeln!(text, "{}: {n} faults", file.name),
    };
    let valid = faults.is_empty();
    output.result(&text, &ValidateResult { package: &file.name, bytes: file.bytes.len(), valid, faults })?;
    Ok(if valid { Exit::Done } else { Exit::Differences })
}

fn find(file: &NamedPackage<'_>) -> Result<Vec<Fault>, Failure> {
    let limits = Limits::default();
    let package = match Package::open(&file.bytes, &limits) {
        Ok(package) => package,
        // The file is not a package, or this version cannot validate it.
        Err(e @ (FormatError::Magic { .. } | FormatError::Version { .. })) => return Err(file.fault(e).into()),
        Err(e) if file.bytes.len() < MAGIC.len() => return Err(file.fault(e).into()),
        Err(e) => return Ok(vec![fault(&e, None, true)]),
    };
    let drawing = package.drawing_faults();
    let mut found = Package::validate(&file.bytes, &limits);
    // Some faults are allowed by the format, but prevent drawing.
    found.extend(drawing.iter().filter(|e| !found.contains(e)).cloned().collect::<Vec<_>>());
    let mut faults: Vec<_> = found.iter().map(|e| fault(e, Some(&package), drawing.contains(e))).collect();
    let recipe = &package.manifest().recipe;
    let broken = Recipe::parse_recorded("recipe", recipe).err().map(|e| e.to_string());
    let others = mismatches(package.manifest(), recipe);
    for message in broken.into_iter().chain(others.iter().map(|d| format!("recipe: {}: {}", d.key, d.reason))) {
        let offset = package.sections().first().map(|s| s.offset);
        faults.push(Fault { section: Tag::MANIFEST.to_string(), offset, message, stops_drawing: false });
    }
    Ok(faults)
}

fn fault(error: &FormatError, package: Option<&Package<'_>>, stops_drawing: bool) -> Fault {
    let offset = error.offset();
    let holds = |at: u64| {
        let sections = package.map(Package::sections).unwrap_or_default();
        sections.iter().find(|s| (s.offset..s.offset + s.length).contains(&at)).map(|s| s.tag)
    };
    // Errors of the container have no tag. The tag is then that of the section containing the byte, or `head` outside
    // all sections.
    let tag = error.section().or_else(|| offset.and_then(holds)).unwrap_or(Tag::HEAD);
    Fault { section: tag.to_string(), offset, message: error.to_string(), stops_drawing }
}
