//! `pelage reference`: traces a reference image of a package with individual strands.

use super::backdrop::lay_over_sky;
use super::empty_picture::why_empty;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::journal::Key;
use super::output::{Output, human_bytes, require_parent};
use super::package_file;
use super::share::share;
use super::threads;
use super::truth::{ReferenceTracer, encode};
use super::view::PictureView;
use super::view_args::ViewArgs;
use glam::DMat4;
use image::RgbaImage;
use pelage_bake::io;
use pelage_bake::strands::GroomReport;
use pelage_import::BakeError;
use pelage_params::Knob;
use pelage_stage::{Background, Look, NamedPackage, SHORT_FORMS, ShortForm};
use pelage_truth::{Lens, Part, PartHeader, Portion, TracedPart, TracedPicture, TrueCamera, TrueScattering};
use serde::Serialize;
use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Trace a reference image of a package: every strand individually, without layers or adapter
///
/// Takes the options of `render`, except those for drawing layers and those for sequences. One picture per run, at
/// --time.
#[derive(Clone, Debug, clap::Args)]
pub struct ReferenceArgs {
    /// Package to trace
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// Picture to write: .png as `render` writes it, or .exr with linear colours times alpha
    #[arg(long, short, value_name = "PNG|EXR")]
    output: OutputFile,
    /// Samples per pixel; the error falls with their square root
    #[arg(long, alias = "spp", value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    /// How hair is lit: `package`, as `render` lights it, or `exact`, with light passing between fibres. Packages with
    /// `shading.model = "marschner"` are always `exact`, except with `--scattering off`
    #[arg(long, value_name = "HOW", default_value = "package")]
    fibre: FibreLighting,
    /// Maximum number of times that a light path meets hair or mesh surface, for light passing between fibres; with 1,
    /// only light scattered by a single fibre reaches the eye [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    bounces: Option<u32>,
    /// Threads to use; does not change the picture [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Trace only part K of N, counted from 1, into a .part file. All parts have equal cost. `pelage merge`
    /// combines them into the picture, which has the same bytes as one traced in one piece
    #[arg(long, value_name = "K/N", value_parser = parse_part)]
    part: Option<Part>,
    #[command(flatten)]
    view: ViewArgs,
}

/// Parses a part such as `3/16`; parts are counted from 1.
fn parse_part(text: &str) -> Result<Part, String> {
    let (number, of) = share(text)
        .filter(|(_, of)| *of <= MOST_PARTS)
        .ok_or_else(|| format!("expected a part and the number of parts, such as 3/16, at most {MOST_PARTS} parts"))?;
    Ok(Part { number: number - 1, of })
}

/// Maximum number of parts. With more, a part of a large picture would be a single square of pixels.
const MOST_PARTS: u32 = 10_000;

impl ReferenceArgs {
    /// Returns the description of the trace for the cache.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: Job::name(&self.output), threads: None, ..self.clone() };
        Some(Job::new("reference", &args, &[&self.output]))
    }
}

/// Model of hair lighting in a reference image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FibreLighting {
    /// Lit as the package says
    Package,
    /// With light passing between fibres
    Exact,
}

/// Traced picture, and what it cost.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferenceResult {
    output: String,
    width: u32,
    height: u32,
    spp: u32,
    /// Number of strands on the whole mesh surface.
    strands: u64,
    /// Number of straight segments of the strands after simplification.
    segments: u64,
    groom: GroomReport,
    /// Memory per strand for points, segments and their tree, bytes.
    bytes_per_strand: f64,
    camera: CameraResult,
    /// Number of camera rays.
    primary_rays: u64,
    /// Number of shadow rays.
    shadow_rays: u64,
    /// Time to grow the strands and build the trees, seconds.
    grow_seconds: f64,
    seconds: f64,
    mrays_per_s: f64,
    /// Number of pixels with nonzero opacity.
    covered_pixels: usize,
}

