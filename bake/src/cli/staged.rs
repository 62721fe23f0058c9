//! What the arguments come to on a [`Stage`].

use super::exit::Failure;
use super::view::View;
use super::view_args::DetailArg;
use glam::Vec3;
use image::RgbaImage;
use pelage_runtime::{Detail, Frame, FrameParams, FurParams, InstanceDetail, Style, StyleKind};
use pelage_stage::{Cast, Gpu, NamedPackage, Picture, Shot, Stage, StageError, Viewpoint, rest_points};
use serde_json::{Value, json};

/// Any view: the cast has its own.
const ANY_VIEW: Viewpoint = Viewpoint { eye: Vec3::Z, target: Vec3::ZERO, fov_deg: 30.0 };

/// The model of a package, or a crowd of it, on the device that `open_gpu` gives.
pub fn stage_of(
    file: &NamedPackage<'_>,
    view: &View,
    open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
) -> Result<Stage, StageError> {
    stage(&crowd(file, view)?, view, open_gpu)
}

/// A cast on the device that `open_gpu` gives.
pub fn stage(
    cast: &Cast<'_>,
    view: &View,
    open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
) -> Result<Stage, StageError> {
    let picture = Picture { size: view.size, samples: view.samples, background: view.background };
    Stage::new(cast, &picture, frame_params(view), view.time_s, open_gpu)
}

/// The canvas as a picture: sRGB-encoded, straight alpha.
pub fn pixels(stage: &Stage) -> Result<RgbaImage, Failure> {
    let (width, height) = stage.canvas.size();
    RgbaImage::from_raw(width, height, stage.canvas.read(&stage.gpu)?)
        .ok_or_else(|| StageError::Device("the canvas was read back short".into()).into())
}

/// The model of one package, or a crowd of it, at the clip and from the camera of `view`. Without one, the camera frames the first.
pub fn crowd<'a>(file: &'a NamedPackage<'a>, view: &View) -> Result<Cast<'a>, StageError> {
    let package = file.open()?;
    let skeleton = package.animation().map_err(|error| file.fault(error))?;
    let points = rest_points(file, &package, skeleton.as_deref())?;
    let camera = view.viewpoint(&points, package.manifest().fur.height_m);
    Cast::crowd(file, view.clip.as_deref(), view.crowd, Shot::fixed(camera))
}

/// What is drawn of each copy's fur, as JSON.
pub fn detail(frame: &Frame) -> Vec<Value> {
    let of = |d: &InstanceDetail| {
        json!({
            "level": d.level,
            "fade": d.fade,
            "layers": d.layers,
            "of_layers": d.of_layers,
            "fins": d.fins,
            "coat": d.coat,
            // JSON has no infinity: the eye is among the hair.
            "fur_px": d.fur_px.filter(|px| px.is_finite()),
        })
    };
    frame.report().instances.iter().map(of).collect()
}

/// What the runtime is told of `view`.
pub fn frame_params(view: &View) -> FrameParams {
    // The stage sets the camera.
    let camera = pelage_stage::camera(&ANY_VIEW, 1.0);
    let detail = match view.detail {
        DetailArg::Full => Detail::Full,
        DetailArg::Auto => Detail::Auto { bias: 1.0 },
        DetailArg::Level(level) => Detail::Level(level),
    };
    let style = match view.style {
        StyleKind::Bare => Style::Bare,
        StyleKind::Ink => Style::Ink(view.ink.params().with(|ink| ink.fins = view.fins)),
        _ => Style::Fur(FurParams::default().with(|fur| {
            fur.layers = view.layers;
            fur.detail = detail;
            fur.fins = view.fins;
            fur.self_shadow = view.terms.self_shadow;
        })),
    };
    FrameParams::new(camera, [view.size.0, view.size.1]).with(|params| {
        params.light = view.light;
        params.style = style;
        params.fill_lights.clone_from(&view.fill_lights);
        params.soft_shadow = view.terms.soft_shadow;
        params.shadows = view.shadows;
        params.study = view.study;
        params.study.ambient_attenuation = view.terms.ambient_attenuation;
        params.study.back_attenuation = view.terms.back_attenuation;
        view.ink.study(&mut params.study);
    })
}
