//! Stage: draws a cast on a canvas.

use crate::animator::motion;
use crate::cast::Actor;
use crate::ground::{Ground, GroundKind};
use crate::{CameraTrack, Canvas, CanvasOptions, Cast, Gpu, NamedPackage, StageError, Viewpoint};
use pelage_formats::meaning::srgb_to_linear;
use pelage_formats::{Package, Shading};
use pelage_runtime::glam::Vec3;
use pelage_runtime::{
    Camera, Frame, FrameParams, HairMotionParams, Hooks, Instance, Model, PassId, PictureStroke, Projection, Renderer,
    RuntimeError, SelfShadow, ShadowMaps, Style, StyleKind, wgpu,
};
use std::time::Duration;
use web_time::Instant;

/// Settings of the render target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetSettings {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Samples per pixel, 1 or 4.
    pub samples: u32,
    /// Background colour, sRGB-encoded; `None` for transparent.
    pub background: Option<[u8; 3]>,
    /// Ground below the models.
    pub ground: GroundKind,
}

impl TargetSettings {
    /// Returns width divided by height.
    pub fn aspect(&self) -> f32 {
        self.size.0 as f32 / self.size.1 as f32
    }
}

/// GPU state for viewing a cast.
#[derive(Debug)]
pub struct Stage {
    /// Device that draws.
    pub gpu: Gpu,
    /// Render targets.
    pub canvas: Canvas,
    /// Camera, light and style. The camera is that of the most recently set time.
    pub params: FrameParams,
    /// Copies of the models; at least one.
    pub instances: Vec<Instance>,
    /// Time that the upload of the packages to the device took.
    pub upload: Duration,
    /// Time that the compilation of the style's pipelines took.
    pub compile: Duration,
    renderer: Renderer,
    shadow_bytes: u64,
    clear: wgpu::Color,
    /// Actors that `instances` show, in the same order.
    actors: Vec<Actor>,
    shot: CameraTrack,
    aspect: f32,
    ground: Ground,
}

