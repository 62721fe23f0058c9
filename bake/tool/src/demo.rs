//! `pelage demo`: bakes and draws the built-in models without any input files.

use super::bake::StageWatch;
use super::built_in::{BuiltIn, HARE, TORUS};
use super::exit::{Exit, Failure};
use super::output::{Output, make_folder};
use super::picture_series;
use super::stages::stage_of;
use super::view::PictureView;
use pelage_bake::io;
use pelage_bake::pipeline::{self, BakeInput, Baked};
use pelage_bake::stages::groom::MapImages;
use pelage_stage::{Background, Gpu, LookStyle, NamedPackage, Samples, find_clip};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Bake and draw the built-in hare and torus; needs no input
#[derive(Clone, Debug, clap::Args)]
pub struct DemoArgs {
    /// Folder for packages and pictures; created if missing
    #[arg(long, short, value_name = "DIR", default_value = "pelage-demo")]
    output: PathBuf,
}

/// Packages and pictures written.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DemoResult {
    packages: Vec<String>,
    pictures: Vec<String>,
}

/// Models to bake. Each may have a clip and a time in seconds, which is drawn in addition to the rest pose.
const MODELS: [(BuiltIn, Option<(&str, f32)>); 2] = [(HARE, Some(("EarBreath", 0.5))), (TORUS, None)];

/// Clip of the hare that is drawn in ink, and the number of pictures in one loop.
const GAIT: (&str, u32) = ("Walk", 16);

/// Runs the subcommand.
pub fn run(args: &DemoArgs, output: &mut Output) -> Result<Exit, Failure> {
    // Opened first, so that nothing is written on a machine without a usable adapter.
    let gpu = Gpu::open()?;
    make_folder(&args.output)?;
    let (mut packages, mut pictures) = (Vec::new(), Vec::new());
    for (model, moment) in &MODELS {
        let baked = bake(model, output)?;
        let path = args.output.join(format!("{}.pelage", model.name));
        io::write_atomic(&path, &baked.package)?;
        packages.push(path.display().to_string());
        let file = NamedPackage { name: path.display().to_string(), bytes: baked.package.into() };
        for (suffix, view) in views(*moment) {
            let path = args.output.join(format!("{}{suffix}.png", model.name));
            output.progress("drawing");
            picture_series::draw(&mut stage_of(&file, &view, || Ok(gpu.clone()))?, &path)?;
            pictures.push(path.display().to_string());
        }
        if moment.is_some() {
            pictures.extend(gait(&file, &gpu, &args.output.join(format!("{}_walk", model.name)), output)?);
        }
    }
    let result = DemoResult { packages, pictures };
    output.result(&[&*result.packages, &*result.pictures].concat().join("\n"), &result)?;
    Ok(Exit::Done)
}

fn bake(model: &BuiltIn, output: &mut Output) -> Result<Baked, Failure> {
    let recipe = model.recipe()?;
    let mut watch = StageWatch::new(output);
    watch.begin("import");
    let imported = model.import(&recipe)?;
    let (file, images, steps) = (model.file(), MapImages::default(), watch.steps());
    let told = BakeInput { progress: &steps, ..BakeInput::new(&file, model.name, &recipe, &images) };
    let baked = pipeline::bake(&told, &imported, &mut |event| watch.on_event(event))?;
    watch.finish();
    Ok(baked)
}

/// Draws a clip in ink as numbered pictures in `folder`, which is created; returns their names.
fn gait(file: &NamedPackage<'_>, gpu: &Gpu, folder: &Path, output: &mut Output) -> Result<Vec<String>, Failure> {
    let (clip, count) = GAIT;
    let package = file.open()?;
    let Some((_, seconds)) = find_clip(file, &package, Some(clip))? else { return Ok(Vec::new()) };
    make_folder(folder)?;
    let view = PictureView { clip: Some(clip.into()), ..PictureView::sized((640, 480)) };
    let view = view.with(|look| look.picture.style = LookStyle::Ink);
    let mut scene = stage_of(file, &view, || Ok(gpu.clone()))?;
    let mut pictures = Vec::new();
    for number in 0..count {
        output.progress(&format!("drawing the walk, {} of {count}", number + 1));
        scene.set_time(seconds * number as f32 / count as f32);
        let path = folder.join(format!("{number:04}.png"));
        picture_series::draw(&mut scene, &path)?;
        pictures.push(path.display().to_string());
    }
    Ok(pictures)
}

/// Returns the named views of a model: in ink, with fur, without fur, and in motion if `moment` names a clip and time.
fn views(moment: Option<(&str, f32)>) -> Vec<(&'static str, PictureView)> {
    let furry = PictureView::sized((834, 834)).with(|look| {
        look.picture.samples = Samples(4);
        look.picture.background = Some(Background::Studio);
    });
    let bare = furry.clone().with(|look| look.picture.style = LookStyle::Bare);
    let inked = furry.clone().with(|look| {
        look.picture.style = LookStyle::Ink;
        look.picture.background = None;
    });
    let mut views = vec![("", furry.clone()), ("_bare", bare), ("_ink", inked)];
    if let Some((clip, time_s)) = moment {
        views.push(("_moving", PictureView { clip: Some(clip.into()), time_s, ..furry }));
    }
    views
}
