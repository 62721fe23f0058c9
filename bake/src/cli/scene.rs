//! Packages on a canvas: what `render`, `bench` and `demo` draw.

use super::cast::{Actor, Cast, Shot};
use super::exit::Failure;
use super::gpu::{COLOR_FORMAT, Canvas, DEPTH_FORMAT, Gpu};
use super::package_file::PackageFile;
use super::view::View;
use super::view_args::DetailArg;
use glam::Vec3;
use pelage_bake::BakeError;
use pelage_formats::Package;
use pelage_formats::meaning::srgb_to_linear;
use pelage_runtime::{
    Camera, Detail, Frame, FrameParams, FurParams, Hooks, Instance, InstanceDetail, Model, PassId, Projection,
    Renderer, RendererOptions, RuntimeError, ShadowMaps, Style, StyleKind, wgpu,
};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Everything that is made once for a view of a cast.
#[derive(Debug)]
pub struct Scene {
    /// The device.
    pub gpu: Gpu,
    /// What is drawn on.
    pub canvas: Canvas,
    /// Camera, light and style.
    pub params: FrameParams,
    /// The models, and other copies of them: at least one.
    pub instances: Vec<Instance>,
    /// Time from the opened packages to their textures and buffers on the device.
    pub upload: Duration,
    /// Time to compile the pipelines of the style.
    pub compile: Duration,
    renderer: Renderer,
    shadow_bytes: u64,
    clear: [f64; 4],
    /// Of `instances`, in order.
    actors: Vec<Actor>,
    shot: Shot,
    aspect: f32,
}

impl Scene {
    /// The model of the package in `file`, or a crowd of it, as [`Self::of`] sets it up.
    pub fn new(
        file: &PackageFile,
        view: &View,
        open_gpu: impl FnOnce() -> Result<Gpu, Failure>,
    ) -> Result<Self, Failure> {
        Self::of(&Cast::crowd(file, view)?, view, open_gpu)
    }

    /// Loads the packages of `cast` and sets up `view` on the device that `open_gpu` gives.
    ///
    /// The device comes last, so that what is wrong with a package is said on machines without one, too.
    pub fn of(cast: &Cast<'_>, view: &View, open_gpu: impl FnOnce() -> Result<Gpu, Failure>) -> Result<Self, Failure> {
        let packages =
            cast.packages.iter().map(|file| Ok((*file, file.open()?))).collect::<Result<Vec<_>, Failure>>()?;
        if view.style == StyleKind::Ink {
            packages.iter().try_for_each(|(file, package)| has_ink(file, package))?;
        }
        let gpu = open_gpu()?;
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = view.size;
        if width > limit || height > limit {
            let name = &gpu.info.name;
            return Err(Failure::Usage(format!("--size {width}x{height}: {name} draws at most {limit} pixels a side")));
        }
        let options = RendererOptions {
            color_format: COLOR_FORMAT,
            depth_format: DEPTH_FORMAT,
            sample_count: view.samples,
            // Precision is spread evenly over distance, so near shells of a far camera do not fight.
            reversed_depth: true,
            ..RendererOptions::default()
        };
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &options);
        let mut renderer = renderer.map_err(|error| BakeError::Internal(error.to_string()))?;
        let start = Instant::now();
        let mut models = Vec::new();
        for (file, package) in &packages {
            let model = renderer.load(package);
            models.push(model.map_err(|error| runtime_failure(file, error))?);
        }
        gpu.queue.submit([]);
        gpu.wait()?;
        let upload = start.elapsed();

