//! Creates a [`Stage`] from the arguments.

use super::exit::Failure;
use super::view::PictureView;
use image::RgbaImage;
use pelage_runtime::{Frame, InstanceDetail};
use pelage_stage::{Cast, Gpu, NamedPackage, Stage, StageError};
use serde::{Deserialize, Serialize};

/// Creates a stage with one or more copies of a package's model, on the device that `open_gpu` returns.
pub fn stage_of(
    file: &NamedPackage<'_>,
    view: &PictureView,
    open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
) -> Result<Stage, StageError> {
    stage(&crowd(file, view)?, view, open_gpu)
}

/// Creates a stage with the given models and instances, on the device that `open_gpu` returns.
pub fn stage(
    cast: &Cast<'_>,
    view: &PictureView,
    open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
) -> Result<Stage, StageError> {
    let view = view.resolved(cast.has_fibres()?);
    Stage::new(cast, &view.look.picture(), view.frame_params(), view.time_s, open_gpu)
}

/// Reads the pixels of the canvas, which are sRGB-encoded with straight alpha.
pub fn pixels(stage: &Stage) -> Result<RgbaImage, Failure> {
    let (width, height) = stage.canvas.size();
    RgbaImage::from_raw(width, height, stage.canvas.read(&stage.gpu)?)
        .ok_or_else(|| StageError::Device("the canvas was read back incompletely".into()).into())
}

/// Creates the cast for one or more copies of a package, with the clip and camera of `view`. Without a camera, all
/// copies are framed.
pub fn crowd<'a>(file: &'a NamedPackage<'a>, view: &PictureView) -> Result<Cast<'a>, StageError> {
    let package = file.open()?;
    let framing = (&view.framing, view.look.aspect());
    let crowd = Cast::crowd(file, package, view.clip.as_deref(), view.crowd, view.camera, framing)?;
    let crowd = match &view.blend {
        Some(blend) => crowd.fading_to(&blend.clip, blend.share)?,
        None => crowd,
    };
    view.morphs.iter().try_fold(crowd, |crowd, morph| crowd.morphing(&morph.target, morph.weight))
}

/// Level of detail of the fur of a copy of the model.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FurDetail {
    /// Index into the package's levels of detail.
    level: u32,
    /// Progress of the fade to the next level, 0 to 1.
    fade: f32,
    /// Number of layers drawn, skin excluded.
    layers: u32,
    /// Number of layers in the package, skin excluded.
    of_layers: u32,
    /// Number of triangles drawn.
    triangles: u32,
    /// Opacity of the fins, 0 to 1.
    fins: f32,
    /// Opacity of the far layer, which replaces the fur at a distance, 0 to 1.
    coat: f32,
    /// Height of the fur on screen with `--detail auto`, pixels; null if the eye is inside the fur.
    fur_px: Option<f32>,
}

/// Returns the level of detail of the fur of each copy.
pub fn detail(frame: &Frame) -> Vec<FurDetail> {
    let of = |detail: &InstanceDetail| {
        let InstanceDetail { level, fade, layers, of_layers, triangles, fins, coat, fur_px, .. } = *detail;
        let fur_px = fur_px.filter(|px| px.is_finite());
        FurDetail { level, fade, layers, of_layers, triangles, fins, coat, fur_px }
    };
    frame.report().instances.iter().map(of).collect()
}
