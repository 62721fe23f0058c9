//! State that lasts between frames, and the preparation of frames.

use crate::camera::Camera;
use crate::error::RuntimeError;
use crate::frame::{self, Frame};
use crate::gpu::{Cache, Gpu, Pool, UniformRing};
use crate::hooks::Hooks;
use crate::ink::SealTexture;
use crate::instance::Instance;
use crate::light::EnvironmentCache;
use crate::model::{self, Model};
use crate::motion::OwnerStates;
use crate::params::{Detail, FrameParams, HairGeometry, RendererOptions, StrandEdges, Style};
use crate::scene::RendererState;
use crate::surface::Surfaces;
use glam::Vec3;
use pelage_formats::{Limits, Package};

/// Draws models into the application's own render pass. Create one renderer per device and kind of pass.
#[derive(Debug)]
pub struct Renderer {
    state: RendererState,
}

impl Renderer {
    /// Creates a renderer after checking the options. Pipelines are compiled when a frame first needs them, or by
    /// [`Renderer::prepare_pipelines`]. The application still owns device and queue; the renderer keeps handles to
    /// them.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, options: &RendererOptions) -> Result<Self, RuntimeError> {
        options.check(device)?;
        let gpu = Gpu::new(device, queue);
        let surfaces = Surfaces::new(&gpu);
        let kept = RendererState {
            gpu,
            cache: Cache::default(),
            surfaces,
            options: options.clone(),
            states: OwnerStates::default(),
            shadows: Pool::default(),
            ribbons: Pool::default(),
            contours: Pool::default(),
            nearest: Pool::default(),
            painted: Pool::default(),
            skies: EnvironmentCache::default(),
            seal: SealTexture::default(),
            ring: UniformRing::default(),
        };
        Ok(Self { state: kept })
    }

    /// Returns the options of the renderer.
    pub fn options(&self) -> &RendererOptions {
        &self.state.options
    }

    /// Returns the shader stages of all pipelines compiled so far, ordered by name.
    #[cfg(feature = "study")]
    pub fn shader_variants(&self) -> Vec<crate::ShaderVariant> {
        self.state.cache.pipelines.variants()
    }

    /// Uploads a package directly from the slices that it borrows. The package's bytes may be dropped afterwards.
    ///
    /// Fails if a section is damaged, if a texture needs a feature that is not enabled on the device, or if a resource
    /// exceeds the device's limits.
    pub fn load(&self, package: &Package<'_>) -> Result<Model, RuntimeError> {
        model::load(&self.state.gpu, &self.state.options, &self.state.surfaces, package)
    }

    /// Opens a package with default [`Limits`] and uploads it.
    pub fn load_bytes(&self, bytes: &[u8]) -> Result<Model, RuntimeError> {
        self.load(&Package::open(bytes, &Limits::default())?)
    }

    /// Compiles the pipelines for drawing `model` with `params`, so that the first frame does not wait for them. Some
    /// are still compiled on first use: for mirrored instances, for another style or other lighting constants, and for
    /// frames with models of different layer counts.
    ///
    /// To find the pipelines, it prepares frames of one instance for every level of detail that `params` may choose.
    /// These frames are dropped without drawing.
    pub fn prepare_pipelines(&mut self, model: &Model, params: &FrameParams) -> Result<(), RuntimeError> {
        let levels = model.manifest().detail.len();
        let mut variants = vec![params.clone()];
        if let Style::Fur(fur) = &params.style
            && matches!(fur.detail, Detail::Auto { .. })
        {
            let level = |k: usize| Detail::Level(0.5 * k as f32);
            variants = (0..(2 * levels).max(1)).map(|k| params.clone().with_fur(|f| f.detail = level(k))).collect();
        }
        // Add the strand variants: explicit levels do not include them, because explicit levels draw layers.
        if params.style.fur().is_some_and(|fur| fur.hair == HairGeometry::Auto) && model.fur_strands().is_some() {
            variants.push(params.clone().with_fur(|fur| fur.hair = HairGeometry::Strands));
        }
        if params.style.fur().is_some_and(|fur| fur.strand_edges == StrandEdges::Blended) && !model.strands().is_empty()
        {
            let strands = params.clone().with_fur(|fur| fur.hair = HairGeometry::Strands);
            // The variant depends on the size of the picture and on the device.
            variants.push(strands.clone().with(|p| p.viewport = [64; 2]));
            variants.push(strands.with_fur(|fur| fur.strand_edges = StrandEdges::Samples));
        }
        if self.state.ring.lost_work() {
            self.invalidate();
            self.state.states.invalidate_motion();
        }
        // These frames change the state; the changes are dropped with them.
        let shadows = std::mem::take(&mut self.state.shadows);
        let ribbons = std::mem::take(&mut self.state.ribbons);
        let nearest = std::mem::take(&mut self.state.nearest);
        let targets = std::mem::take(&mut self.state.cache.targets);
        let bind_groups = std::mem::take(&mut self.state.cache.bind_groups);
        let mut encoder = self.state.gpu.device.create_command_encoder(&Default::default());
        // The instance must not be culled, whatever the camera's direction.
        let bounds = model.manifest().bounds;
        let radius = bounds.radius.max(1e-6) + model.manifest().fur.height_m;
        let unseen = Instance::new(Instance::NO_OWNER, model);
        let prepared = variants.into_iter().try_for_each(|variant| {
            let [width, height] = variant.viewport.map(|side| side as f32);
            let framed = Camera::framing(bounds.center.into(), radius, Vec3::Z, 0.6, width / height);
            let variant = variant.with(|p| p.camera = framed);
            frame::prepare(&mut self.state, &mut encoder, &variant, &[&unseen], Hooks::default()).map(drop)
        });
        self.state.states.forget(Instance::NO_OWNER);
        self.state.shadows = shadows;
        self.state.ribbons = ribbons;
        self.state.nearest = nearest;
        self.state.cache.targets = targets;
        self.state.cache.bind_groups = bind_groups;
        drop(encoder);
        // Reset the flag: the work lost by dropping this encoder is not needed.
        self.state.ring.lost_work();
        prepared
    }

    /// Prepares a frame: compiles missing pipelines, uploads changed data, and records the passes that run before the
    /// application's render pass into `encoder`.
    ///
    /// The encoder must be submitted before, or together with, the pass that the frame is drawn into. Submit encoders
    /// in the order in which frames were prepared into them: a later frame reuses poses and shadow maps of earlier
    /// ones.
    ///
    /// Two cameras in one submission need two frames. An owner has one pose at a time, that of the last frame prepared.
    /// Instances are drawn in the given order; where fur overlaps in the picture, pass the farther instance first.
    ///
    /// Instances may be owned or borrowed, from an array or directly from a query. The renderer does not keep the
    /// instances, only state under the number of their owner.
    pub fn prepare<I>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: I,
    ) -> Result<Frame, RuntimeError>
    where
        I: IntoIterator,
        I::Item: AsRef<Instance>,
    {
        self.prepare_with(encoder, params, instances, Hooks::default())
    }

    /// Prepares a frame as [`Self::prepare`] does, with the application's hooks.
    pub fn prepare_with<I>(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        params: &FrameParams,
        instances: I,
        hooks: Hooks<'_>,
    ) -> Result<Frame, RuntimeError>
    where
        I: IntoIterator,
        I::Item: AsRef<Instance>,
    {
        let instances: Vec<I::Item> = instances.into_iter().collect();
        let instances: Vec<&Instance> = instances.iter().map(AsRef::as_ref).collect();
        instances.iter().try_for_each(|instance| instance.check_owner())?;
        frame::prepare(&mut self.state, encoder, params, &instances, hooks)
    }

    #[cfg(test)]
    pub(crate) fn posed_guides(&self, owner: u64, set: usize) -> Option<&wgpu::Buffer> {
        self.state.states.posed_guides(owner, set)
    }

    #[cfg(test)]
    pub(crate) fn leaned(&self, owner: u64) -> Option<&wgpu::Buffer> {
        self.state.states.leaned(owner)
    }

    /// Drops poses and shadow maps, so that the next frame recreates them, and frees the memory of the maps. Not needed
    /// after an encoder was dropped unsubmitted; the renderer detects that.
    pub fn invalidate(&mut self) {
        self.state.states.invalidate();
        self.state.shadows = Pool::default();
        self.state.ribbons = Pool::default();
        self.state.nearest = Pool::default();
        self.state.cache.bind_groups.clear();
    }

    /// Drops the state of an owner immediately. Owners unused for 256 frames are dropped automatically. The state of an
    /// owner keeps its model alive.
    pub fn forget(&mut self, owner: u64) {
        self.state.states.forget(owner);
    }

    /// Returns the size of the state of all owners in GPU memory, bytes: posed vertices, leaned fur and posed strands.
    pub fn owners_gpu_bytes(&self) -> u64 {
        self.state.states.gpu_bytes()
    }
}