/// Runs the subcommand.
pub fn run(args: &ReferenceArgs, output: &mut Output) -> Result<Exit, Failure> {
    let view = PictureView::new(&args.view, Look::default())?;
    refuse_fast_path(&args.view)?;
    let write = match args.part {
        Some(part) => Format::of_part(&args.output, part)?,
        None => Format::of(&args.output)?,
    };
    let transparent = matches!(view.look.picture.background, None | Some(Background::Transparent));
    if write == Format::Exr && !transparent {
        return Err(Failure::Usage(
            "--background: found with an .exr, which stores transparency; expected no --background".into(),
        ));
    }
    require_parent(&args.output)?;
    let file = package_file::read(&args.package)?;
    let pool = threads::pool(args.threads)?;

    output.progress("growing strands");
    let start = Instant::now();
    let mut truth = pool.install(|| ReferenceTracer::new(&file, &view))?;
    if args.fibre == FibreLighting::Exact || args.bounces.is_some() {
        truth.scatter(args.bounces.unwrap_or(TrueScattering::BOUNCES))?;
    }
    let grown_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut show = |done: u64, total: u64| output.progress_of(done as usize, total as usize, "pixels traced");
    let portion = Portion { samples: 0..args.samples, part: args.part.unwrap_or_default() };
    let mut going_on = |done, total| {
        show(done, total);
        ControlFlow::Continue(())
    };
    // The callback never cancels, so there is always a picture.
    let picture = pool.install(|| truth.portion(&view, &portion, &mut going_on)).unwrap_or_default();
    let seconds = start.elapsed().as_secs_f64();
    let camera = truth.camera(&view);
    let bytes = match write {
        Format::Part(part) => {
            let of = PartHeader {
                picture: args.identity(&file, &view),
                width: picture.width,
                height: picture.height,
                spp: args.samples,
                part: part.number,
                parts: part.of,
                background: !transparent,
                primary_rays: picture.rays.primary,
                shadow_rays: picture.rays.shadow,
            };
            let shown = png_pixels(&picture, &view, &camera);
            TracedPart { of, traced: picture.clone(), shown }.encode()
        }
        Format::Png => png(&png_pixels(&picture, &view, &camera))?,
        Format::Exr => exr(&picture)?,
    };
    io::write_atomic(&args.output, &bytes)?;
    if picture.covered() == 0 && args.part.is_none() {
        let why = why_empty(&[(truth.scene.skin(), DMat4::IDENTITY)], &truth.viewpoint(&view), view.size());
        output.note(&format!("warning: the picture shows nothing: {why}"));
    }
    report(args, output, &truth, &camera, &picture, (grown_s, seconds))
}

impl ReferenceArgs {
    /// Returns a key of everything that the picture depends on. It is the same for all parts and machines.
    fn identity(&self, file: &NamedPackage<'_>, view: &PictureView) -> String {
        let args = (self.samples, self.fibre, self.bounces);
        Key::of_version().with(format!("{args:?} {view:?}")).with(&file.bytes).finish()
    }
}

/// Returns the pixels to write as PNG.
fn png_pixels(picture: &TracedPicture, view: &PictureView, camera: &TrueCamera) -> RgbaImage {
    let mut pixels = encode(picture, view.look.background());
    lay_over_sky(&view.look, view.sky.as_deref(), &mut pixels, camera, 0.0);
    pixels
}

/// Encodes a picture as a PNG file.
pub fn png(pixels: &RgbaImage) -> Result<Vec<u8>, Failure> {
    encoded(|bytes| pixels.write_to(bytes, image::ImageFormat::Png))
}

/// Encodes a traced picture as an EXR file, with premultiplied linear colours and without background.
pub fn exr(picture: &TracedPicture) -> Result<Vec<u8>, Failure> {
    let flat: Vec<f32> = picture.pixels.iter().flatten().copied().collect();
    let image = image::Rgba32FImage::from_raw(picture.width, picture.height, flat).ok_or_else(|| {
        BakeError::Internal("the size of a traced picture does not match its number of pixels".into())
    })?;
    encoded(|bytes| image.write_to(bytes, image::ImageFormat::OpenExr))
}

fn encoded(write: impl FnOnce(&mut Cursor<Vec<u8>>) -> image::ImageResult<()>) -> Result<Vec<u8>, Failure> {
    let mut bytes = Cursor::new(Vec::new());
    write(&mut bytes).map_err(|error| BakeError::Internal(format!("encoding a picture: {error}")))?;
    Ok(bytes.into_inner())
}