impl Stage {
    /// Loads the packages of `cast` and sets up its models with `params` at `time_s`, on the device returned by
    /// `open_gpu`. Camera and viewport of `params` are replaced by those of `cast` and `picture`.
    ///
    /// The device is opened last, so that faults in a package are also reported on machines without a device.
    ///
    /// # Errors
    ///
    /// * [`StageError::Package`] and [`StageError::Input`] for a package that is damaged or cannot be drawn in this
    ///   style
    /// * [`StageError::Request`] for a cast without actors, or with an actor whose package the cast lacks
    /// * [`StageError::Request`] and [`StageError::Params`] for settings that exceed the device's limits
    /// * [`StageError::NoAdapter`] without a device
    pub fn new(
        cast: &Cast<'_>,
        picture: &TargetSettings,
        params: FrameParams,
        time_s: f32,
        open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
    ) -> Result<Self, StageError> {
        check(cast, params.style.kind())?;
        let gpu = open_gpu()?;
        check_size(&gpu, picture.size)?;
        let options = CanvasOptions { sample_count: picture.samples, ..CanvasOptions::default() };
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &options.renderer());
        let renderer = renderer.map_err(|error| StageError::Internal(error.to_string()))?;
        let mut stage = Self {
            instances: Vec::new(),
            canvas: Canvas::new(&gpu, picture.size, &options),
            gpu,
            params,
            upload: Duration::ZERO,
            compile: Duration::ZERO,
            renderer,
            shadow_bytes: 0,
            clear: clear_color(picture),
            actors: Vec::new(),
            shot: cast.camera.clone(),
            aspect: picture.aspect(),
            ground: Ground::default(),
        };
        stage.ground.kind = picture.ground;
        stage.load(cast, time_s)?;
        Ok(stage)
    }

    /// Shows another cast with its own camera. Keeps the device, the look, and the pipelines that can be reused. On
    /// failure the previous cast stays.
    ///
    /// Fails with the errors of [`Self::new`].
    pub fn set_cast(&mut self, cast: &Cast<'_>, time_s: f32) -> Result<(), StageError> {
        check(cast, self.params.style.kind())?;
        self.load(cast, time_s)
    }

    /// Changes render target and look at `time_s`, with the current camera. On failure the previous look stays.
    ///
    /// Fails with [`StageError::Request`] for a picture that exceeds the device's limits, or for another number of
    /// samples per pixel, which requires a new stage.
    pub fn set_look(&mut self, picture: &TargetSettings, params: FrameParams, time_s: f32) -> Result<(), StageError> {
        check_size(&self.gpu, picture.size)?;
        let options = self.renderer.options();
        if picture.samples != options.sample_count {
            let reason = format!(
                "found {}, expected {}, the number that the stage was created with",
                picture.samples, options.sample_count
            );
            return Err(StageError::Request { what: "samples".into(), reason });
        }
        if picture.size != self.canvas.size() {
            self.canvas = Canvas::new(&self.gpu, picture.size, &options.into());
        }
        self.clear = clear_color(picture);
        self.ground.kind = picture.ground;
        let (width, height) = picture.size;
        self.aspect = picture.aspect();
        self.params = params.with(|params| {
            params.camera = camera(&self.shot.at(time_s), self.aspect);
            params.viewport = [width, height];
        });
        Ok(())
    }

    /// Replaces the constants of the lighting equation in all models. Nothing else on the device changes.
    ///
    /// Fails with [`StageError::Params`] for constants out of range; the models are then unchanged.
    pub fn set_shading(&mut self, shading: Shading) -> Result<(), StageError> {
        let reshaded = self.instances.iter().map(|instance| instance.model.with_shading(shading));
        let models: Vec<Model> =
            reshaded.collect::<Result<_, _>>().map_err(|error| StageError::Params(error.to_string()))?;
        self.instances.iter_mut().zip(models).for_each(|(instance, model)| instance.model = model);
        Ok(())
    }

    /// Loads the models of a cast that was already checked, and shows them.
    fn load(&mut self, cast: &Cast<'_>, time_s: f32) -> Result<(), StageError> {
        let ground = self.ground.below(cast)?;
        let start = Instant::now();
        let loaded = cast.packages.iter().map(|(file, package)| {
            let model = self.renderer.load(package);
            model.map_err(|error| load_error(file, error))
        });
        let models: Vec<Model> = loaded.collect::<Result<_, _>>()?;
        self.gpu.queue.submit([]);
        self.gpu.wait()?;
        self.upload = start.elapsed();

        let (width, height) = self.canvas.size();
        let params = self.params.clone().with(|params| {
            params.camera = camera(&cast.camera.at(time_s), self.aspect);
            params.viewport = [width, height];
        });
        let start = Instant::now();
        let compiled = models.iter().try_for_each(|model| self.renderer.prepare_pipelines(model, &params));
        compiled.map_err(|error| StageError::Params(error.to_string()))?;
        self.compile = start.elapsed();
        for owner in 0..self.instances.len() {
            self.renderer.forget(owner as u64);
        }
        // Maps and bind groups of the models before would keep their memory for as many frames as the renderer keeps
        // unused ones, and a window draws few frames for each change.
        self.renderer.invalidate();
        let of_actors = cast.actors.iter().map(|actor| &models[actor.package]);
        let instance = |(owner, (model, actor)): (u64, (&Model, &Actor))| {
            Instance::new(owner, model).morphing(actor.morphs.clone())
        };
        self.instances = (0..).zip(of_actors.zip(&cast.actors)).map(instance).collect();
        self.ground = ground;
        self.actors = cast.actors.clone();
        self.shot = cast.camera.clone();
        self.set_time(time_s);
        Ok(())
    }

    /// Positions and poses models and camera for `time_s`.
    pub fn set_time(&mut self, time_s: f32) {
        self.params.hair_motion = None;
        self.play(time_s);
        self.params.camera = camera(&self.shot.at(time_s), self.aspect);
    }

    /// Advances to `time_s` as [`Stage::set_time`] does, and moves hair from the previous clock time to `clock_s`. If
    /// `motion` is `None`, and after [`Stage::set_time`], hair is as groomed.
    ///
    /// * `clock_s`: seconds; continues when a clip restarts
    pub fn advance(&mut self, time_s: f32, clock_s: f64, motion: Option<HairMotionParams>) {
        self.set_time(time_s);
        self.advance_hair(clock_s, motion);
    }

    /// Moves hair from the previous clock time to `clock_s`, as [`Stage::advance`] does.
    pub fn advance_hair(&mut self, clock_s: f64, motion: Option<HairMotionParams>) {
        (self.params.time_s, self.params.hair_motion) = (clock_s, motion);
    }

    /// Resets hair to its groomed state in the next frame. Use it when models are teleported.
    pub fn reset_hair(&mut self) {
        self.instances.iter_mut().for_each(|instance| instance.hair_revision = instance.hair_revision.wrapping_add(1));
    }

    /// Prepares and submits a frame without shadows that is not shown, so that poses and hair advance.
    ///
    /// Fails with the errors of [`Stage::prepare`].
    pub fn simulate_frame(&mut self) -> Result<(), StageError> {
        let unlit = self.params.clone().with(|params| {
            params.soft_shadow = false;
            params.style = Style::Fur(params.style.fur().copied().unwrap_or_default());
        });
        let unlit = unlit.with_fur(|fur| fur.self_shadow = SelfShadow::Off);
        let asked = std::mem::replace(&mut self.params, unlit);
        let mut encoder = self.encoder();
        let prepared = self.prepare(&mut encoder);
        self.params = asked;
        prepared?;
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Poses the models by their clips at `time_s`. Does not move the camera.
    pub fn play(&mut self, time_s: f32) {
        for (instance, actor) in self.instances.iter_mut().zip(&self.actors) {
            instance.transform = actor.transform(time_s);
            instance.motion = motion(actor.layers(time_s));
        }
    }

    /// Sets a camera that is the same at all times.
    pub fn look_from(&mut self, view: Viewpoint) {
        self.shot = CameraTrack::fixed(view);
        self.params.camera = camera(&view, self.aspect);
    }

    /// Prepares a frame; records its commands into `encoder`.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<Frame, StageError> {
        self.record(encoder, &mut |_, _| ())
    }

    /// Prepares a frame with recomputed pose and shadow maps. Calls `mark` after each of these passes.
    pub fn prepare_marked(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, StageError> {
        self.renderer.invalidate();
        self.record(encoder, mark)
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, StageError> {
        let hooks = Hooks::default().mark(mark);
        // The package was loaded completely before, so an error now is caused by a parameter.
        let frame = self
            .renderer
            .prepare_with(encoder, &self.params, &self.instances, hooks)
            .map_err(|error| StageError::Params(error.to_string()))?;
        self.shadow_bytes = frame.shadows().map_or(self.shadow_bytes, ShadowMaps::gpu_bytes);
        let options = self.renderer.options().into();
        let posed = self.actors.iter().map(|actor| actor.package).zip(&self.instances);
        self.ground.prepare((&self.gpu, &options), (&self.params, &frame), posed);
        Ok(frame)
    }

    /// Returns the model; if there are several, the first.
    pub fn model(&self) -> &Model {
        &self.instances[0].model
    }

    /// Returns the shader stages of all pipelines compiled so far.
    #[cfg(feature = "study")]
    pub fn shader_variants(&self) -> Vec<pelage_runtime::ShaderVariant> {
        self.renderer.shader_variants()
    }

    /// Returns whether any hair may move over time: guide hair always, fur only if its surface or the air moves.
    pub fn may_move_hair(&self, motion: &HairMotionParams) -> bool {
        let is_windy = motion.fur > 0.0 && motion.wind.velocity != Vec3::ZERO;
        let moves = |(instance, actor): (&Instance, &Actor)| {
            let leans = motion.fur > 0.0 && instance.model.has_leaning_fur();
            instance.model.has_moving_hair() || leans && (is_windy || actor.moves())
        };
        self.instances.iter().zip(&self.actors).any(moves)
    }

    /// Returns the device memory that belongs to the copies of the models, bytes.
    pub fn copies_bytes(&self) -> u64 {
        self.renderer.owners_gpu_bytes()
    }

    /// Returns the device memory of the shadow maps, bytes; 0 if no frame had any.
    pub fn shadow_bytes(&self) -> u64 {
        self.shadow_bytes
    }

    /// Begins a pass on the canvas. With `clear` it is cleared to the background, and the ground of the most recently
    /// prepared frame is drawn; otherwise it keeps the contents of the previous pass.
    pub fn pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, label: &str, clear: bool) -> wgpu::RenderPass<'e> {
        let mut pass = self.canvas.pass(encoder, label, clear.then_some(self.clear));
        if clear {
            self.ground.draw(&mut pass);
        }
        pass
    }

    /// Draws one frame, waits for the device, and returns the frame.
    pub fn draw(&mut self) -> Result<Frame, StageError> {
        let mut encoder = self.encoder();
        let frame = self.prepare(&mut encoder)?;
        frame.draw(&mut self.pass(&mut encoder, "frame", true));
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        Ok(frame)
    }

    /// Reads back the strokes of a frame that was drawn, in the order in which they are painted. Empty unless the frame
    /// is painted with strokes. Blocks until the device has finished, and does nothing in a browser.
    pub fn strokes(&self, frame: &Frame) -> Result<Vec<PictureStroke>, StageError> {
        let contents: Result<Vec<_>, _> = frame.stroke_buffers().into_iter().map(|b| self.gpu.copy_of(b)).collect();
        Ok(frame.strokes(&contents?))
    }

    /// Creates an empty encoder.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("pelage") })
    }
}

