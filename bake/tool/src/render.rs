//! `pelage render`: draws a package or a scene into one picture, or a sequence of pictures.

use super::empty_picture::why_empty;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::{ADAPTER, Job};
use super::journal::Key;
use super::look_args::SamplesArgs;
use super::output::Output;
use super::package_file;
use super::picture_series::{PassRun, Picture, PictureSeries};
use super::scene::{Scene, is_scene};
use super::sequence::{DrawnPictures, Sink};
use super::stages::{self, FurDetail, crowd};
use super::view::PictureView;
use super::view_args::{ALL_OPTIONS, COMMON_OPTIONS, Frames, SEQUENCES, ViewArgs};
use pelage_bake::io_trace;
use pelage_bake::strands::PosedMesh;
use pelage_formats::{MAGIC, Package};
use pelage_import::BakeError;
use pelage_stage::{Actor, Cast, Gpu, Look, LookLines, LookStyle, NamedPackage, StageError};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Draw a package or a scene into a PNG, or over time into numbered PNGs or a video
///
/// A scene file (.toml) places several packages, gives them clips and paths, and moves the camera; its table `look` has
/// the keys of a look file. assets/scenes has one with comments. Arguments override the scene file. Its `sequence`
/// applies to numbered pictures and videos; a plain file name is one picture, at --time.
///
/// Interrupted numbered pictures resume where they stopped: a journal, OUTPUT.pictures.jsonl, is stored beside them
/// until the last is drawn. A picture is redrawn if it is missing or changed, or if packages, scene, arguments, tool or
/// adapter differ.
///
/// A video is Y4M: 4:4:4, BT.709, limited range. The format does not store the matrix, so specify it to the reader:
/// pelage render fox.pelage --clip Walk --frames 96 -o - | ffmpeg -i - -vf
/// setparams=colorspace=bt709:color_primaries=bt709 walk.mp4
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = ALL_OPTIONS, after_long_help = COMMON_OPTIONS)]
pub struct RenderArgs {
    /// Package, or a scene file that ends in .toml
    #[arg(value_name = "PKG|SCENE")]
    input: PathBuf,
    /// Picture or video to write; - is a video on stdout
    ///
    /// A name that ends in .svg gets the strokes of an ink painting as curves, in groups of washes, lines and fur.
    ///
    /// With --frames, %04d is replaced by the picture's number, from 0. If the name ends in .y4m, a video is written;
    /// with -, it goes to stdout. Transparent pixels are white in a video.
    #[arg(long, short, value_name = "PNG|SVG|Y4M|-", value_parser = OutputFile::or_stdout(), display_order = 1)]
    output: OutputFile,
    /// Pictures per second of the clip, with --frames [default: 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000),
        help_heading = SEQUENCES, hide_short_help = true)]
    fps: Option<u32>,
    #[command(flatten)]
    samples: SamplesArgs,
    /// Turn the light once around the vertical axis over the sequence, with --frames
    #[arg(long, help_heading = SEQUENCES, hide_short_help = true)]
    turn_light: bool,
    /// Turn the camera once around the vertical axis through its target over the sequence, with --frames
    ///
    /// Unless a camera is given, it is far enough away that the model stays in the picture from all sides. With
    /// --turn-light the light turns along, as if the model were on a turntable.
    #[arg(long, help_heading = SEQUENCES, hide_short_help = true)]
    auto_rotate: bool,
    /// Paint one picture stroke after stroke over the sequence, with --style ink and --frames
    #[arg(long, help_heading = SEQUENCES, hide_short_help = true, conflicts_with_all = ["turn_light", "auto_rotate"])]
    paint: bool,
    /// Draw all numbered pictures again, including those left by an interrupted run
    #[arg(long, help_heading = SEQUENCES, hide_short_help = true)]
    restart: bool,
    #[command(flatten)]
    view: ViewArgs,
}