fn report(
    args: &ReferenceArgs,
    output: &mut Output,
    truth: &ReferenceTracer,
    camera: &TrueCamera,
    picture: &TracedPicture,
    (grown_s, seconds): (f64, f64),
) -> Result<Exit, Failure> {
    let rays = picture.rays.primary + picture.rays.shadow;
    let mrays_per_s = rays as f64 * 1e-6 / seconds.max(1e-9);
    let groom = &truth.report;
    let bytes_per_strand = truth.scene.bytes_per_strand();
    let result = ReferenceResult {
        output: args.output.display().to_string(),
        width: picture.width,
        height: picture.height,
        spp: args.samples,
        strands: groom.strands,
        segments: groom.segments,
        groom: *groom,
        bytes_per_strand,
        camera: camera.into(),
        primary_rays: picture.rays.primary,
        shadow_rays: picture.rays.shadow,
        grow_seconds: grown_s,
        seconds,
        mrays_per_s,
        covered_pixels: picture.covered(),
    };
    let text = format!(
        "{}\n{} strands in {} segments, {} per strand, grown in {grown_s:.1} s; {:.1} million rays in {seconds:.1} s, \
             {mrays_per_s:.2} million per second",
        args.output.display(),
        groom.strands,
        groom.segments,
        human_bytes(bytes_per_strand as u64),
        rays as f64 * 1e-6,
    );
    output.result(&text, &result)?;
    Ok(Exit::Done)
}

/// Camera that `render` uses for the same view.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CameraResult {
    /// Position of the eye, metres.
    eye: [f32; 3],
    /// Target point, shown at the centre of the picture, metres.
    target: [f32; 3],
    /// Up direction of the picture.
    up: [f32; 3],
    /// Vertical field of view, degrees; null for a parallel projection.
    fov_y_deg: Option<f64>,
}

impl From<&TrueCamera> for CameraResult {
    fn from(camera: &TrueCamera) -> Self {
        let fov_y_deg = match camera.lens {
            Lens::Perspective { fov_y_rad } => Some(f64::from(fov_y_rad).to_degrees()),
            Lens::Orthographic { .. } => None,
        };
        let [eye, target, up] = [camera.eye_ws, camera.target_ws, camera.up_ws].map(|v| v.to_array());
        Self { eye, target, up, fov_y_deg }
    }
}

/// Flags that affect only how `render` draws. The boolean is true if `reference` rejects the flag even when it is given
/// its default value.
const FAST_PATH: [(&str, bool); 9] = [
    ("layers", true),
    ("fins", true),
    ("lighting", false),
    ("slant", false),
    ("penumbra-form", false),
    ("shadow-map", false),
    ("shadow-layers", true),
    ("shadow-density", false),
    ("shadow-shrink", false),
];

/// Returns the look keys that only affect how `render` draws, and have no effect on a reference image.
#[cfg(feature = "herd")]
pub fn only_drawn() -> Vec<&'static str> {
    let of = |(flag, _): &(&str, bool)| SHORT_FORMS.iter().find(|short| short.flag == *flag).map(|short| short.key);
    FAST_PATH.iter().filter_map(of).collect()
}

/// Rejects arguments that only affect how `render` draws, because a reference image would ignore them. In a look file
/// they are accepted, because `render` reads the same file.
fn refuse_fast_path(args: &ViewArgs) -> Result<(), Failure> {
    let (typed, default) = (args.look.typed(), Look::default());
    let changed = |key: &Knob| key.value(&typed) != key.value(&default);
    let short = |flag: &str| SHORT_FORMS.iter().find(|short| short.flag == flag);
    let refused = |(flag, always): &(&str, bool)| {
        (*always && args.look.has(flag)) || short(flag).and_then(ShortForm::knob).is_some_and(changed)
    };
    let given = FAST_PATH.iter().find(|entry| refused(entry)).map(|(flag, _)| *flag);
    match given.or(args.frames.map(|_| "frames")) {
        Some(flag) => Err(Failure::Usage(format!(
            "--{flag} applies to `render` only: a reference image has neither layers nor shadow maps; leave it out"
        ))),
        None => Ok(()),
    }
}

/// File format of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// PNG, as `render` writes it.
    Png,
    /// EXR with linear colours times alpha.
    Exr,
    /// Part of a picture, for `pelage merge`.
    Part(Part),
}

impl Format {
    /// Returns the format for the extension of a file name; parts have no such format.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        match extension(path).as_str() {
            "png" => Ok(Self::Png),
            "exr" => Ok(Self::Exr),
            _ => Err(Failure::Usage(format!("-o {}: expected a name that ends in .png or .exr", path.display()))),
        }
    }

    fn of_part(path: &Path, part: Part) -> Result<Self, Failure> {
        match extension(path).as_str() {
            "part" => Ok(Self::Part(part)),
            _ => {
                let expected = "with --part, expected a name that ends in .part, for `pelage merge`";
                Err(Failure::Usage(format!("-o {}: {expected}", path.display())))
            }
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
