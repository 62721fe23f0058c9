//! A package on a canvas: what `render`, `bench` and `demo` draw.

use super::exit::Failure;
use super::framing;
use super::gpu::{COLOR_FORMAT, Canvas, DEPTH_FORMAT, Gpu};
use super::package_file::PackageFile;
use super::view_args::{Background, DetailArg, LightingArg, Penumbra, Slant, StyleArg, Switch, ViewArgs};
use glam::{Mat4, Vec3};
use pelage_bake::BakeError;
use pelage_bake::mesh::blend;
use pelage_bake::textures::srgb_to_linear;
use pelage_formats::{Animation, GeometryVertex, Manifest, Package, Pose};
use pelage_runtime::{
    Camera, Detail, Frame, FrameParams, Instance, InstanceDetail, Light, Lighting, Model, Motion, PassId, PenumbraForm,
    Projection, Renderer, RendererOptions, RuntimeError, ShadowMaps, ShadowParams, SlantForm, Style, wgpu,
};
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// How a package is looked at; what the arguments that `render` and `bench` share come to.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Width and height of the picture, pixels.
    pub size: (u32, u32),
    /// Samples per pixel, 1 or 4.
    pub samples: u32,
    /// With fur or without.
    pub style: Style,
    /// Eye, target and vertical field of view in degrees; `None` frames the model from its front left.
    pub camera: Option<(Vec3, Vec3, f32)>,
    /// The key light.
    pub light: Light,
    /// Name of the clip; `None` shows the rest pose.
    pub clip: Option<String>,
    /// Moment of the clip, seconds; clips loop.
    pub time_s: f32,
    /// Layers to draw; `None` for as many as were baked.
    pub layers: Option<u32>,
    /// What the slant of the look does to the opacity of a layer.
    pub slant: SlantForm,
    /// How much of the fur is drawn where it is small.
    pub detail: DetailArg,
    /// Copies of the model, at least 1.
    pub crowd: u32,
    /// Whether fins are drawn where the package has them.
    pub fins: bool,
    /// Lights without shadow.
    pub fill_lights: Vec<Light>,
    /// Where the key light is computed.
    pub lighting: Lighting,
    /// Terms of Yang 2006, eq. (3).
    pub terms: Terms,
    /// How the key light's shadows are made.
    pub shadows: ShadowParams,
    /// sRGB-encoded, or `None` for transparent.
    pub background: Option<[u8; 3]>,
}

/// Which terms of Yang 2006, eq. (3) are taken into account.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// γ: ambient light fades towards the skin.
    pub ambient_attenuation: bool,
    /// t: hair shadows hair.
    pub self_shadow: bool,
    /// Attenu_Back: the light ends behind the body.
    pub back_attenuation: bool,
    /// Attenu_Shadow: things throw soft shadows.
    pub soft_shadow: bool,
}

impl Default for View {
    fn default() -> Self {
        Self {
            size: (834, 424),
            samples: 1,
            style: Style::Fur,
            camera: None,
            light: distant(framing::TOWARDS_LIGHT, 1.0),
            clip: None,
            time_s: 0.0,
            layers: None,
            slant: SlantForm::default(),
            detail: DetailArg::Full,
            crowd: 1,
            fins: true,
            fill_lights: Vec::new(),
            lighting: Lighting::Pixel,
            terms: Terms { ambient_attenuation: true, self_shadow: true, back_attenuation: true, soft_shadow: true },
            shadows: ShadowParams::default(),
            background: None,
        }
    }
}

impl TryFrom<&ViewArgs> for View {
    type Error = Failure;

    fn try_from(args: &ViewArgs) -> Result<Self, Failure> {
        args.check()?;
        let defaults = Self::default();
        let light = match (args.light, args.point_light) {
            (Some(direction), _) => distant(direction.0, 1.0),
            (None, Some(position)) => Light::Point { position: position.0, color: Vec3::ONE },
            (None, None) => defaults.light,
        };
        Ok(Self {
            size: (args.size.width, args.size.height),
            style: if args.style == StyleArg::Bare { Style::Bare } else { Style::Fur },
            camera: args.camera.map(|c| (c.eye, c.target, c.fov_deg)),
            light,
            clip: args.clip.clone(),
            time_s: args.time,
            layers: args.layers,
            slant: slant(args.view_slant),
            detail: args.detail,
            crowd: args.crowd,
            fins: args.fins != Some(Switch::Off),
            fill_lights: args.fill_light.iter().map(|f| distant(f.direction, f.strength)).collect(),
            terms: Terms {
                ambient_attenuation: args.ambient_attenuation == Switch::On,
                self_shadow: args.self_shadow == Switch::On,
                back_attenuation: args.back_attenuation == Switch::On,
                soft_shadow: args.soft_shadow == Switch::On,
            },
            shadows: ShadowParams {
                map_size: args.shadow_map,
                map_layers: args.shadow_layers,
                density: args.shadow_density,
                slant: slant(args.slant),
                penumbra: args.penumbra,
                penumbra_form: match args.penumbra_form {
                    Penumbra::Centred => PenumbraForm::Centred,
                    Penumbra::Inner => PenumbraForm::Inner,
                },
                shrink: args.shadow_shrink,
            },
            lighting: match args.lighting {
                LightingArg::Pixel => Lighting::Pixel,
                LightingArg::Vertex => Lighting::Vertex,
            },
            background: match args.background {
                Background::Transparent => None,
                Background::Color(rgb) => Some(rgb),
            },
            ..defaults
        })
    }
}

