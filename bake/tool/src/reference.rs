//! `pelage reference`: the true picture of a package, traced strand by strand.

use super::backdrop::lay_over_sky;
use super::errand::Errand;
use super::exit::{Exit, Failure};
use super::journal::Key;
use super::output::{Output, human_bytes, require_parent};
use super::package_file;
use super::share::share;
use super::threads;
use super::truth::{Truth, encode};
use super::view::View;
use super::view_args::ViewArgs;
use image::RgbaImage;
use pelage_bake::io;
use pelage_bake::strands::GroomReport;
use pelage_import::BakeError;
use pelage_params::Knob;
use pelage_stage::{Background, Look, NamedPackage, SHORT_FORMS, ShortForm};
use pelage_truth::{Lens, OfPicture, Part, Portion, TracedPart, TracedPicture, TrueCamera, TrueScattering};
use serde::Serialize;
use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Trace the true picture of a package: every strand one by one, no layers, no adapter
///
/// It takes the options of `render` but those that say how layers are drawn (it has none) and those of sequences: one picture a run, at --time.
#[derive(Clone, Debug, clap::Args)]
pub struct ReferenceArgs {
    /// The package
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// The picture to write: .png as `render` writes it, or .exr with linear colours times alpha
    #[arg(long, short, value_name = "PNG|EXR")]
    output: PathBuf,
    /// Samples per pixel: the error falls with their square root
    #[arg(long, alias = "spp", value_name = "N", default_value_t = 64,
        value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    samples: u32,
    /// How hair is lit: as `render` lights it, or `exact`, by light that goes from fibre to fibre. Packages with `shading.model = "marschner"` are `exact`
    /// anyway, but with `--scattering off`
    #[arg(long, value_name = "HOW", default_value = "package")]
    fibre: FibreTruth,
    /// How often light meets hair or skin at most, where it goes from fibre to fibre; 1 is what comes from the lights by one fibre [default: 64]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    bounces: Option<u32>,
    /// Threads; by default one per core. The picture is the same with any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Trace part K alone of N, from 1, as dear as the others, into a .part file: `pelage merge` makes the picture of all of them, bit for bit as in one piece
    #[arg(long, value_name = "K/N", value_parser = parse_part)]
    part: Option<Part>,
    #[command(flatten)]
    view: ViewArgs,
}

/// `3/16`, from 1.
fn parse_part(text: &str) -> Result<Part, String> {
    let (number, of) = share(text)
        .filter(|(_, of)| *of <= MOST_PARTS)
        .ok_or_else(|| format!("expected a part and how many there are, such as 3/16, at most {MOST_PARTS}"))?;
    Ok(Part { number: number - 1, of })
}

/// Beyond that a part of a large picture is a square.
const MOST_PARTS: u32 = 10_000;

impl ReferenceArgs {
    /// What the picture depends on, and where it goes.
    pub fn errand(&self) -> Option<Errand> {
        let args = Self { output: Errand::name(&self.output), threads: None, ..self.clone() };
        Some(Errand::new("reference", &args, &[&self.output]))
    }
}

/// How the hair of a reference is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FibreTruth {
    /// As the package says
    Package,
    /// By light that goes from fibre to fibre
    Exact,
}

/// A traced picture, and what it took.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReferenceResult {
    output: String,
    width: u32,
    height: u32,
    spp: u32,
    /// Strands on the whole skin.
    strands: u64,
    /// Straight segments of the strands after simplification.
    segments: u64,
    groom: GroomReport,
    /// Memory for each strand: points, segments and their tree.
    bytes_per_strand: f64,
    camera: CameraResult,
    /// Rays from the eye.
    primary_rays: u64,
    /// Rays to the lights.
    shadow_rays: u64,
    /// Time to grow the strands and build the trees.
    grow_seconds: f64,
    seconds: f64,
    mrays_per_s: f64,
    /// Pixels with any opacity.
    covered_pixels: usize,
}