/// Returns the background colour, linear.
fn clear_color(picture: &TargetSettings) -> wgpu::Color {
    match picture.background {
        Some(rgb) => {
            let [r, g, b] = rgb.map(|byte| f64::from(srgb_to_linear(byte)));
            wgpu::Color { r, g, b, a: 1.0 }
        }
        None => wgpu::Color::TRANSPARENT,
    }
}

/// Returns an error for a picture larger than the device can draw.
fn check_size(gpu: &Gpu, (width, height): (u32, u32)) -> Result<(), StageError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width <= limit && height <= limit {
        return Ok(());
    }
    let reason = format!("{} draws at most {limit} pixels per side", gpu.info.name);
    Err(StageError::Request { what: format!("size {width}x{height}"), reason })
}

/// Returns an error for a cast that cannot be drawn in that style, judging by its packages alone.
fn check(cast: &Cast<'_>, style: StyleKind) -> Result<(), StageError> {
    check_actors(cast)?;
    for (file, package) in &cast.packages {
        package.mesh().map_err(|error| file.fault(error))?;
        package.animation().map_err(|error| file.fault(error))?;
        if style == StyleKind::Ink {
            require_ink(file, package)?;
        }
    }
    Ok(())
}

fn check_actors(cast: &Cast<'_>) -> Result<(), StageError> {
    if cast.actors.is_empty() {
        let reason = "found no copy of a model, expected at least one".into();
        return Err(StageError::Request { what: "cast".into(), reason });
    }
    let count = cast.packages.len();
    match cast.actors.iter().position(|actor| actor.package >= count) {
        Some(i) => Err(StageError::Request {
            what: format!("cast, actor {i}"),
            reason: format!(
                "found package {}, expected less than {count}, the number of packages",
                cast.actors[i].package
            ),
        }),
        None => Ok(()),
    }
}

