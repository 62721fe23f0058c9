//! `pelage bench`: times every pass of a package on this machine's adapter.

use super::exit::{Exit, Failure};
use super::look_args::SamplesArgs;
use super::output::{Output, human_bytes};
use super::package_file;
use super::stages::{FurDetail, detail, stage_of};
use super::view::PictureView;
use super::view_args::{ALL_OPTIONS, COMMON_OPTIONS, Frames, ViewArgs};
use pelage_runtime::{Frame, PassId};
use pelage_stage::{Clock, FrameTimes, Gpu, Look, LookStrandEdges, Meter, Spread, Stage};
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Time every pass of a package on this machine's adapter
///
/// Draws as an application does by default: one sample per pixel unless --samples is given, and single strands only
/// where samples show them. `render` draws finer edges (--strand-edges blended), which take longer. The sequence
/// options (--fps, --auto-rotate, --turn-light) apply to `render` only: here every frame is the next one of the clip.
#[derive(Clone, Debug, clap::Args)]
#[command(after_help = ALL_OPTIONS, after_long_help = COMMON_OPTIONS)]
pub struct BenchArgs {
    /// Package to time
    #[arg(value_name = "PKG")]
    package: PathBuf,
    #[command(flatten)]
    samples: SamplesArgs,
    #[command(flatten)]
    view: ViewArgs,
}

/// Cost of a frame on this machine's adapter.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BenchResult<'a> {
    adapter: &'a str,
    driver: String,
    frames: usize,
    timing: Clock,
    frame_ms: Spread,
    passes: Vec<PassTime>,
    /// Time of the same frame without self-shadow and soft shadow, milliseconds.
    unshadowed_frame_ms: Spread,
    /// Median ratio of `frame_ms` to `unshadowed_frame_ms`, with a still light; null without shadows.
    frame_over_unshadowed: Option<f64>,
    /// Time to redraw the shadow maps: the passes layer_shadow and shadow_width together, milliseconds.
    shadow_maps_ms: f64,
    /// Median ratio of `shadow_maps_ms` to `frame_ms`; null without shadows.
    shadow_maps_over_frame: Option<f64>,
    /// Time to draw the same layers with one texture read per fragment and no lighting, milliseconds.
    yardstick_ms: Spread,
    /// Ratio of the shells pass to the yardstick; null if the yardstick takes no time.
    shells_over_yardstick: Option<f64>,
    upload_ms: f64,
    pipelines_ms: f64,
    gpu_bytes: u64,
    /// Shell layers, skin included.
    layers: u32,
    /// Copies of the model.
    instances: usize,
    /// Number of fur layers drawn in a frame, over all copies; mesh surfaces are not counted.
    drawn_layers: u64,
    /// Level of detail of the fur of each copy.
    detail: Vec<FurDetail>,
    triangles: u32,
}

/// Time of a render pass.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct PassTime {
    name: &'static str,
    median_ms: f64,
    fragments: Option<u64>,
}

/// Number of untimed frames before the measurement, in which pipelines, caches and clock rates settle.
const WARM_UP: u32 = 3;
/// Number of timed frames without `--frames`.
const FRAMES: u32 = 30;

/// Runs the subcommand.
pub fn run(args: &BenchArgs, output: &mut Output) -> Result<Exit, Failure> {
    let mut look = Look::default();
    look.fur.strand_edges = LookStrandEdges::Samples;
    let mut view = PictureView::new(&args.view, look)?;
    args.samples.apply(&mut view.look)?;
    let frames = match args.view.frames.map(Frames::count) {
        Some(None) => {
            return Err(Failure::Usage("--frames: found a range, expected the number of frames to time".into()));
        }
        Some(Some(count)) => count,
        None => FRAMES,
    };
    let file = package_file::read(&args.package)?;
    output.progress("loading");
    let mut scene = stage_of(&file, &view, Gpu::open)?;
    let meter = Meter::new(&scene.gpu);
    let fragments = pelage_stage::count_fragments(&mut scene)?;
    let mut times = Vec::new();
    for index in 0..WARM_UP + frames {
        output.progress(&format!("frame {index} of {}", WARM_UP + frames));
        // The clip advances by 1/60 s per frame, so that every frame updates the pose, as in an application.
        let clock_s = scene.params.time_s + Meter::FRAME_S;
        scene.advance(view.time_s + index as f32 / 60.0, clock_s, view.look.hair_motion());
        let frame = meter.measure(&mut scene)?;
        if index >= WARM_UP {
            times.push(frame);
        }
    }
    let frame = scene.draw()?;
    report(output, &scene, &frame, meter.clock(), fragments, &times)?;
    Ok(Exit::Done)
}

