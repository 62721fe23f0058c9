//! `pelage view`: opens a window that shows a package, a model as it is baked, or a scene.

mod baking;
mod judge;
mod recipe_file;
mod recipe_knobs;
mod workshop;

use super::bake::RecipeArgs;
use super::environment::lights_of;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::look_args::{LookArgs, SamplesArgs};
use super::output::{Output, require_parent};
use super::seal;
use super::view_args::{ALL_OPTIONS, COMMON_OPTIONS};
use pelage_import::BakeError;
use pelage_stage::{Look, Size};
use pelage_viewer::{ViewError, ViewOptions};
use serde_json::json;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;
use workshop::Studio;

/// View a package, a model or a scene in a window, with controls for every knob
///
/// A model is baked in the background, and again when it, its images or its recipe change on disk. The previous picture
/// stays until the new one is ready. Errors in a file are shown in the window until they are fixed. H lists the keys.
///
/// Camera, time, clip and copies are chosen in the window, so there are no options for them; pictures and sequences are
/// saved from there.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = ALL_OPTIONS, after_long_help = COMMON_OPTIONS)]
pub struct WindowArgs {
    /// Package, model (.glb, .gltf, .obj) or scene (.toml); by default the window waits for a file to be dropped
    #[arg(value_name = "PKG|MODEL|SCENE")]
    input: Option<PathBuf>,
    #[command(flatten)]
    recipe: RecipeArgs,
    #[command(flatten)]
    samples: SamplesArgs,
    #[command(flatten)]
    look: LookArgs,
    /// Width and height of the window, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    window: Size,
    /// Folder for saved pictures, looks and sequences
    #[arg(long, value_name = "DIR", default_value = ".")]
    save_to: PathBuf,
    /// Start without panels; the key N shows them
    #[arg(long)]
    no_panels: bool,
    /// Write events to this file, one line of JSON each, for scripts: adapter, made, first picture, picture, empty
    /// picture, failure, mended, saved, measured, truth
    #[arg(long, value_name = "FILE")]
    events: Option<OutputFile>,
}

/// Runs the subcommand; returns when the window is closed.
pub fn run(args: &WindowArgs, output: &mut Output) -> Result<Exit, Failure> {
    let began = Instant::now();
    let mut look = Look::of_picture();
    args.look.apply(&mut look)?;
    args.samples.apply(&mut look)?;
    look.read_environment(&mut lights_of).map_err(|reason| Failure::Usage(format!("--environment: {reason}")))?;
    seal::read_of(&mut look)?;
    if !args.save_to.is_dir() {
        return Err(Failure::Usage(format!("--save-to {}: there is no such folder", args.save_to.display())));
    }
    let events = match &args.events {
        Some(path) => {
            require_parent(path)?;
            let fail = |source| BakeError::Io { path: path.to_path_buf(), action: "write", source };
            Some(Box::new(File::create(path).map_err(fail)?) as Box<dyn Write + Send>)
        }
        None => None,
    };
    let studio = Studio::new(args.recipe.clone());
    if let Some(input) = &args.input {
        // A missing or invalid input path is an error of the command. Errors in the file's contents are shown in the
        // window.
        studio.kind_of(input)?;
    }
    let options = ViewOptions {
        open: args.input.clone(),
        look,
        size: (args.window.width, args.window.height),
        folder: args.save_to.clone(),
        panels: !args.no_panels,
        lights_of,
        seal_of: seal::read_text,
        events,
        began,
    };
    pelage_viewer::view(options, Box::new(studio)).map_err(|error| match error {
        ViewError::Stage(error) => Failure::from(error),
        other => Failure::NoWindow(other.to_string()),
    })?;
    output.result("closed", &json!({ "closed": true }))?;
    Ok(Exit::Done)
}