fn require_ink(file: &NamedPackage<'_>, package: &Package<'_>) -> Result<(), StageError> {
    if package.ink().map_err(|error| file.fault(error))?.is_some() {
        return Ok(());
    }
    let reason = "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into();
    Err(StageError::Input { file: file.name.clone(), place: "section INKW, the ink style".into(), reason })
}

fn load_error(file: &NamedPackage<'_>, error: RuntimeError) -> StageError {
    match error {
        RuntimeError::Package(source) => file.fault(source),
        // A different adapter may have higher limits.
        RuntimeError::DeviceLimit { .. } => StageError::NoAdapter(format!("{}: {error}", file.name)),
        RuntimeError::Content { what, reason, .. } => {
            StageError::Input { file: file.name.clone(), place: what, reason }
        }
        other => StageError::Internal(other.to_string()),
    }
}

/// Returns the runtime's camera for a viewpoint, with reversed depth and no far plane.
///
/// * `aspect`: width of the picture divided by its height
pub fn camera(view: &Viewpoint, aspect: f32) -> Camera {
    // With reversed depth only the near plane affects precision. At a thousandth of the distance it does not clip
    // close-ups.
    let near_m = (view.eye.distance(view.target) * 1e-3).max(1e-6);
    let fov_y_rad = view.fov_deg.to_radians();
    let projection = Projection::Perspective { fov_y_rad, aspect, near_m, far_m: f32::INFINITY };
    Camera::look_at(view.eye, view.target, projection)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Look;
    use pelage_formats::{Manifest, PackageWriter};

    #[test]
    fn invalid_cast_is_refused_before_opening_a_device() {
        let bytes = PackageWriter::new(Manifest::default()).finish().unwrap();
        let file = NamedPackage::new("a.pelage", bytes);
        let framing = crate::Framing::default();
        let crowd = |copies| Cast::crowd(&file, file.open().unwrap(), None, copies, None, (&framing, 1.0)).unwrap();
        let refused = |cast: &Cast<'_>| {
            let look = Look::default();
            let no_device = || Err(StageError::NoAdapter("asked for one".into()));
            Stage::new(cast, &look.picture(), look.frame_params(), 0.0, no_device).unwrap_err()
        };
        let error = refused(&crowd(0));
        assert!(matches!(error, StageError::Request { .. }) && error.to_string().contains("at least one"), "{error}");
        let mut cast = crowd(3);
        cast.actors[1].package = 1;
        let error = refused(&cast);
        assert!(matches!(error, StageError::Request { .. }), "{error}");
        assert_eq!(error.to_string(), "cast, actor 1: found package 1, expected less than 1, the number of packages");
        assert!(matches!(refused(&crowd(3)), StageError::NoAdapter(_)));
    }
}
