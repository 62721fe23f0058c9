//! `pelage reference`: traces a reference image of a package with individual strands.

use super::backdrop::lay_over_sky;
use super::empty_picture::why_empty;
use super::exit::{Exit, Failure};
use super::guard::OutputFile;
use super::job::Job;
use super::journal::Key;
use super::output::{Output, human_bytes, require_parent};
use super::picture_args::positive;
use super::progress::span;
use super::share::share;
use super::truth::ReferenceTracer;
use super::view::PictureView;
use super::view_args::{ALL_OPTIONS, COMMON_OPTIONS, ViewArgs};
use super::{package_file, threads};
use glam::DMat4;
use image::RgbaImage;
use pelage_bake::io;
use pelage_bake::strands::GroomReport;
use pelage_import::BakeError;
use pelage_params::Knob;
use pelage_stage::{Background, Look, NamedPackage, SHORT_FORMS, ShortForm};
use pelage_truth::{Lens, Part, PartHeader, PictureSums, TracedPart, TracedPicture, TrueCamera, TrueScattering};
use serde::Serialize;
use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Help heading of the options that only `reference` has.
const TRACING: &str = "Tracing";

/// Trace a reference image of a package: every strand individually, without layers or adapter
///
/// Takes the options of `render`, except those for drawing layers and those for sequences. One picture per run, at
/// --time.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = ALL_OPTIONS, after_long_help = COMMON_OPTIONS)]
pub struct ReferenceArgs {
    /// Package to trace
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// Picture to write: .png as `render` writes it, or .exr with linear colours times alpha
    #[arg(long, short, value_name = "PNG|EXR", display_order = 1)]
    output: OutputFile,
    /// Samples per pixel; the error falls with their square root [default: 64, with --seconds as many as it allows]
    #[arg(long, alias = "spp", value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    samples: Option<u32>,
    /// Time to trace, seconds, after which the picture has the samples taken until then
    ///
    /// Growing the strands is not counted. The trace ends earlier if --samples are reached. Each pixel gets equally
    /// many samples, at least one: the picture is that of --samples with the number that is printed.
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true, conflicts_with = "part")]
    seconds: Option<f64>,
    /// How hair is lit: `package`, as `render` lights it, or `exact`, with light passing between fibres. Packages with
    /// `shading.model = "marschner"` are always `exact`, except with `--scattering off`
    #[arg(long, value_name = "HOW", default_value = "package", help_heading = TRACING, hide_short_help = true)]
    fibre: FibreLighting,
    /// Maximum number of times that a light path meets hair or mesh surface, for light passing between fibres; with 1,
    /// only light scattered by a single fibre reaches the eye [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000),
        help_heading = TRACING, hide_short_help = true)]
    bounces: Option<u32>,
    /// Smooth the noise of the picture, except across edges of depth, direction and colour, and where light differs by
    /// more than the noise; not for pictures to measure with
    ///
    /// At 16 samples the error of fur falls by a third to a half.
    #[arg(long, conflicts_with = "part", help_heading = TRACING, hide_short_help = true)]
    denoise: bool,
    /// Threads to use; does not change the picture [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024),
        help_heading = TRACING, hide_short_help = true)]
    threads: Option<u16>,
    /// Trace only part K of N, counted from 1, into a .part file. All parts have equal cost. `pelage merge`
    /// combines them into the picture, which has the same bytes as one traced in one piece
    #[arg(long, value_name = "K/N", value_parser = parse_part, help_heading = TRACING, hide_short_help = true)]
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

/// Maximum number of samples per pixel.
const MOST_SAMPLES: u32 = 1_000_000;

/// Maximum number of parts. With more, a part of a large picture would be a single square of pixels.
const MOST_PARTS: u32 = 10_000;

impl ReferenceArgs {
    /// Returns the description of the trace for the cache; `None` if its result depends on the machine's speed.
    pub fn job(&self) -> Option<Job> {
        let args = Self { output: Job::name(&self.output), threads: None, ..self.clone() };
        self.seconds.is_none().then(|| Job::new("reference", &args, &[&self.output]))
    }

