//! What is made once per device and set of options: layouts and pipelines.

use crate::passes::ink::{self, InkDraws, InkPipelines};
use crate::passes::key::{SurfaceKey, SurfaceShader};
use crate::passes::shadow_width::FilterPipelines;
use crate::passes::surface::SurfaceLayouts;
use crate::passes::{PassId, fins, layer_shadow, pose, shadow_width, shells, skin};
use crate::shadow::{Casters, ShadowMaps};
use crate::{Camera, Frame, FrameParams, InkParams, Instance, Model, RendererOptions, RuntimeError, frame, model};
use pelage_formats::{Limits, Package};
use std::collections::HashMap;
use std::sync::Arc;

/// Draws models into the application's own render pass. One per device and kind of pass.
#[derive(Debug)]
pub struct Renderer {
    pipelines: Pipelines,
    /// Of the last frame that had shadows.
    shadows: Option<Arc<ShadowMaps>>,
}

impl Renderer {
    /// Checks the options. No pipeline is compiled: that happens when a frame first needs one, or in
    /// [`Renderer::prepare_pipelines`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, options: &RendererOptions) -> Result<Self, RuntimeError> {
        options.check(device)?;
        let pipelines = Pipelines {
            options: options.clone(),
            layouts: SurfaceLayouts::new(device, queue),
            pose: None,
            filter: None,
            ink: None,
            modules: HashMap::new(),
            surfaces: HashMap::new(),
        };
        Ok(Self { pipelines, shadows: None })
    }

    /// The options it was made with.
    pub fn options(&self) -> &RendererOptions {
        &self.pipelines.options
    }

    /// Uploads a package, straight from the slices it borrows; the package's bytes may be dropped afterwards.
    ///
    /// Fails where a section is damaged, a texture needs a feature the device was made without, or something exceeds the
    /// device's limits.
    pub fn load(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        package: &Package<'_>,
    ) -> Result<Model, RuntimeError> {
        model::load(device, queue, &self.pipelines.options, &self.pipelines.layouts, package)
    }

    /// Opens a package with default [`Limits`] and uploads it.
    pub fn load_bytes(&self, device: &wgpu::Device, queue: &wgpu::Queue, bytes: &[u8]) -> Result<Model, RuntimeError> {
        self.load(device, queue, &Package::open(bytes, &Limits::default())?)
    }

    /// Compiles what drawing `model` with `params` needs, so that the first frame does not wait for it. Mirrored instances, and
    /// parameters of another style or with other constants of the lighting equation, may compile more when first drawn.
    pub fn prepare_pipelines(&mut self, device: &wgpu::Device, model: &Model, params: &FrameParams) {
        frame::compile(device, &mut self.pipelines, model, params);
    }

    /// Prepares a frame: compiles missing pipelines, uploads what changed, and records the passes that run before the
    /// application's render pass into `encoder`.
    ///
    /// The encoder must be submitted before, or together with, the pass that the frame is drawn into. Two cameras in one
    /// submission take two frames. Instances are drawn in the order given; where furs overlap in the picture, give the farther
    /// first.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: &mut [&mut Instance],
    ) -> Result<Frame, RuntimeError> {
        self.prepare_marked(device, encoder, params, instances, None, &mut |_, _| ())
    }

    /// [`Self::prepare`] with geometry of the application's own among the shadows.
    pub fn prepare_with_casters(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: &mut [&mut Instance],
        casters: &mut Casters<'_>,
    ) -> Result<Frame, RuntimeError> {
        self.prepare_marked(device, encoder, params, instances, Some(casters), &mut |_, _| ())
    }

    /// [`Self::prepare`] that calls `mark` after each pass it records or skips: how `pelage bench` times them.
    #[doc(hidden)]
    pub fn prepare_marked(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: &mut [&mut Instance],
        casters: Option<&mut Casters<'_>>,
        mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
    ) -> Result<Frame, RuntimeError> {
        frame::prepare(device, encoder, &mut self.pipelines, &mut self.shadows, params, instances, casters, mark)
    }

    /// Forgets the shadow maps, so that the next frame draws them anew. Needed only after an encoder that a frame was prepared into
    /// was dropped instead of submitted, and to give their memory back.
    pub fn invalidate_shadows(&mut self) {
        self.shadows = None;
    }
}