fn slant(slant: Slant) -> SlantForm {
    match slant {
        Slant::Corrected => SlantForm::Corrected,
        Slant::Printed => SlantForm::Printed,
    }
}

fn distant(towards_light: Vec3, strength: f32) -> Light {
    Light::Directional { towards_light, color: Vec3::splat(strength) }
}

/// Everything that is made once for a view of a package.
#[derive(Debug)]
pub struct Scene {
    /// The device.
    pub gpu: Gpu,
    /// What is drawn on.
    pub canvas: Canvas,
    /// Camera, light and style.
    pub params: FrameParams,
    /// The model.
    pub instance: Instance,
    /// The other copies of a crowd.
    pub others: Vec<Instance>,
    /// Time from the opened package to its textures and buffers on the device.
    pub upload: Duration,
    /// Time to compile the pipelines of the style.
    pub compile: Duration,
    renderer: Renderer,
    shadow_bytes: u64,
    clear: [f64; 4],
    clip: Option<(usize, f32)>,
}

impl Scene {
    /// Opens and loads the package in `file` and sets up `view` on the device that `open_gpu` gives.
    ///
    /// The device comes last, so that what is wrong with the package is said on machines without one, too.
    pub fn new(
        file: &PackageFile,
        view: &View,
        open_gpu: impl FnOnce() -> Result<Gpu, Failure>,
    ) -> Result<Self, Failure> {
        let package = &file.open()?;
        let clip = find_clip(file, package, view.clip.as_deref())?;
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
        let fault = |error| runtime_failure(file, error);
        let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &options).map_err(fault)?;
        let start = Instant::now();
        let model = renderer.load(&gpu.device, &gpu.queue, package).map_err(fault)?;
        gpu.queue.submit([]);
        gpu.wait()?;
        let upload = start.elapsed();