/// Pictures or video that were drawn. For a sequence, figures are those of the first picture, and lists have an element
/// per picture.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RenderResult<'a> {
    /// Path of the first picture, or of the video.
    output: &'a str,
    outputs: &'a [String],
    adapter: &'a str,
    driver: String,
    width: u32,
    height: u32,
    /// Number of pictures or video frames.
    frames: usize,
    /// Pictures per second.
    fps: u32,
    /// Number of pictures kept from an interrupted run, which recorded their figures.
    skipped: usize,
    scene: Option<RenderedScene<'a>>,
    /// Camera of the first picture in the format of `--camera`: eye/target/vertical field of view in degrees.
    camera: String,
    /// Number of pixels with nonzero opacity.
    covered_pixels: u64,
    /// Number of pixels with nonzero opacity in each picture.
    covered_pixels_per_picture: Vec<u64>,
    /// Mean luminance of the covered pixels of each picture, linear, 0 to 1.
    mean_luminance_per_picture: Vec<f64>,
    passes: &'a [PassRun],
    /// Level of detail of the fur of each copy in the first picture.
    detail: &'a [FurDetail],
}

/// Models of a scene file.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct RenderedScene<'a> {
    /// Names of the models, in file order.
    models: &'a [String],
    /// Packages of the models, without duplicates.
    packages: Vec<&'a str>,
}

impl RenderArgs {
    /// Returns the description of the pictures for the cache.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: Job::name(&self.output), restart: false, ..self.clone() };
        (*self.output != *Path::new("-")).then(|| Job::new("render", &args, &[&self.output]))
    }
}

/// Rejects arguments that cannot be combined with a scene file.
fn refuse_beside(file: &str, args: &ViewArgs) -> Result<(), Failure> {
    for (name, given) in [
        ("--clip", args.clip.is_some()),
        ("--blend", args.blend.is_some()),
        ("--morph", !args.morph.is_empty()),
        ("--crowd", args.crowd != 1),
    ] {
        if given {
            let text = format!("{name}: {file} defines what is in the picture, expected it to be left out");
            return Err(Failure::Usage(text));
        }
    }
    Ok(())
}

/// Default number of pictures per second.
const FPS: u32 = 24;

/// Subject of the pictures: one package, or a scene of several.
enum Subject {
    Package(NamedPackage<'static>),
    Scene(Box<Scene>),
}

impl Subject {
    fn read(path: &Path) -> Result<Self, Failure> {
        let file = package_file::read(path)?;
        let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        if !file.bytes.starts_with(&MAGIC) && (named || is_scene(&file.bytes)) {
            return Ok(Self::Scene(Box::new(Scene::read(path, file.bytes.into_owned())?)));
        }
        Ok(Self::Package(file))
    }

    fn scene(&self) -> Option<&Scene> {
        match self {
            Self::Package(_) => None,
            Self::Scene(scene) => Some(scene),
        }
    }

    fn packages(&self) -> &[NamedPackage<'static>] {
        match self {
            Self::Package(file) => std::slice::from_ref(file),
            Self::Scene(scene) => &scene.loaded.packages,
        }
    }

    /// Adds the scene and packages to the key of a picture.
    fn key(&self, key: Key) -> Key {
        let key = key.with(self.scene().map_or("", |scene| &scene.file.text));
        self.packages().iter().fold(key, |key, file| key.with(&file.bytes))
    }

    fn cast(&self, view: &PictureView) -> Result<Cast<'_>, StageError> {
        match self {
            Self::Package(file) => crowd(file, view),
            Self::Scene(scene) => scene.loaded.cast(view.camera, view.look.aspect(), &view.framing),
        }
    }
}

