//! A cast on a canvas.

use crate::cast::Actor;
use crate::{Canvas, CanvasOptions, Cast, Gpu, NamedPackage, Shot, StageError, Viewpoint};
use pelage_formats::meaning::srgb_to_linear;
use pelage_formats::{ClipLayer, Package, Shading};
use pelage_runtime::glam::Vec3;
use pelage_runtime::{
    Camera, Frame, FrameParams, HairMotionParams, Hooks, Instance, Model, Motion, PassId, Projection, Renderer,
    RuntimeError, SelfShadow, ShadowMaps, Style, StyleKind, wgpu,
};
use std::time::Duration;
use web_time::Instant;

/// What a cast is drawn on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height, pixels.
    pub size: (u32, u32),
    /// Samples per pixel, 1 or 4.
    pub samples: u32,
    /// What is behind everything: sRGB-encoded, or `None` for transparent.
    pub background: Option<[u8; 3]>,
}

impl Picture {
    /// Width over height.
    pub fn aspect(&self) -> f32 {
        self.size.0 as f32 / self.size.1 as f32
    }
}

/// Everything that is made once for a view of a cast.
#[derive(Debug)]
pub struct Stage {
    /// The device.
    pub gpu: Gpu,
    /// What is drawn on.
    pub canvas: Canvas,
    /// Camera, light and style. The camera is that of the time that was set last.
    pub params: FrameParams,
    /// The models, and other copies of them: at least one.
    pub instances: Vec<Instance>,
    /// Time from the opened packages to their textures and buffers on the device.
    pub upload: Duration,
    /// Time to compile the pipelines of the style.
    pub compile: Duration,
    renderer: Renderer,
    shadow_bytes: u64,
    clear: wgpu::Color,
    /// Of `instances`, in order.
    actors: Vec<Actor>,
    shot: Shot,
    aspect: f32,
}

