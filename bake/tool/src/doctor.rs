//! `pelage doctor`: predicts the cost of a package on screen, and recommends changes.

use super::camera_args::CameraArgs;
use super::doctor_trial::try_advice;
use super::exit::{Exit, Failure};
use super::output::{Output, human_bytes};
use super::package_file;
use super::view::PictureView;
use pelage_import::BakeError;
use pelage_stage::{Size, Viewpoint};
use pelage_truth::doctor::{self, Advice, ErrorChange, Memory, OnScreen, PassWork, Prognosis};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Predict the cost of a package on screen, without a GPU, and recommend recipe changes
///
/// Every layer of the model at rest is rasterised and counted; `pelage bench` measures the actual time on an adapter.
/// If there is an adapter, recommendations are tested: those that increase the difference from the reference image
/// are dropped.
#[derive(Clone, Debug, clap::Args)]
pub struct DoctorArgs {
    /// Package to examine
    #[arg(value_name = "PKG")]
    package: PathBuf,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "834x424")]
    size: Size,
    #[command(flatten)]
    camera: CameraArgs,
    /// Copies in the picture, each at the same size on screen
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    instances: u32,
    /// Width and height of the shadow maps, texels; 0 disables shadows
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(0..=8192))]
    shadow_map: u32,
}

/// Predicted rendering cost of a package, counted without a GPU, and recommended changes.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DoctorResult<'a> {
    package: String,
    width: u32,
    height: u32,
    /// Copies of the model, each at the same size.
    instances: u32,
    camera: DoctorCamera,
    /// Pixels covered by the mesh surface of one copy.
    skin_pixels: u64,
    /// Pixels with at least one layer of fur.
    fur_pixels: u64,
    overdraw: Overdraw,
    on_screen: OnScreen,
    passes: &'a [PassWork],
    /// GPU memory of all copies, bytes.
    gpu_bytes: u64,
    memory: Memory,
    /// Recommended changes: first those that improve the look, then those that save time or memory, largest saving
    /// first.
    advice: &'a [Advice],
}

/// Camera of the picture.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct DoctorCamera {
    eye: [f32; 3],
    /// Target point, shown at the centre of the picture, metres.
    target: [f32; 3],
    /// Vertical field of view, degrees.
    fov_deg: f32,
}

/// Number of fur layers over a pixel with fur.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct Overdraw {
    mean: f64,
    max: u16,
}

/// Runs the subcommand.
pub fn run(args: &DoctorArgs, output: &mut Output) -> Result<Exit, Failure> {
    let file = package_file::read(&args.package)?;
    let package = file.open()?;
    output.progress("counting pixels");
    let size = (args.size.width, args.size.height);
    let shown = PictureView::sized(size).seen_from(&args.camera);
    let outline = if shown.camera.is_none() { shown.outline(&file, &package)? } else { Vec::new() };
    let Viewpoint { eye, target, fov_deg } = shown.viewpoint(&outline, package.manifest().fur.height_m);
    let (instances, shadow_map) = (args.instances, args.shadow_map);
    let view = doctor::PrognosisView { eye, target, fov_y_rad: fov_deg.to_radians(), size, instances, shadow_map };
    let fault = |source| BakeError::Package { file: file.name.clone(), source };
    let mut found = doctor::diagnose(&package, &view, &fault)?;
    {
        let shown = PictureView { camera: Some(Viewpoint { eye, target, fov_deg }), ..shown };
        found.advice = try_advice(&file, &shown, found.advice, output)?;
    }
    let result = DoctorResult {
        package: args.package.display().to_string(),
        width: args.size.width,
        height: args.size.height,
        instances,
        camera: DoctorCamera { eye: eye.to_array(), target: target.to_array(), fov_deg },
        skin_pixels: found.covered_pixels[0],
        fur_pixels: found.covered_pixels[1],
        overdraw: Overdraw { mean: found.overdraw.0, max: found.overdraw.1 },
        on_screen: found.on_screen,
        passes: &found.passes,
        gpu_bytes: found.memory.total(),
        memory: found.memory,
        advice: &found.advice,
    };
    output.result(&text(&found), &result)?;
    Ok(Exit::Done)
}

fn text(p: &Prognosis) -> String {
    let mut out = String::new();
    let mut line = |text: String| {
        let _ = writeln!(out, "{text}");
    };
    let [skin, fur] = p.covered_pixels;
    line(format!(
        "{skin} pixels of skin, {fur} with fur; {:.1} layers on a pixel with fur, {} at most",
        p.overdraw.0, p.overdraw.1
    ));
    let s = &p.on_screen;
    line(format!(
        "nearest fur: {:.1} pixels high, layers {:.2} pixels apart, a texel of the tile {:.2} wide",
        s.height_px, s.layer_gap_px, s.texel_px
    ));
    for pass in &p.passes {
        let word = if pass.runs { "runs" } else { "does not run" };
        let fragments = pass.fragments.map_or(String::new(), |n| format!(", {n} fragments"));
        line(format!("  {:12} {word}: {}; {} vertices{fragments}", pass.name, pass.reason, pass.vertices));
    }
    let m = &p.memory;
    line(format!(
        "{} on the device: textures {}, buffers {}, posed vertices {}, single strands {}, shadow maps {}",
        human_bytes(m.total()),
        human_bytes(m.textures),
        human_bytes(m.buffers),
        human_bytes(m.posed),
        human_bytes(m.strands),
        human_bytes(m.shadow_maps)
    ));
    if p.advice.is_empty() {
        line("nothing to change".into());
    }
    for advice in &p.advice {
        line(format!("advice: {}", advice.change));
        line(format!("  {}", advice.found));
        line(format!("  saves {}; costs {}", advice.saves, advice.costs));
        if let Some(ErrorChange { before, after }) = advice.measured {
            line(format!(
                "  measured: error {before:.4} without this change, {after:.4} with it and all changes above"
            ));
        }
    }
    out
}
