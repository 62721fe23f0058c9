//! Persistent data of the render world: one `Renderer` per kind of pass, and the models on the GPU.

use crate::extract::{Animal, Scene};
use crate::model::PelageModel;
use bevy_asset::AssetId;
use bevy_ecs::prelude::*;
use bevy_log::{error, warn};
use bevy_math::{Mat3, UVec4};
use bevy_render::render_resource::TextureFormat;
use bevy_render::renderer::{RenderDevice, RenderQueue};
use bevy_render::sync_world::MainEntity;
use pelage_runtime::{Frame, Instance, Model, Motion, Renderer, RendererOptions, RuntimeError};
use pelage_stage::NamedPackage;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Formats and sample count that distinguish Bevy's passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct PassKind {
    pub(crate) color: TextureFormat,
    pub(crate) depth: TextureFormat,
    pub(crate) samples: u32,
}

/// A package loaded to the GPU, or one that failed to load.
#[derive(Debug)]
struct LoadedModel {
    package: Arc<NamedPackage<'static>>,
    /// Model; `None` if the device cannot draw it (an error is logged).
    model: Option<Model>,
}

/// Options of all renderers. Formats and sample count are determined by the pass instead.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct Options(pub(crate) RendererOptions);

/// Renderers and other data kept between frames. A resource of the render world that reports GPU memory.
#[derive(Resource, Debug)]
pub struct PelageRenderers {
    options: RendererOptions,
    by_pass: HashMap<PassKind, Option<Renderer>>,
    models: HashMap<AssetId<PelageModel>, LoadedModel>,
    owners: HashSet<MainEntity>,
    log: LogOnce,
}

/// A prepared frame, and the area of the target that it is drawn to.
#[derive(Debug)]
pub(crate) struct PreparedFrame {
    pub(crate) frame: Frame,
    /// Viewport for which the frame was prepared, pixels: left, top, width and height.
    pub(crate) viewport: UVec4,
    /// Part of the viewport that belongs to the view, pixels: left, top, width and height.
    pub(crate) part: UVec4,
}

/// Frames to draw, by the view's entity in the render world. They are dropped after Bevy has submitted them.
#[derive(Resource, Debug, Default)]
pub(crate) struct Frames(pub(crate) HashMap<Entity, Vec<PreparedFrame>>);

/// Log that skips repeated messages, because each frame repeats the errors of the previous one.
#[derive(Debug, Default)]
pub(crate) struct LogOnce(HashSet<String>);

/// Maximum number of different messages that are logged. Without a limit, a number that changes every frame would fill
/// the log.
const MAX_MESSAGES: usize = 100;

impl LogOnce {
    /// Logs an error once.
    pub(crate) fn error(&mut self, message: String) {
        if self.is_new(&message) {
            error!("{message}");
            self.0.insert(message);
        }
    }

    /// Logs a warning once.
    pub(crate) fn warn(&mut self, message: String) {
        if self.is_new(&message) {
            warn!("{message}");
            self.0.insert(message);
        }
    }

    fn is_new(&self, message: &str) -> bool {
        self.0.len() < MAX_MESSAGES && !self.0.contains(message)
    }
}

/// Renderer for one kind of pass, with the models and the log that all renderers share.
pub(crate) struct PassRenderer<'a> {
    pub(crate) renderer: &'a mut Renderer,
    models: &'a mut HashMap<AssetId<PelageModel>, LoadedModel>,
    pub(crate) log: &'a mut LogOnce,
}