impl Stage {
    /// Loads the packages of `cast` and sets them up as `params` say, at `time_s`, on the device that `open_gpu` gives. Camera and viewport of
    /// `params` are replaced by those of `cast` and `picture`.
    ///
    /// The device comes last, so that what is wrong with a package is said on machines without one, too.
    ///
    /// # Errors
    ///
    /// [`StageError::Package`] and [`StageError::Input`] for a package that is damaged or cannot be drawn so, [`StageError::Asked`] for a cast
    /// without a model or with one of a package that it has not, [`StageError::Asked`] and [`StageError::Params`] for what the device cannot
    /// do, [`StageError::NoAdapter`] without one.
    pub fn new(
        cast: &Cast<'_>,
        picture: &Picture,
        params: FrameParams,
        time_s: f32,
        open_gpu: impl FnOnce() -> Result<Gpu, StageError>,
    ) -> Result<Self, StageError> {
        check(cast, params.style.kind())?;
        let gpu = open_gpu()?;
        fits(&gpu, picture.size)?;
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
        };
        stage.load(cast, time_s)?;
        Ok(stage)
    }

    /// Shows another cast, from its own camera, and keeps device, look and whatever pipelines it can use. Where it fails, what was shown
    /// before still is.
    ///
    /// # Errors
    ///
    /// As [`Self::new`].
    pub fn recast(&mut self, cast: &Cast<'_>, time_s: f32) -> Result<(), StageError> {
        check(cast, self.params.style.kind())?;
        self.load(cast, time_s)
    }

    /// Draws another picture with another look, at `time_s` from the camera that there is. Where it fails, the look before stays.
    ///
    /// # Errors
    ///
    /// [`StageError::Asked`] for a picture that the device cannot draw, and for one of other samples per pixel, which takes a new stage.
    pub fn relook(&mut self, picture: &Picture, params: FrameParams, time_s: f32) -> Result<(), StageError> {
        fits(&self.gpu, picture.size)?;
        let options = self.renderer.options();
        if picture.samples != options.sample_count {
            let reason = format!(
                "found {}, expected the {} that the stage was made with",
                picture.samples, options.sample_count
            );
            return Err(StageError::Asked { what: "samples".into(), reason });
        }
        if picture.size != self.canvas.size() {
            self.canvas = Canvas::new(&self.gpu, picture.size, &options.into());
        }
        self.clear = clear_color(picture);
        let (width, height) = picture.size;
        self.aspect = picture.aspect();
        self.params = params.with(|params| {
            params.camera = camera(&self.shot.at(time_s), self.aspect);
            params.viewport = [width, height];
        });
        Ok(())
    }

    /// Gives all models other constants of the lighting equation than their packages have; everything else stays as it is on the device.
    ///
    /// # Errors
    ///
    /// [`StageError::Params`] for constants out of their ranges; the models stay as they were.
    pub fn reshade(&mut self, shading: Shading) -> Result<(), StageError> {
        let reshaded = self.instances.iter().map(|instance| instance.model.with_shading(shading));
        let models: Vec<Model> =
            reshaded.collect::<Result<_, _>>().map_err(|error| StageError::Params(error.to_string()))?;
        self.instances.iter_mut().zip(models).for_each(|(instance, model)| instance.model = model);
        Ok(())
    }

    /// Loads the models of a cast that was checked, and shows it.
    fn load(&mut self, cast: &Cast<'_>, time_s: f32) -> Result<(), StageError> {
        let start = Instant::now();
        let loaded = cast.packages.iter().map(|(file, package)| {
            let model = self.renderer.load(package);
            model.map_err(|error| refused(file, error))
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
        let of_actors = cast.actors.iter().map(|actor| &models[actor.package]);
        let instance = |(owner, (model, actor)): (u64, (&Model, &Actor))| {
            Instance::new(owner, model).morphing(actor.morphs.clone())
        };
        self.instances = (0..).zip(of_actors.zip(&cast.actors)).map(instance).collect();
        self.actors = cast.actors.clone();
        self.shot = cast.camera.clone();
        self.set_time(time_s);
        Ok(())
    }

    /// Places and poses the models and the camera as they are at that time.
    pub fn set_time(&mut self, time_s: f32) {
        self.params.hair_motion = None;
        self.play(time_s);
        self.params.camera = camera(&self.shot.at(time_s), self.aspect);
    }

    /// Goes on to that time: as [`Stage::set_time`], and hair lives as `motion` says, from the moment that the clock had to the one that it has. With
    /// [`Stage::set_time`], and where `motion` is `None`, hair is as it was groomed.
    ///
    /// * `clock_s`: seconds; it goes on where a clip begins anew
    pub fn advance(&mut self, time_s: f32, clock_s: f64, motion: Option<HairMotionParams>) {
        self.set_time(time_s);
        self.live(clock_s, motion);
    }

    /// Has hair live until that moment of the clock, as `motion` says: as [`Stage::advance`] does.
    pub fn live(&mut self, clock_s: f64, motion: Option<HairMotionParams>) {
        (self.params.time_s, self.params.hair_motion) = (clock_s, motion);
    }

    /// Hair begins as it was groomed in the next frame: models are put where they did not go to.
    pub fn cut(&mut self) {
        self.instances.iter_mut().for_each(|instance| instance.cut = instance.cut.wrapping_add(1));
    }

    /// Prepares and submits a frame that nobody looks at: poses and hair are then those of it. It has no shadows, which nobody sees.
    ///
    /// # Errors
    ///
    /// As [`Stage::prepare`].
    pub fn pass_by(&mut self) -> Result<(), StageError> {
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

    /// Plays the clips of the models at that time, and leaves the camera where it is.
    pub fn play(&mut self, time_s: f32) {
        for (instance, actor) in self.instances.iter_mut().zip(&self.actors) {
            instance.transform = actor.transform(time_s);
            instance.motion = motion(actor.layers(time_s));
        }
    }

    /// Looks from there at all times.
    pub fn look_from(&mut self, view: Viewpoint) {
        self.shot = Shot::fixed(view);
        self.params.camera = camera(&view, self.aspect);
    }

    /// Prepares a frame into `encoder`.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<Frame, StageError> {
        self.record(encoder, &mut |_, _| ())
    }

    /// Prepares a frame whose pose and shadow maps are made anew, and calls `mark` after each of the passes that do it.
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
        // The package was loaded in full before, so what fails now is an argument.
        let frame = self
            .renderer
            .prepare_with(encoder, &self.params, &self.instances, hooks)
            .map_err(|error| StageError::Params(error.to_string()))?;
        self.shadow_bytes = frame.shadows().map_or(self.shadow_bytes, ShadowMaps::gpu_bytes);
        Ok(frame)
    }

    /// The model; of several the first.
    pub fn model(&self) -> &Model {
        &self.instances[0].model
    }

    /// Whether any hair may move while time passes: hair on guides, and fur where its skin or the air moves.
    pub fn may_move_hair(&self, motion: &HairMotionParams) -> bool {
        let is_windy = motion.fur > 0.0 && motion.wind.velocity != Vec3::ZERO;
        let moves = |(instance, actor): (&Instance, &Actor)| {
            let leans = motion.fur > 0.0 && instance.model.has_leaning_fur();
            instance.model.has_moving_hair() || leans && (is_windy || actor.moves())
        };
        self.instances.iter().zip(&self.actors).any(moves)
    }

    /// Bytes on the device of what belongs to the models' copies.
    pub fn copies_bytes(&self) -> u64 {
        self.renderer.owners_gpu_bytes()
    }

    /// Bytes of the shadow maps on the device; 0 where no frame had any.
    pub fn shadow_bytes(&self) -> u64 {
        self.shadow_bytes
    }

    /// Begins a pass on the canvas, cleared to the background or going on from the pass before.
    pub fn pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, label: &str, clear: bool) -> wgpu::RenderPass<'e> {
        self.canvas.pass(encoder, label, clear.then_some(self.clear))
    }

    /// Draws one frame and waits for it; returns what was drawn.
    pub fn draw(&mut self) -> Result<Frame, StageError> {
        let mut encoder = self.encoder();
        let frame = self.prepare(&mut encoder)?;
        frame.draw(&mut self.pass(&mut encoder, "frame", true));
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.wait()?;
        Ok(frame)
    }

    /// An empty encoder.
    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("pelage") })
    }
}