/// Layouts, and the pipelines and shader modules, made when first asked for.
#[derive(Debug)]
pub(crate) struct Pipelines {
    options: RendererOptions,
    pub(crate) layouts: SurfaceLayouts,
    pose: Option<wgpu::ComputePipeline>,
    filter: Option<FilterPipelines>,
    ink: Option<InkPipelines>,
    modules: HashMap<&'static str, wgpu::ShaderModule>,
    surfaces: HashMap<SurfaceKey, wgpu::RenderPipeline>,
}

fn module(device: &wgpu::Device, label: &str, wgsl: &'static str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    })
}

impl Pipelines {
    pub(crate) fn reversed_depth(&self) -> bool {
        self.options.reversed_depth
    }

    pub(crate) fn pose(&mut self, device: &wgpu::Device) -> &wgpu::ComputePipeline {
        self.pose.get_or_insert_with(|| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("pelage pose"),
                layout: None,
                module: &module(device, "pelage pose", pose::WGSL),
                entry_point: Some("pose"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            })
        })
    }

    pub(crate) fn filter(&mut self, device: &wgpu::Device) -> &FilterPipelines {
        self.filter.get_or_insert_with(|| {
            FilterPipelines::new(device, &module(device, "pelage shadow width", shadow_width::FILTER_WGSL))
        })
    }

    /// The ink style's, with what they are made with.
    pub(crate) fn ink<'a>(
        &'a mut self,
        device: &'a wgpu::Device,
        camera: &Camera,
    ) -> (&'a mut InkPipelines, ink::Making<'a>) {
        let clip_from_view = camera.projection.clip_from_view(self.options.reversed_depth);
        let making = ink::Making { device, layouts: &self.layouts, options: &self.options, clip_from_view };
        (self.ink.get_or_insert_with(|| InkPipelines::new(device)), making)
    }

    /// What an instance draws in ink; `None` for a model without the style.
    pub(crate) fn plan_ink(
        &mut self,
        device: &wgpu::Device,
        params: &FrameParams,
        ink_params: &InkParams,
        instance: &Instance,
    ) -> Option<InkDraws> {
        let model = instance.model().clone();
        let (inks, making) = self.ink(device, &params.camera);
        Some(ink::plan(making, inks, params, ink_params, instance, model.ink()?))
    }

    /// Compiles what a model needs in ink.
    pub(crate) fn compile_ink(
        &mut self,
        device: &wgpu::Device,
        model: &Model,
        params: &FrameParams,
        ink_params: &InkParams,
    ) {
        let (inks, making) = self.ink(device, &params.camera);
        ink::compile(making, inks, params, ink_params, model);
    }

    pub(crate) fn surface(&mut self, device: &wgpu::Device, key: SurfaceKey) -> wgpu::RenderPipeline {
        let (label, wgsl) = match key.shader {
            SurfaceShader::SkinBare | SurfaceShader::SkinFurred => ("pelage skin", skin::WGSL),
            SurfaceShader::Fins => ("pelage fins", fins::WGSL),
            SurfaceShader::Shells | SurfaceShader::Yardstick => ("pelage shells", shells::WGSL),
            SurfaceShader::LayerShadow => ("pelage layer shadow", layer_shadow::WGSL),
            SurfaceShader::Caster(_) => ("pelage casters", shadow_width::WGSL),
        };
        let module = self.modules.entry(label).or_insert_with(|| module(device, label, wgsl));
        self.surfaces.entry(key).or_insert_with(|| self.layouts.pipeline(device, module, key, &self.options)).clone()
    }
}