/// Runs the subcommand.
pub fn run(args: &RenderArgs, output: &mut Output) -> Result<Exit, Failure> {
    if *args.output == *Path::new("-") && output.is_json() {
        return Err(Failure::Usage("--json and -o - both write to standard output, expected only one of them".into()));
    }
    // The output name is validated before anything is read. Look files are read only once, after the scene, because a
    // look file may be a pipe.
    Sink::new(&args.output, args.view.frames, None)?;
    output.progress("loading");
    let subject = Subject::read(&args.input)?;
    let scene = subject.scene();
    if let Some(scene) = scene {
        refuse_beside(&scene.file.name, &args.view)?;
    }
    let look = scene.map_or_else(Look::of_picture, |scene| scene.look.clone());
    let mut view = PictureView::new(&args.view, look)?;
    args.samples.apply(&mut view.look)?;
    let sink = Sink::new(&args.output, args.view.frames, scene.and_then(|s| s.file.frames()))?;
    let of_scene = scene.and_then(|s| s.file.frames());
    // A single picture shows hair at rest. In a sequence, hair is simulated from before the first picture.
    let of_range = |frames: Frames| frames.of.or(of_scene).unwrap_or(frames.end.max(2));
    let frames = args.view.frames.map(of_range).or(of_scene).filter(|_| sink.is_sequence());
    if let Some(range) = args.view.frames.filter(|range| frames.is_some_and(|count| range.end > count)) {
        let (last, count) = (range.end, frames.unwrap_or_default());
        return Err(Failure::Usage(format!(
            "--frames: found a range up to {last}, but the scene has {count} pictures"
        )));
    }
    for (name, given) in
        [("--turn-light", args.turn_light), ("--auto-rotate", args.auto_rotate), ("--paint", args.paint)]
    {
        if given && args.view.frames.is_some_and(|range| range.of.is_none()) && of_scene.is_none() {
            let text = format!("{name}: all N pictures of a sequence are needed, expected --frames A..B/N");
            return Err(Failure::Usage(text));
        }
        if given && frames.is_none() {
            let text = format!("{name}: expected --frames as well, or a sequence in the scene file");
            return Err(Failure::Usage(text));
        }
    }
    view.framing.all_around = args.auto_rotate;
    let count = frames.unwrap_or(1) as usize;
    let first = args.view.frames.map_or(0, |range| range.first as usize);
    let fps = args.fps.or(scene.and_then(|s| s.file.fps())).unwrap_or(FPS);
    let cast = subject.cast(&view)?;
    let fibres = cast.has_fibres()?;
    let view = view.resolved(fibres);
    if view.look.picture.style == LookStyle::Fur && view.look.environment.sky.is_some() && !fibres {
        output.note(
            "note: found the shading model `kajiya-kay`, which only approximates light from all around: for hair that \
             scatters it, bake the model with shading.model=marschner",
        );
    }
    if args.paint && (view.look.picture.style, view.look.ink.lines) != (LookStyle::Ink, LookLines::Strokes) {
        return Err(Failure::Usage("--paint: expected --style ink, and --ink-lines strokes (the default)".into()));
    }
    match (view.look.picture.style, view.look.ink.lines) {
        (LookStyle::Ink, LookLines::Pixels) => note_undrawn_hair(output, &cast.packages)?,
        (LookStyle::Ink, LookLines::Strokes) => note_missing_strokes(output, &cast.packages)?,
        (LookStyle::Fur | LookStyle::Bare, _) => {}
    }
    if view.look.environment.ground.is_some() && view.look.environment.sky.is_none() {
        output.note("note: --ground has no effect without --environment");
    }
    let stage = stages::stage(&cast, &view, Gpu::open)?;
    io_trace::record_machine(ADAPTER, &stage.gpu.description());
    let (light, environment, shot) = (stage.params.light, stage.params.environment.clone(), cast.camera);
    let (turn_light, auto_rotate) = (args.turn_light, args.auto_rotate);
    if view.camera.is_none() {
        output.note(&format!("camera: --camera={}", shot.at(view.time_s)));
    }
    let mut shoot = PictureSeries {
        scene: stage,
        view,
        shot,
        light,
        environment,
        turn_light,
        auto_rotate,
        paint: args.paint,
        first,
        count,
        fps,
        lived: None,
    };
    let key = subject.key(shoot.key());
    let drawn = sink.fill(&mut shoot, key, args.restart, output)?;
    warn_of_empty_pictures(output, &shoot, (&cast.packages, &cast.actors), first, &drawn.pictures)?;
    if sink == Sink::Stdout {
        output.end_progress();
    } else {
        report(output, &shoot, &subject, &sink.files(), &drawn)?;
    }
    Ok(Exit::Done)
}