fn report(
    output: &mut Output,
    scene: &Stage,
    drawn: &Frame,
    clock: Clock,
    fragments: Option<Vec<(PassId, u64)>>,
    times: &[FrameTimes],
) -> Result<(), Failure> {
    let model = scene.model();
    let manifest = model.manifest();
    let triangles: u32 = manifest.parts.iter().map(|p| p.index_count / 3).sum();
    let layers = scene.params.style.fur().and_then(|fur| fur.layers).unwrap_or(manifest.fur.layers);
    let frame = Spread::of(times.iter().map(|t| t.frame));
    let yardstick = Spread::of(times.iter().map(|t| t.yardstick));
    let style = scene.params.style.kind();
    let median = |id| Spread::of(times.iter().map(|t| t.of(id))).median;
    let count = |id| fragments.iter().flatten().find(|(counted, _)| *counted == id).map(|(_, count)| *count);
    let measured = || PassId::all().filter(|id| pelage_stage::belongs(*id, style));
    let unshadowed = Spread::of(times.iter().map(|t| t.unshadowed));
    let maps_ms = median(PassId::LAYER_SHADOW) + median(PassId::SHADOW_WIDTH);
    let shadowed = pelage_stage::is_shadowed(scene);
    // Ratios are computed per frame, so that interference that lasts longer than a frame cancels out.
    let over_unshadowed = Spread::of(times.iter().filter(|_| shadowed).map(|t| t.frame / t.unshadowed));
    let maps_of = |t: &FrameTimes| t.of(PassId::LAYER_SHADOW) + t.of(PassId::SHADOW_WIDTH);
    let over_frame = Spread::of(times.iter().filter(|_| shadowed).map(|t| maps_of(t) / t.frame));
    let shells = median(PassId::SHELLS);
    let ratio = (yardstick.median > 0.0).then(|| shells / yardstick.median);
    let gpu_bytes = model.gpu_bytes() + scene.shadow_bytes() + drawn.report().target_bytes + scene.copies_bytes();
    let passes = measured().map(|id| PassTime { name: id.name(), median_ms: median(id), fragments: count(id) });
    let result = BenchResult {
        adapter: &scene.gpu.info.name,
        driver: format!("{} {}", scene.gpu.info.driver, scene.gpu.info.driver_info),
        frames: times.len(),
        timing: clock,
        frame_ms: frame,
        passes: passes.collect(),
        unshadowed_frame_ms: unshadowed,
        frame_over_unshadowed: shadowed.then_some(over_unshadowed.median),
        shadow_maps_ms: maps_ms,
        shadow_maps_over_frame: shadowed.then_some(over_frame.median),
        yardstick_ms: yardstick,
        shells_over_yardstick: ratio,
        upload_ms: scene.upload.as_secs_f64() * 1e3,
        pipelines_ms: scene.compile.as_secs_f64() * 1e3,
        gpu_bytes,
        layers,
        instances: scene.instances.len(),
        drawn_layers: drawn.report().instances.iter().map(|d| u64::from(d.layers)).sum(),
        detail: detail(drawn),
        triangles,
    };
    let mut text = String::new();
    let mut line = |args: std::fmt::Arguments<'_>| {
        let _ = writeln!(text, "{args}");
    };
    line(format_args!("{} ({clock:?}, {} frames)", scene.gpu.info.name, times.len()));
    line(format_args!("{triangles} triangles, {layers} layers, {} on the device", human_bytes(gpu_bytes)));
    for pass in drawn.report().passes.iter().filter(|p| p.name == PassId::SHELLS.name()) {
        line(format_args!("{}: {}", pass.name, pass.reason));
    }
    line(format_args!("frame           {:9.2} ms  ({:.2} .. {:.2})", frame.median, frame.min, frame.max));
    for id in measured() {
        let count = count(id).map_or(String::new(), |n| format!("  {n} fragments"));
        line(format_args!("  {:13} {:9.2} ms{count}", id.name(), median(id)));
    }
    if shadowed {
        let (still, maps) = (over_unshadowed.median, over_frame.median);
        line(format_args!(
            "with shadows, a frame takes {still:.2} times as long as without ({:.2} ms) while the light is static",
            unshadowed.median
        ));
        line(format_args!("redrawing the shadow maps takes {maps_ms:.2} ms, {maps:.2} times a frame with shadows"));
    }
    if let Some(ratio) = ratio {
        line(format_args!(
            "shells take {ratio:.2} times as long as the same layers with one texture read and no lighting"
        ));
    }
    line(format_args!("upload {:.1} ms, pipelines {:.1} ms", result.upload_ms, result.pipelines_ms));
    output.result(&text, &result)
}
