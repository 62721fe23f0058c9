//! `pelage merge`: combines the parts of a picture that were traced on several machines.

use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::output::{Output, require_parent};
use super::reference::{Format, exr, png};
use pelage_bake::io;
use pelage_import::BakeError;
use pelage_truth::TracedPart;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Combine the parts of a reference image traced by `pelage reference --part K/N`; the result has the same bytes as the
/// image traced in one piece
#[derive(Clone, Debug, clap::Args)]
pub struct MergeArgs {
    /// All parts of one picture, in any order
    #[arg(value_name = "PART", required = true)]
    parts: Vec<PathBuf>,
    /// Picture to write: .png as `reference` writes it, or .exr with linear colours times alpha
    #[arg(long, short, value_name = "PNG|EXR")]
    output: OutputFile,
}

/// Picture combined from its parts.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MergeResult {
    output: String,
    width: u32,
    height: u32,
    spp: u32,
    parts: usize,
    /// Number of camera rays, over all parts.
    primary_rays: u64,
    /// Number of shadow rays, over all parts.
    shadow_rays: u64,
    /// Number of pixels with nonzero opacity.
    covered_pixels: usize,
}

impl MergeArgs {
    /// Returns the description of the merge for the cache.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: Job::name(&self.output), ..self.clone() };
        Some(Job::new("merge", &args, &[&self.output]))
    }
}

fn input(file: &Path, place: &str, reason: String) -> BakeError {
    BakeError::Input { file: file.display().to_string(), place: place.to_owned(), reason }
}

fn read(path: &Path) -> Result<TracedPart, BakeError> {
    TracedPart::decode(&io::read_file(path)?).map_err(|(place, reason)| input(path, &place, reason))
}

/// Runs the subcommand.
pub fn run(args: &MergeArgs, output: &mut Output) -> Result<Exit, Failure> {
    let format = Format::of(&args.output)?;
    require_parent(&args.output)?;
    output.progress("merging the parts");
    let mut whole: Option<TracedPart> = None;
    let mut files: Vec<Option<&Path>> = Vec::new();
    for path in &args.parts {
        let part = read(path)?;
        files.resize(part.of.parts as usize, None);
        if let Some(before) = files[part.of.part as usize].replace(path) {
            let (number, of) = (part.of.part + 1, part.of.parts);
            let reason = format!("is part {number} of {of}, the same as {}; expected each part once", before.display());
            return Err(input(path, "line 2", reason).into());
        }
        match &mut whole {
            Some(whole) => whole.add(&part).map_err(|reason| input(path, "line 2", reason))?,
            None => whole = Some(part),
        }
    }
    let missing: Vec<String> =
        files.iter().enumerate().filter(|(_, file)| file.is_none()).map(|(i, _)| (i + 1).to_string()).collect();
    let Some(whole) = whole.filter(|_| missing.is_empty()) else {
        let text = format!("parts {} of {} are missing, expected all", missing.join(", "), files.len());
        return Err(Failure::Usage(text));
    };
    let bytes = match format {
        Format::Exr if whole.of.background => {
            let text = "has a background, but an .exr stores transparency; expected -o with a name that ends in .png";
            return Err(input(&args.parts[0], "line 2", text.into()).into());
        }
        Format::Exr => exr(&whole.traced)?,
        _ => png(&whole.shown)?,
    };
    io::write_atomic(&args.output, &bytes)?;
    let result = MergeResult {
        output: args.output.display().to_string(),
        width: whole.of.width,
        height: whole.of.height,
        spp: whole.of.spp,
        parts: files.len(),
        primary_rays: whole.traced.rays.primary,
        shadow_rays: whole.traced.rays.shadow,
        covered_pixels: whole.traced.covered(),
    };
    output.result(&result.output, &result)?;
    Ok(Exit::Done)
}