    /// Returns the number of samples per pixel at which the trace ends.
    fn most_samples(&self) -> u32 {
        self.samples.unwrap_or(if self.seconds.is_some() { MOST_SAMPLES } else { 64 })
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
    /// Samples per pixel of the picture.
    spp: u32,
    /// Whether `--seconds` ended the trace before `--samples`.
    out_of_time: bool,
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
    if view.look.picture.background == Some(Background::Studio) {
        let text = "--background studio: drawn by `render` only: expected another background, or none";
        return Err(Failure::Usage(text.into()));
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
    let view = truth.resolved(&view);
    let grown_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let sums = pool.install(|| trace(args, &truth, &view, output));
    let picture = if args.denoise { pool.install(|| sums.denoised()) } else { sums.picture() };
    let seconds = start.elapsed().as_secs_f64();
    let camera = truth.camera(&view);
    let bytes = match write {
        Format::Part(part) => {
            let of = PartHeader {
                picture: args.identity(&file, &view),
                width: picture.width,
                height: picture.height,
                spp: sums.samples(),
                part: part.number,
                parts: part.of,
                background: !transparent,
                primary_rays: picture.rays.primary,
                shadow_rays: picture.rays.shadow,
            };
            let shown = png_pixels(&truth, &picture, &view, &camera);
            TracedPart { of, traced: picture.clone(), shown }.encode()
        }
        Format::Png => png(&png_pixels(&truth, &picture, &view, &camera))?,
        Format::Exr => exr(&picture)?,
    };
    io::write_atomic(&args.output, &bytes)?;
    if picture.covered() == 0 && args.part.is_none() {
        let why = why_empty(&[(truth.scene.skin(), DMat4::IDENTITY)], &truth.viewpoint(&view), view.size());
        output.note(&format!("warning: the picture shows nothing: {why}"));
    }
    report(args, output, &truth, &camera, (&picture, sums.samples()), (grown_s, seconds))
}

/// Number of pixels of the pilot trace, which has one sample of each.
const PILOT_PIXELS: u64 = 8192;

/// Traces the picture until the samples or the time are used up. Notes the expected time before.
fn trace(args: &ReferenceArgs, truth: &ReferenceTracer, view: &PictureView, output: &mut Output) -> PictureSums {
    let (part, most) = (args.part.unwrap_or_default(), args.most_samples());
    let (camera, lighting) = (truth.camera(view), truth.lighting(view));
    let add = |sums: &mut PictureSums, count: u32, show: &mut dyn FnMut(u64, u64) -> ControlFlow<()>| {
        // None of the callbacks cancels.
        let _ = truth.scene.add_samples(&camera, &lighting, sums, count, show);
    };
    let mut ignore = |_: u64, _: u64| ControlFlow::Continue(());
    let mut pilot = PictureSums::new(view.size(), part).thinned(PILOT_PIXELS);
    let begun = Instant::now();
    add(&mut pilot, 1, &mut ignore);
    let per_pixel_s = begun.elapsed().as_secs_f64() / pilot.pixels().max(1) as f64;
    drop(pilot);
    let sums = PictureSums::new(view.size(), part);
    let mut sums = if args.denoise { sums.guided() } else { sums };
    let pixels = sums.pixels();
    let per_sample_s = per_pixel_s * pixels as f64;
    output.note(&expected_cost(pixels, (most, args.samples.is_some()), args.seconds, per_sample_s));
    let Some(seconds) = args.seconds else {
        let mut show = |done: u64, total: u64| {
            output.progress_of(done as usize, total as usize, "pixels traced");
            ControlFlow::Continue(())
        };
        add(&mut sums, most, &mut show);
        return sums;
    };
    let begun = Instant::now();
    while sums.samples() < most {
        output.progress(&format!("tracing, samples per pixel: {}", sums.samples()));
        add(&mut sums, 1, &mut ignore);
        if !has_time(seconds, begun.elapsed().as_secs_f64(), sums.samples()) {
            break;
        }
    }
    sums
}

/// Returns whether another sample of each pixel fits into `seconds` after `samples` that took `spent_s`.
fn has_time(seconds: f64, spent_s: f64, samples: u32) -> bool {
    spent_s + spent_s / f64::from(samples.max(1)) <= seconds
}

/// Describes the expected cost of a trace, before it begins.
///
/// * `most`, `asked`: number of samples per pixel at which the trace ends, and whether the command line states it
/// * `per_sample_s`: time of one sample of each pixel, measured on a few of them
fn expected_cost(pixels: u64, (most, asked): (u32, bool), seconds: Option<f64>, per_sample_s: f64) -> String {
    let rate = pixels as f64 * 1e-6 / per_sample_s.max(1e-9);
    let rate = format!("each of {pixels} pixels, at {rate:.2} million samples per second");
    let all_s = f64::from(most) * per_sample_s;
    let within =
        |time_s: f64| if time_s < 1.0 { "less than 1 s".to_owned() } else { format!("about {}", span(time_s)) };
    match seconds.filter(|seconds| *seconds < all_s) {
        None => format!("note: expected to take {}: {most} samples of {rate}", within(all_s)),
        Some(seconds) => {
            let fit = ((seconds / per_sample_s) as u32).clamp(1, most);
            let of = if asked { format!(" of {most}") } else { String::new() };
            let time = within(seconds.max(per_sample_s));
            format!("note: expected to take {time}: about {fit}{of} samples of {rate}")
        }
    }
}

impl ReferenceArgs {
    /// Returns a key of everything that the picture depends on. It is the same for all parts and machines.
    fn identity(&self, file: &NamedPackage<'_>, view: &PictureView) -> String {
        let args = (self.most_samples(), self.fibre, self.bounces);
        Key::of_version().with(format!("{args:?} {view:?}")).with(&file.bytes).finish()
    }
}

/// Returns the pixels to write as PNG.
fn png_pixels(truth: &ReferenceTracer, picture: &TracedPicture, view: &PictureView, camera: &TrueCamera) -> RgbaImage {
    let mut pixels = truth.encode(picture, view);
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
    (picture, spp): (&TracedPicture, u32),
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
        spp,
        out_of_time: spp < args.most_samples(),
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
             {mrays_per_s:.2} million per second; {spp} samples per pixel",
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
const FAST_PATH: [(&str, bool); 10] = [
    ("ground-shadow", false),
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
            "--{flag} applies to `render` only: a reference image has no layers, shadow maps and ground; leave it out"
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_ends_a_trace_after_at_least_one_sample() {
        // Samples of each pixel take 2 s.
        let reached = |seconds: f64| (1..100).find(|n| !has_time(seconds, 2.0 * f64::from(*n), *n));
        assert_eq!([0.1, 2.0, 3.9, 4.0, 60.0].map(reached), [1, 1, 1, 2, 30].map(Some));
    }

    #[test]
    fn expected_cost_is_the_smaller_of_samples_and_time() {
        let said = |samples, seconds| expected_cost(500_000, samples, seconds, 2.0);
        let rate = "of each of 500000 pixels, at 0.25 million samples per second";
        let expect = |samples, seconds, text: &str| {
            assert_eq!(said(samples, seconds), format!("note: expected to take {text} samples {rate}"));
        };
        expect((64, true), None, "about 2 min: 64");
        expect((4, true), Some(60.0), "about 8 s: 4");
        expect((64, true), Some(60.0), "about 60 s: about 30 of 64");
        expect((9999, false), Some(60.0), "about 60 s: about 30");
        expect((64, true), Some(0.5), "about 2 s: about 1 of 64");
        assert!(expected_cost(100, (2, true), None, 0.001).starts_with("note: expected to take less than 1 s: 2 "));
    }
}