impl PelageRenderers {
    /// Returns the renderer for passes of this kind. `None` if the device cannot draw into such passes (an error is
    /// logged).
    pub(crate) fn for_pass(
        &mut self,
        kind: PassKind,
        device: &RenderDevice,
        queue: &RenderQueue,
    ) -> Option<PassRenderer<'_>> {
        let Self { options, by_pass, models, log, .. } = self;
        let renderer = by_pass.entry(kind).or_insert_with(|| {
            let options = RendererOptions {
                color_format: kind.color,
                depth_format: kind.depth,
                sample_count: kind.samples,
                reversed_depth: true,
                ..options.clone()
            };
            match Renderer::new(device.wgpu_device(), queue, &options) {
                Ok(renderer) => Some(renderer),
                Err(fault) => {
                    log.error(format!("pelage cannot draw into a camera's pass: {fault}"));
                    None
                }
            }
        });
        renderer.as_mut().map(|renderer| PassRenderer { renderer, models, log })
    }

    /// Logs a warning once.
    pub(crate) fn warn(&mut self, message: String) {
        self.log.warn(message);
    }

    /// Drops the models whose assets were removed or replaced, and the data of removed animals.
    fn forget(&mut self, scene: &Scene) {
        let same = |id: &AssetId<PelageModel>, loaded: &mut LoadedModel| {
            scene.packages.get(id).is_some_and(|package| Arc::ptr_eq(package, &loaded.package))
        };
        self.models.retain(same);
        for removed in self.owners.iter().filter(|owner| !scene.animals.contains_key(*owner)) {
            self.by_pass.values_mut().flatten().for_each(|renderer| renderer.forget(removed.to_bits()));
        }
        self.owners.clear();
        self.owners.extend(scene.animals.keys());
    }

    /// Returns the GPU memory of the models' buffers and textures, bytes. All animals with the same model share them.
    pub fn models_gpu_bytes(&self) -> u64 {
        self.models.values().filter_map(|loaded| loaded.model.as_ref()).map(Model::gpu_bytes).sum()
    }

    /// Returns the GPU memory of the data that each animal owns (posed vertices), bytes.
    pub fn animals_gpu_bytes(&self) -> u64 {
        self.by_pass.values().flatten().map(Renderer::owners_gpu_bytes).sum()
    }

    /// Returns the logged messages: errors of packages and frames, and warnings. Each appears once.
    pub fn logged_messages(&self) -> impl Iterator<Item = &str> {
        self.log.0.iter().map(String::as_str)
    }
}

impl FromWorld for PelageRenderers {
    /// Creates an empty state for a device. Bevy calls this again after the device was lost.
    fn from_world(world: &mut World) -> Self {
        let options = world.get_resource::<Options>().cloned().unwrap_or_default().0;
        Self {
            options,
            by_pass: HashMap::new(),
            models: HashMap::new(),
            owners: HashSet::new(),
            log: LogOnce::default(),
        }
    }
}

impl PassRenderer<'_> {
    /// Returns an animal as an instance of the runtime; loads its model if needed. `None` while the asset is missing,
    /// or if the model cannot be drawn.
    pub(crate) fn instance(&mut self, scene: &Scene, entity: MainEntity, animal: &Animal) -> Option<Instance> {
        let package = scene.packages.get(&animal.model)?;
        let loaded = self.models.entry(animal.model).or_insert_with(|| {
            let model = match self.renderer.load_bytes(&package.bytes) {
                Ok(model) => Some(model),
                Err(fault) => {
                    self.log.error(format!("{}: {fault}", package.name));
                    None
                }
            };
            LoadedModel { package: package.clone(), model }
        });
        let model = loaded.model.as_ref()?;
        // Skip an animal scaled to zero: it would be an error, and then no animal of the frame would be drawn.
        let drawable = animal.transform.is_finite() && Mat3::from_mat4(animal.transform).determinant() != 0.0;
        if let (Motion::Joints(joints), Some(skeleton)) = (&animal.motion, model.skeleton())
            && joints.len() != skeleton.joints.len()
        {
            let (found, expected) = (joints.len(), skeleton.joints.len());
            self.log.error(format!("{}: PelageJoints has {found} matrices, expected {expected}", package.name));
            return None;
        }
        let mut morphs = Vec::new();
        for (name, weight) in &animal.morphs.0 {
            match model.morph_index(name).filter(|_| weight.is_finite()) {
                Some(index) => morphs.push((index, *weight)),
                None => self.log.error(format!(
                    "{}: PelageMorphs has {name:?} with weight {weight}, expected a morph target of the model and a \
                     finite weight",
                    package.name
                )),
            }
        }
        let instance = Instance::new(entity.to_bits(), model).at(animal.transform).moving(animal.motion.clone());
        let instance = instance.morphing(morphs);
        drawable.then_some(instance)
    }

    /// Returns the frame; if preparing it failed, logs the error and returns `None`.
    pub(crate) fn or_log(&mut self, frame: Result<Frame, RuntimeError>) -> Option<Frame> {
        frame.map_err(|fault| self.log.error(format!("pelage cannot draw a frame: {fault}"))).ok()
    }
}

/// Drops unused data before the passes of a frame.
pub(crate) fn drop_unused(mut renderers: ResMut<PelageRenderers>, scene: Res<Scene>) {
    renderers.forget(&scene);
}

/// Drops the frames after Bevy has submitted them.
pub(crate) fn drop_frames(mut frames: ResMut<Frames>) {
    frames.0.clear();
}