/// Package of a cast, with its file.
type OpenedPackage<'a> = (&'a NamedPackage<'a>, Arc<Package<'a>>);

/// Notes which packages have no strokes, so that ink falls back to lines found in pixels.
fn note_missing_strokes(output: &Output, packages: &[OpenedPackage<'_>]) -> Result<(), Failure> {
    for (file, package) in packages {
        let fault = |error| file.fault(error);
        let has_strokes = package.stroke_pool().map_err(fault)?.is_some_and(|pool| !pool.strokes.is_empty());
        if !has_strokes && package.contours().map_err(fault)?.is_none() {
            output.note(&format!(
                "note: {}: found no strokes, so ink is drawn with --ink-lines pixels; bake the model again to get them",
                file.name
            ));
        }
    }
    Ok(())
}

/// Notes that ink lines found in pixels leave out the guided hair of packages that have it.
fn note_undrawn_hair(output: &Output, packages: &[OpenedPackage<'_>]) -> Result<(), Failure> {
    let mut names = BTreeSet::new();
    for (file, package) in packages {
        names.extend(package.hair_groups().map_err(|error| file.fault(error))?.iter().map(|group| group.name.clone()));
    }
    if !names.is_empty() {
        let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
        output.note(&format!("note: --ink-lines pixels does not draw guided hair: {}", names.join(", ")));
    }
    Ok(())
}

/// Warns of pictures without a covered pixel, with the reason for the first of them.
fn warn_of_empty_pictures(
    output: &Output,
    shoot: &PictureSeries,
    (packages, actors): (&[OpenedPackage<'_>], &[Actor]),
    first: usize,
    pictures: &[Picture],
) -> Result<(), Failure> {
    let empty = || pictures.iter().enumerate().filter(|(_, picture)| picture.covered_pixels == 0);
    let Some((index, _)) = empty().next() else { return Ok(()) };
    let (camera, time_s) = shoot.view_of(first + index);
    let posed = actors.iter().map(|actor| {
        let (file, package) = &packages[actor.package];
        let mesh = PosedMesh::morphed(&file.name, package, &actor.layers(time_s), &actor.morphs)?;
        Ok((mesh, actor.transform(time_s).as_dmat4()))
    });
    let posed = posed.collect::<Result<Vec<_>, BakeError>>()?;
    let posed: Vec<_> = posed.iter().map(|(mesh, world)| (mesh, *world)).collect();
    let (why, count) = (why_empty(&posed, &camera, shoot.size()), pictures.len());
    let which =
        if count == 1 { "the picture shows".into() } else { format!("{} of {count} pictures show", empty().count()) };
    output.note(&format!("warning: {which} nothing: {why}"));
    Ok(())
}

fn report(
    output: &mut Output,
    shoot: &PictureSeries,
    subject: &Subject,
    files: &[String],
    DrawnPictures { pictures, skipped }: &DrawnPictures,
) -> Result<(), Failure> {
    let info = &shoot.scene.gpu.info;
    let (width, height) = shoot.view.size();
    let scene = subject.scene().map(|scene| RenderedScene {
        models: &scene.loaded.names,
        packages: scene.loaded.packages.iter().map(|file| file.name.as_str()).collect(),
    });
    let result = RenderResult {
        output: &files[0],
        outputs: files,
        adapter: &info.name,
        driver: format!("{} {}", info.driver, info.driver_info),
        width,
        height,
        frames: pictures.len(),
        fps: shoot.fps,
        skipped: *skipped,
        scene,
        camera: shoot.shot.at(shoot.view.time_s).to_string(),
        covered_pixels: pictures[0].covered_pixels,
        covered_pixels_per_picture: pictures.iter().map(|p| p.covered_pixels).collect(),
        mean_luminance_per_picture: pictures.iter().map(|p| p.mean_luminance).collect(),
        passes: &pictures[0].passes,
        detail: &pictures[0].detail,
    };
    output.result(&files.join("\n"), &result)
}