/// Runs the subcommand.
pub fn run(args: &ReferenceArgs, output: &mut Output) -> Result<Exit, Failure> {
    let view = View::new(&args.view, Look::default())?;
    refuse_fast_path(&args.view)?;
    let write = match args.part {
        Some(part) => Format::of_part(&args.output, part)?,
        None => Format::of(&args.output)?,
    };
    let transparent = matches!(view.look.picture.background, None | Some(Background::Transparent));
    if write == Format::Exr && !transparent {
        return Err(Failure::Usage(
            "--background: an .exr keeps what is transparent; expected it to be left out".into(),
        ));
    }
    require_parent(&args.output)?;
    let file = package_file::read(&args.package)?;
    let pool = threads::pool(args.threads)?;

    output.progress("growing strands");
    let start = Instant::now();
    let mut truth = pool.install(|| Truth::new(&file, &view))?;
    if args.fibre == FibreTruth::Exact || args.bounces.is_some() {
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
    // Nobody breaks off.
    let picture = pool.install(|| truth.portion(&view, &portion, &mut going_on)).unwrap_or_default();
    let seconds = start.elapsed().as_secs_f64();
    let camera = truth.camera(&view);
    let bytes = match write {
        Format::Part(part) => {
            let of = OfPicture {
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
            let shown = shown(&picture, &view, &camera);
            TracedPart { of, traced: picture.clone(), shown }.encode()
        }
        Format::Png => png(&shown(&picture, &view, &camera))?,
        Format::Exr => exr(&picture)?,
    };
    io::write_atomic(&args.output, &bytes)?;
    report(args, output, &truth, &camera, &picture, (grown_s, seconds))
}

impl ReferenceArgs {
    /// Stands for everything that the picture depends on, whichever part of it is traced where.
    fn identity(&self, file: &NamedPackage<'_>, view: &View) -> String {
        let args = (self.samples, self.fibre, self.bounces);
        Key::of_version().and(format!("{args:?} {view:?}")).and(&file.bytes).finish()
    }
}

/// What a PNG shows.
fn shown(picture: &TracedPicture, view: &View, camera: &TrueCamera) -> RgbaImage {
    let mut pixels = encode(picture, view.look.background());
    lay_over_sky(&view.look, view.sky.as_deref(), &mut pixels, camera, 0.0);
    pixels
}

/// The file of a picture, PNG.
pub fn png(pixels: &RgbaImage) -> Result<Vec<u8>, Failure> {
    encoded(|bytes| pixels.write_to(bytes, image::ImageFormat::Png))
}

/// The file of what was traced, EXR: it holds colours times alpha, as the picture does; a background is another picture's matter.
pub fn exr(picture: &TracedPicture) -> Result<Vec<u8>, Failure> {
    let flat: Vec<f32> = picture.pixels.iter().flatten().copied().collect();
    let image = image::Rgba32FImage::from_raw(picture.width, picture.height, flat)
        .ok_or_else(|| BakeError::Internal("a traced picture of another size than it says".into()))?;
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
    truth: &Truth,
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
        "{}\n{} strands in {} pieces, {} each, grown in {grown_s:.1} s; {:.1} million rays in {seconds:.1} s, {mrays_per_s:.2} million a second",
        args.output.display(),
        groom.strands,
        groom.segments,
        human_bytes(bytes_per_strand as u64),
        rays as f64 * 1e-6,
    );
    output.result(&text, &result)?;
    Ok(Exit::Done)
}

/// The camera of `render` for the same view.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CameraResult {
    /// Position of the eye, metres.
    eye: [f32; 3],
    /// Point in the middle of the picture, metres.
    target: [f32; 3],
    /// Up direction of the picture.
    up: [f32; 3],
    /// Height of the view, degrees; null for a parallel projection.
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

/// Flags that say how the fast path shall draw, and whether to name one is too much even if it asks for the default.
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

/// Keys of looks that say how the fast path shall draw, and mean nothing to the truth.
#[cfg(feature = "herd")]
pub fn only_drawn() -> Vec<&'static str> {
    let of = |(flag, _): &(&str, bool)| SHORT_FORMS.iter().find(|short| short.flag == *flag).map(|short| short.key);
    FAST_PATH.iter().filter_map(of).collect()
}

/// Refuses arguments that say how the fast path shall draw: the truth has nothing that they could change. A look file may say so: `render` reads it
/// as well.
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
            "--{flag} says how `render` draws; the reference has neither layers nor maps, expected it to be left out"
        ))),
        None => Ok(()),
    }
}

/// What kind of file the picture becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// As `render` writes it.
    Png,
    /// Linear colours times alpha.
    Exr,
    /// A part of it.
    Part(Part),
}

impl Format {
    /// That of a whole picture, by the file's name.
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
                let expected = "with --part expected a name that ends in .part, which `pelage merge` reads";
                Err(Failure::Usage(format!("-o {}: {expected}", path.display())))
            }
        }
    }
}

fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}