/// Layers of a pose as the runtime takes them.
pub(crate) fn motion(layers: Vec<ClipLayer>) -> Motion {
    match layers[..] {
        [] => Motion::Rest,
        [ClipLayer { clip, time_s, share }] if share >= 1.0 => {
            clip.map_or(Motion::Rest, |clip| Motion::Clip { clip, time_s })
        }
        _ => Motion::Blend(layers),
    }
}

/// What is behind everything, linear.
fn clear_color(picture: &Picture) -> wgpu::Color {
    match picture.background {
        Some(rgb) => {
            let [r, g, b] = rgb.map(|byte| f64::from(srgb_to_linear(byte)));
            wgpu::Color { r, g, b, a: 1.0 }
        }
        None => wgpu::Color::TRANSPARENT,
    }
}

/// Fails for a picture that is larger than the device can draw.
fn fits(gpu: &Gpu, (width, height): (u32, u32)) -> Result<(), StageError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width <= limit && height <= limit {
        return Ok(());
    }
    let reason = format!("{} draws at most {limit} pixels a side", gpu.info.name);
    Err(StageError::Asked { what: format!("size {width}x{height}"), reason })
}

/// Fails for a cast that cannot be drawn in that style, as far as its packages say so.
fn check(cast: &Cast<'_>, style: StyleKind) -> Result<(), StageError> {
    check_actors(cast)?;
    for (file, package) in &cast.packages {
        package.mesh().map_err(|error| file.fault(error))?;
        package.animation().map_err(|error| file.fault(error))?;
        if style == StyleKind::Ink {
            has_ink(file, package)?;
        }
    }
    Ok(())
}

/// Fails for a cast that shows nothing, and for an actor without a model.
fn check_actors(cast: &Cast<'_>) -> Result<(), StageError> {
    if cast.actors.is_empty() {
        let reason = "found no copy of a model, expected at least one".into();
        return Err(StageError::Asked { what: "cast".into(), reason });
    }
    let count = cast.packages.len();
    match cast.actors.iter().position(|actor| actor.package >= count) {
        Some(i) => Err(StageError::Asked {
            what: format!("cast, actor {i}"),
            reason: format!(
                "found package {}, expected one below {count}, the number of packages",
                cast.actors[i].package
            ),
        }),
        None => Ok(()),
    }
}

/// Fails for a package that cannot be drawn in ink.
fn has_ink(file: &NamedPackage<'_>, package: &Package<'_>) -> Result<(), StageError> {
    if package.ink().map_err(|error| file.fault(error))?.is_some() {
        return Ok(());
    }
    let reason = "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into();
    Err(StageError::Input { file: file.name.clone(), place: "section INKW, the ink style".into(), reason })
}

/// Who is at fault when the runtime refuses a package.
fn refused(file: &NamedPackage<'_>, error: RuntimeError) -> StageError {
    match error {
        RuntimeError::Package(source) => file.fault(source),
        // Another adapter would do.
        RuntimeError::DeviceLimit { .. } => StageError::NoAdapter(format!("{}: {error}", file.name)),
        RuntimeError::Content { what, reason, .. } => {
            StageError::Input { file: file.name.clone(), place: what, reason }
        }
        other => StageError::Internal(other.to_string()),
    }
}

/// The runtime's camera at a viewpoint, for a picture of that width over height and reversed depth without a far plane.
pub fn camera(view: &Viewpoint, aspect: f32) -> Camera {
    // With reversed depth only the near plane costs precision; a thousandth of the distance keeps close-ups whole.
    let near_m = (view.eye.distance(view.target) * 1e-3).max(1e-6);
    let fov_y_rad = view.fov_deg.to_radians();
    let projection = Projection::Perspective { fov_y_rad, aspect, near_m, far_m: f32::INFINITY };
    Camera::look_at(view.eye, view.target, projection)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;
    use crate::Look;
    use pelage_formats::{Manifest, PackageWriter};

    #[test]
    fn a_cast_without_its_models_is_refused_before_a_device_is_opened() {
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
        assert!(matches!(error, StageError::Asked { .. }) && error.to_string().contains("at least one"), "{error}");
        let mut cast = crowd(3);
        cast.actors[1].package = 1;
        let error = refused(&cast);
        assert!(matches!(error, StageError::Asked { .. }), "{error}");
        assert_eq!(error.to_string(), "cast, actor 1: found package 1, expected one below 1, the number of packages");
        assert!(matches!(refused(&crowd(3)), StageError::NoAdapter(_)));
    }
}
