//! `pelage reference`: the true picture of a package, traced strand by strand.

use super::backdrop::lay_over_sky;
use super::exit::{Exit, Failure};
use super::output::{Output, human_bytes, require_parent};
use super::package_file;
use super::threads;
use super::truth::{Truth, encode};
use super::view::View;
use super::view_args::ViewArgs;
use pelage_bake::judge::truth::{Lens, TracedPicture, TrueCamera, TrueScattering};
use pelage_bake::strands::GroomReport;
use pelage_bake::{BakeError, io};
use pelage_params::Knob;
use pelage_stage::{Background, Look, SHORT_FORMS, ShortForm};
use serde_json::json;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Trace the true picture of a package: every strand one by one, no layers, no adapter
#[derive(Clone, Debug, clap::Args)]
pub struct ReferenceArgs {
    /// The package
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// The picture to write: .png as `render` writes it, or .exr with linear colours times alpha
    #[arg(long, short, value_name = "PNG|EXR")]
    output: PathBuf,
    /// Samples per pixel: the error falls with their square root
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    spp: u32,
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
    #[command(flatten)]
    view: ViewArgs,
}

/// How the hair of a reference is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum FibreTruth {
    /// As the package says
    Package,
    /// By light that goes from fibre to fibre
    Exact,
}

/// Runs the subcommand.
pub fn run(args: &ReferenceArgs, output: &mut Output) -> Result<Exit, Failure> {
    let view = View::new(&args.view, Look::default())?;
    refuse_fast_path(&args.view)?;
    let write = Format::of(&args.output)?;
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
    let picture = pool.install(|| truth.picture(&view, args.spp, &mut show));
    let seconds = start.elapsed().as_secs_f64();
    let camera = truth.camera(&view);
    io::write_atomic(&args.output, &write.bytes(&picture, &view, &camera)?)?;
    report(args, output, &truth, &camera, &picture, (grown_s, seconds))
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
    let covered = picture.pixels.iter().filter(|p| p[3] > 0.0).count();
    let groom = &truth.report;
    let bytes_per_strand = truth.scene.bytes_per_strand();
    let value = json!({
        "output": args.output.display().to_string(),
        "width": picture.width,
        "height": picture.height,
        "spp": args.spp,
        "strands": groom.strands,
        "segments": groom.segments,
        "groom": groom_json(groom),
        "bytes_per_strand": bytes_per_strand,
        "camera": camera_json(camera),
        "primary_rays": picture.rays.primary,
        "shadow_rays": picture.rays.shadow,
        "grow_seconds": grown_s,
        "seconds": seconds,
        "mrays_per_s": mrays_per_s,
        "covered_pixels": covered,
    });
    let text = format!(
        "{}\n{} strands in {} pieces, {} each, grown in {grown_s:.1} s; {:.1} million rays in {seconds:.1} s, {mrays_per_s:.2} million a second",
        args.output.display(),
        groom.strands,
        groom.segments,
        human_bytes(bytes_per_strand as u64),
        rays as f64 * 1e-6,
    );
    output.result(&text, &value)?;
    Ok(Exit::Done)
}

/// What became of the tile's strands.
pub fn groom_json(groom: &GroomReport) -> serde_json::Value {
    json!({
        "points_before_simplification": groom.points_before,
        "crossed_patch_border": groom.crossed_patch_border,
        "crossed_mesh_border": groom.crossed_mesh_border,
        "slid_along_border": groom.slid_along_border,
        "lost": groom.lost,
        "dropped_cut_out": groom.dropped_cut,
        "dropped_no_length": groom.dropped_bare,
        "dropped_thinned_out": groom.dropped_thinned,
        "triangles_without_coordinates": groom.triangles_without_coordinates,
    })
}

/// A camera as other programs want it.
pub fn camera_json(camera: &TrueCamera) -> serde_json::Value {
    let fov_deg = match camera.lens {
        Lens::Perspective { fov_y_rad } => Some(f64::from(fov_y_rad).to_degrees()),
        Lens::Orthographic { .. } => None,
    };
    json!({
        "eye": camera.eye_ws.to_array(),
        "target": camera.target_ws.to_array(),
        "up": camera.up_ws.to_array(),
        "fov_y_deg": fov_deg,
    })
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
enum Format {
    Png,
    Exr,
}

impl Format {
    fn of(path: &Path) -> Result<Self, Failure> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Failure::Usage(format!("-o {}: expected a name that ends in .png or .exr", path.display()))),
        }
    }

    fn bytes(self, picture: &TracedPicture, view: &View, camera: &TrueCamera) -> Result<Vec<u8>, Failure> {
        let mut bytes = Cursor::new(Vec::new());
        let written = match self {
            Self::Png => {
                let mut pixels = encode(picture, view.look.background());
                lay_over_sky(&view.look, view.sky.as_deref(), &mut pixels, camera, 0.0);
                pixels.write_to(&mut bytes, image::ImageFormat::Png)
            }
            Self::Exr => {
                let flat: Vec<f32> = picture.pixels.iter().flatten().copied().collect();
                // OpenEXR holds colours times alpha, as the picture does; a background is another picture's matter.
                image::Rgba32FImage::from_raw(picture.width, picture.height, flat)
                    .ok_or_else(|| BakeError::Internal("a traced picture of another size than it says".into()))?
                    .write_to(&mut bytes, image::ImageFormat::OpenExr)
            }
        };
        written.map_err(|error| BakeError::Internal(format!("encoding {self:?}: {error}")))?;
        Ok(bytes.into_inner())
    }
}