        let aspect = width as f32 / height as f32;
        let params = frame_params(view, look(cast.camera.at(view.time_s), aspect));
        let start = Instant::now();
        let compiled = models.iter().try_for_each(|model| renderer.prepare_pipelines(model, &params));
        compiled.map_err(|error| Failure::Usage(error.to_string()))?;
        let compile = start.elapsed();
        let clear = match view.background {
            Some(rgb) => {
                let [r, g, b] = rgb.map(|byte| f64::from(srgb_to_linear(byte)));
                [r, g, b, 1.0]
            }
            None => [0.0; 4],
        };
        let models = cast.actors.iter().filter_map(|actor| models.get(actor.package));
        let instances: Vec<_> = (0..).zip(models).map(|(owner, model)| Instance::new(owner, model)).collect();
        if instances.is_empty() {
            return Err(BakeError::Internal("a scene without a model".into()).into());
        }
        let mut scene = Self {
            instances,
            canvas: Canvas::new(&gpu, width, height, view.samples),
            gpu,
            params,
            upload,
            compile,
            renderer,
            shadow_bytes: 0,
            clear,
            actors: cast.actors.clone(),
            shot: cast.camera.clone(),
            aspect,
        };
        scene.set_time(view.time_s);
        Ok(scene)
    }

    /// Places and poses the models and the camera as they are at that time.
    pub fn set_time(&mut self, time_s: f32) {
        for (instance, actor) in self.instances.iter_mut().zip(&self.actors) {
            instance.transform = actor.place.transform(time_s);
            if let Some(clip) = &actor.clip {
                instance.motion = clip.motion(time_s);
            }
        }
        self.params.camera = look(self.shot.at(time_s), self.aspect);
    }

    /// Looks from the camera of `view`, which names one.
    pub fn look_from(&mut self, view: &View) {
        if let Some(camera) = view.camera {
            self.shot = Shot::fixed(camera);
            self.params.camera = look(camera, self.aspect);
        }
    }

    /// Prepares a frame into `encoder`.
    pub fn prepare(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<Frame, Failure> {
        self.record(encoder, &mut |_, _| ())
    }

    /// Prepares a frame whose pose and shadow maps are made anew, and calls `mark` after each of the passes that do it.
    pub fn prepare_marked(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, Failure> {
        self.renderer.invalidate();
        self.record(encoder, mark)
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, Failure> {
        let hooks = Hooks::default().mark(mark);
        // The package was loaded in full before, so what fails now is an argument.
        let frame = self
            .renderer
            .prepare_with(encoder, &self.params, &self.instances, hooks)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        self.shadow_bytes = frame.shadows().map_or(self.shadow_bytes, ShadowMaps::gpu_bytes);
        Ok(frame)
    }

    /// The model; of several the first.
    pub fn model(&self) -> &Model {
        &self.instances[0].model
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
        self.canvas.pass(encoder, label, clear.then_some(self.clear), true)
    }

    /// Draws one frame and waits for it; returns what was drawn.
    pub fn draw(&mut self) -> Result<Frame, Failure> {
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

/// Fails for a package that cannot be drawn in ink.
fn has_ink(file: &PackageFile, package: &Package<'_>) -> Result<(), Failure> {
    if package.ink().map_err(|error| file.fault(error))?.is_some() {
        return Ok(());
    }
    let reason = "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into();
    Err(BakeError::Input { file: file.name.clone(), place: "section INKW, the ink style".into(), reason }.into())
}

/// Who is at fault when the runtime refuses a package.
fn runtime_failure(file: &PackageFile, error: RuntimeError) -> Failure {
    match error {
        RuntimeError::Package(source) => file.fault(source),
        // Another adapter, or other texture formats, would do.
        RuntimeError::MissingFeature { .. } | RuntimeError::DeviceLimit { .. } => {
            Failure::NoAdapter(format!("{}: {error}", file.name))
        }
        RuntimeError::Content { what, reason, .. } => {
            BakeError::Input { file: file.name.clone(), place: what, reason }.into()
        }
        other => BakeError::Internal(other.to_string()).into(),
    }
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

fn look((eye, target, fov_deg): (Vec3, Vec3, f32), aspect: f32) -> Camera {
    // With reversed depth only the near plane costs precision; a thousandth of the distance keeps close-ups whole.
    let near_m = (eye.distance(target) * 1e-3).max(1e-6);
    let projection = Projection::Perspective { fov_y_rad: fov_deg.to_radians(), aspect, near_m, far_m: f32::INFINITY };
    Camera::look_at(eye, target, projection)
}

/// What the runtime is told of `view`.
fn frame_params(view: &View, camera: Camera) -> FrameParams {
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