        let canvas = Canvas::new(&gpu, width, height, view.samples);
        let points = rest_points(file, package, model.skeleton())?;
        let camera = camera_of(view, &points, package.manifest().fur.height_m);
        let mut params = FrameParams::new(look(camera, view));
        params.light = view.light;
        params.style = view.style;
        params.layers = view.layers;
        params.slant = view.slant;
        params.detail = match view.detail {
            DetailArg::Full => Detail::Full,
            DetailArg::Auto => Detail::Auto { target_height_px: height as f32, bias: 1.0 },
            DetailArg::Level(level) => Detail::Level(level),
        };
        params.fins = view.fins;
        params.fill_lights.clone_from(&view.fill_lights);
        params.lighting = view.lighting;
        params.self_shadow = view.terms.self_shadow;
        params.soft_shadow = view.terms.soft_shadow;
        params.ambient_attenuation = view.terms.ambient_attenuation;
        params.back_attenuation = view.terms.back_attenuation;
        params.shadows = view.shadows;
        let start = Instant::now();
        renderer.prepare_pipelines(&gpu.device, &model, &params);
        let compile = start.elapsed();
        let clear = match view.background {
            Some(rgb) => {
                let [r, g, b] = rgb.map(|byte| f64::from(srgb_to_linear(byte)));
                [r, g, b, 1.0]
            }
            None => [0.0; 4],
        };
        let mut scene = Self {
            instance: Instance::new(&model),
            others: crowd(&model, view.crowd),
            gpu,
            canvas,
            params,
            upload,
            compile,
            renderer,
            shadow_bytes: 0,
            clear,
            clip,
        };
        scene.set_time(view.time_s);
        Ok(scene)
    }

    /// Poses the model at a moment of the clip; times beyond its end go round.
    pub fn set_time(&mut self, time_s: f32) {
        if let Some((clip, duration_s)) = self.clip {
            for instance in std::iter::once(&mut self.instance).chain(&mut self.others) {
                instance.motion = Motion::Clip { clip, time_s: within(time_s, duration_s) };
            }
        }
    }

    /// Looks at the model from the camera of `view`, which names one.
    pub fn look_from(&mut self, view: &View) {
        if let Some(camera) = view.camera {
            self.params.camera = look(camera, view);
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
        self.renderer.invalidate_shadows();
        self.instance.invalidate();
        self.others.iter_mut().for_each(Instance::invalidate);
        self.record(encoder, mark)
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, Failure> {
        let instances: &mut Vec<_> = &mut std::iter::once(&mut self.instance).chain(&mut self.others).collect();
        // The package was loaded in full before, so what fails now is an argument.
        let frame = self
            .renderer
            .prepare_marked(&self.gpu.device, encoder, &self.params, instances, None, mark)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        self.shadow_bytes = frame.shadows().map_or(self.shadow_bytes, ShadowMaps::gpu_bytes);
        Ok(frame)
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

/// A time in a clip that loops.
pub fn within(time_s: f32, duration_s: f32) -> f32 {
    let inside = (0.0..=duration_s).contains(&time_s) || duration_s <= 0.0;
    if inside { time_s } else { time_s.rem_euclid(duration_s) }
}

/// Index and length of the named clip.
pub fn find_clip(
    file: &PackageFile,
    package: &Package<'_>,
    name: Option<&str>,
) -> Result<Option<(usize, f32)>, Failure> {
    let Some(name) = name else { return Ok(None) };
    let clips = package.animation().map_err(|e| file.fault(e))?.unwrap_or_default().clips;
    if let Some(index) = clips.iter().position(|clip| clip.name == name) {
        return Ok(Some((index, clips[index].duration_s)));
    }
    let names: Vec<_> = clips.iter().map(|c| c.name.as_str()).collect();
    let has = if names.is_empty() { "no animation".into() } else { format!("the clips {}", names.join(", ")) };
    Err(Failure::Usage(format!("--clip {name}: no such clip; {} has {has}", file.name)))
}

/// Where the copies of a crowd stand: the first where the model is, the others in rows beside and behind it, metres.
fn places(manifest: &Manifest, crowd: u32) -> Vec<Vec3> {
    let b = &manifest.bounds;
    let fur_m = 2.0 * manifest.fur.height_m;
    let [width, _, depth] = std::array::from_fn(|axis| 1.1 * (b.max[axis] - b.min[axis] + fur_m));
    let columns = f64::from(crowd).sqrt().ceil() as u32;
    let place = |i: u32| Vec3::new((i % columns) as f32 * width, 0.0, -((i / columns) as f32) * depth);
    (0..crowd).map(place).collect()
}

/// The copies of a crowd besides the first, farthest last.
fn crowd(model: &Model, crowd: u32) -> Vec<Instance> {
    let places = places(model.manifest(), crowd);
    let instance = |place: &Vec3| {
        let mut instance = Instance::new(model);
        instance.transform = Mat4::from_translation(*place);
        instance
    };
    places.iter().skip(1).map(instance).collect()
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

/// The places of a package's vertices at rest, by which the default camera frames it; those of all copies of a crowd.
pub fn rest_points(
    file: &PackageFile,
    package: &Package<'_>,
    skeleton: Option<&Animation>,
) -> Result<Vec<Vec3>, Failure> {
    let mesh = package.mesh().map_err(|error| file.fault(error))?;
    let mut pose = Pose::default();
    if let Some(skeleton) = skeleton {
        pose.sample(skeleton, None, 0.0);
    }
    Ok(mesh.map_or_else(Vec::new, |mesh| {
        let skin: Vec<_> = mesh.skin().collect();
        let place = |(i, v): (usize, GeometryVertex)| {
            let position = Vec3::from(v.position);
            skin.get(i).map_or(position, |s| blend(&pose, s).transform_point3(position))
        };
        mesh.geometry().enumerate().map(place).collect()
    }))
}

/// Eye, target and height of the view in degrees: the view's own, or those that frame `rest_points` with hair of `height_m`.
pub fn camera_of(view: &View, rest_points: &[Vec3], height_m: f32) -> (Vec3, Vec3, f32) {
    view.camera.unwrap_or_else(|| {
        let aspect = view.size.0 as f32 / view.size.1 as f32;
        let margin_m = if view.style == Style::Fur { height_m } else { 0.0 };
        let (eye, target) = framing::frame(rest_points, margin_m, aspect, framing::TOWARDS_CAMERA);
        (eye, target, framing::FOV_DEG)
    })
}

fn look((eye, target, fov_deg): (Vec3, Vec3, f32), view: &View) -> Camera {
    let aspect = view.size.0 as f32 / view.size.1 as f32;
    // With reversed depth only the near plane costs precision; a thousandth of the distance keeps close-ups whole.
    let near_m = (eye.distance(target) * 1e-3).max(1e-6);
    let projection = Projection::Perspective { fov_y_rad: fov_deg.to_radians(), aspect, near_m, far_m: f32::INFINITY };
    Camera::look_at(eye, target, projection)
}
