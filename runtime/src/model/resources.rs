//! A package on the GPU.

use super::extent::Extent;
use super::ink::ModelInk;
use super::strands::Strands;
use crate::error::RuntimeError;
use crate::params::check_shading;
use pelage_formats::meaning::fur_motion;
use pelage_formats::meaning::hair_motion::rest_s;
use pelage_formats::{Animation, BodyCollider, Clip, FibreInfo, Manifest, MeshView, MorphTarget, Shading};
use std::ops::Range;
use std::sync::Arc;

/// A package on the GPU: vertices, textures, materials. Cheap to clone; the clones share everything.
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) manifest: Arc<Manifest>,
    pub(super) resources: Arc<Resources>,
}

#[derive(Debug)]
pub(super) struct Resources {
    /// As the package kept it.
    pub(super) animation: Option<Arc<Animation>>,
    pub(super) geometry: wgpu::Buffer,
    pub(super) attributes: wgpu::Buffer,
    pub(super) skin: Option<wgpu::Buffer>,
    pub(super) morphs: Option<MorphBuffers>,
    pub(super) indices: wgpu::Buffer,
    pub(super) fur: Option<wgpu::BindGroup>,
    pub(super) fins: Option<Fins>,
    pub(super) strands: Vec<Strands>,
    /// What of the body hair does not go into.
    pub(super) colliders: Vec<BodyCollider>,
    pub(super) planar_directions: bool,
    pub(super) knows_visibility: bool,
    /// How fibres scatter light, where the package says it.
    pub(super) fibres: Option<Arc<FibreInfo>>,
    pub(super) varies: Varies,
    pub(super) parts: Vec<Part>,
    pub(super) deviations_m: Vec<f32>,
    pub(super) extent: Extent,
    pub(super) ink: Option<ModelInk>,
    pub(super) gpu_bytes: u64,
}

/// What morph targets do to the vertices of a model.
#[derive(Debug)]
pub(crate) struct MorphBuffers {
    /// For each vertex where its deltas begin, and the end.
    pub(crate) first: wgpu::Buffer,
    pub(crate) deltas: wgpu::Buffer,
}

/// Fins of a model.
#[derive(Debug)]
pub(crate) struct Fins {
    /// All fins, part after part.
    pub(crate) buffer: wgpu::Buffer,
    /// Their textures, in the layout of the shells'.
    pub(crate) textures: wgpu::BindGroup,
    /// The direction texture has two components.
    pub(crate) planar_directions: bool,
}

/// What varies over the vertices of a model: the shaders do nothing for what does not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Varies {
    /// Some vertex leans more than the tile's strands.
    pub(crate) lean: bool,
    /// Some vertex has shorter or longer fur than the manifest says, which is how long the tile's is.
    pub(crate) length: bool,
    /// Some vertex is bare or wet.
    pub(crate) groom: bool,
    /// Some vertex has higher fur than the manifest says.
    pub(crate) beyond_height: bool,
}

impl Varies {
    pub(super) fn of(mesh: &MeshView<'_>, height_m: f32) -> Self {
        Self {
            lean: mesh.geometry().any(|v| v.lean > 0.0),
            length: mesh.geometry().any(|v| v.fur_height > 0.0 && (v.fur_height / height_m - 1.0).abs() > 1e-3),
            groom: mesh.attributes().any(|v| v.groom != [0; 4]),
            beyond_height: mesh.geometry().any(|v| v.fur_height > height_m * 1.001),
        }
    }
}

/// What of the index buffer has one material.
#[derive(Debug)]
pub(crate) struct Part {
    /// Of the mesh, and of each of its simplified lists.
    pub(crate) indices: Vec<Range<u32>>,
    pub(crate) fins: Range<u32>,
    /// Of each of the model's sets of strands.
    pub(crate) strands: Vec<Range<u32>>,
    pub(crate) material: wgpu::BindGroup,
    pub(crate) has_texture: bool,
    /// Its hair has the base colour of the skin where it roots.
    pub(crate) at_root: bool,
    pub(crate) has_groom_texture: bool,
    pub(crate) cutout: bool,
    pub(crate) furred: bool,
    pub(crate) double_sided: bool,
}

impl Model {
    /// What the package says about itself.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The same model with other constants of the lighting equation than its package has. It shares everything else, and what was made for one of
    /// them (poses, shadow maps, pipelines) serves the other.
    ///
    /// # Errors
    ///
    /// [`RuntimeError::Params`] for constants out of their ranges.
    pub fn with_shading(&self, shading: Shading) -> Result<Self, RuntimeError> {
        check_shading("Model::with_shading", &shading)?;
        let manifest = Manifest { shading, ..(*self.manifest).clone() };
        Ok(Self { manifest: Arc::new(manifest), resources: self.resources.clone() })
    }

    /// The model's motions.
    pub fn clips(&self) -> &[Clip] {
        self.resources.animation.as_ref().map_or(&[], |a| &a.clips)
    }

    /// Index of the first clip of that name, for [`crate::Motion::Clip`].
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips().iter().position(|c| c.name == name)
    }

    /// The shapes that it goes over to by weights, such as expressions of a face: for [`crate::Instance::morphs`].
    pub fn morph_targets(&self) -> &[MorphTarget] {
        self.resources.animation.as_ref().map_or(&[], |a| &a.morphs.targets)
    }

    /// Index of the first morph target of that name.
    pub fn morph_index(&self, name: &str) -> Option<usize> {
        self.morph_targets().iter().position(|target| target.name == name)
    }

    /// Bytes of its buffers and textures, shared by all instances.
    pub fn gpu_bytes(&self) -> u64 {
        self.resources.gpu_bytes
    }

    /// The skeleton, where the vertices follow one.
    pub fn skeleton(&self) -> Option<&Animation> {
        self.resources.animation.as_deref().filter(|_| self.resources.skin.is_some())
    }

    /// Whether any of its hair on guides swings where frames let it ([`crate::FrameParams::hair_motion`]).
    pub fn has_moving_hair(&self) -> bool {
        self.hair_rest_s().is_some()
    }

    /// Whether it has fur, which leans where frames let it.
    pub fn has_leaning_fur(&self) -> bool {
        self.manifest().fur.height_m > fur_motion::SHORTEST_M
    }

    /// Seconds after which its hair on guides has come to rest where nothing moves it; `None` where none moves.
    pub(crate) fn hair_rest_s(&self) -> Option<f32> {
        let moves = self.resources.strands.iter().filter_map(|set| set.guided()?.motion);
        moves.map(|motion| rest_s(&motion)).reduce(f32::max)
    }

    pub(crate) fn colliders(&self) -> &[BodyCollider] {
        &self.resources.colliders
    }

    pub(crate) fn geometry(&self) -> &wgpu::Buffer {
        &self.resources.geometry
    }

    pub(crate) fn attributes(&self) -> &wgpu::Buffer {
        &self.resources.attributes
    }

    pub(crate) fn skin(&self) -> Option<&wgpu::Buffer> {
        self.resources.skin.as_ref()
    }

    pub(crate) fn morphs(&self) -> Option<&MorphBuffers> {
        self.resources.morphs.as_ref()
    }

    pub(crate) fn indices(&self) -> &wgpu::Buffer {
        &self.resources.indices
    }

    pub(crate) fn fur(&self) -> Option<&wgpu::BindGroup> {
        self.resources.fur.as_ref()
    }

    pub(crate) fn fins(&self) -> Option<&Fins> {
        self.resources.fins.as_ref()
    }

    /// Its strands: those of the coat first where it has some, then groups of hair.
    pub(crate) fn strands(&self) -> &[Strands] {
        &self.resources.strands
    }

    /// The strands of its coat.
    pub(crate) fn coat_strands(&self) -> Option<&Strands> {
        self.resources.strands.first().filter(|strands| strands.guided().is_none())
    }

    /// How far groups of hair reach from the skin, metres.
    pub(crate) fn hair_reach_m(&self) -> f32 {
        self.resources.strands.iter().filter_map(Strands::guided).map(|guided| guided.reach_m).fold(0.0, f32::max)
    }

    pub(crate) fn planar_directions(&self) -> bool {
        self.resources.planar_directions
    }

    /// How its fibres scatter light, where the package says it.
    pub(crate) fn fibres(&self) -> Option<&Arc<FibreInfo>> {
        self.resources.fibres.as_ref()
    }

    /// Whether the package says how much light reaches its hair.
    pub(crate) fn knows_visibility(&self) -> bool {
        self.resources.knows_visibility
    }

    pub(crate) fn varies(&self) -> Varies {
        self.resources.varies
    }

    /// Fails for a model that has no ink style.
    pub(crate) fn has_ink(&self) -> Result<(), RuntimeError> {
        if self.resources.ink.is_some() {
            return Ok(());
        }
        Err(RuntimeError::Content {
            package: self.manifest().model.clone(),
            what: "ink style".into(),
            reason: "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into(),
        })
    }

    /// Its ink style, where the package has one.
    pub(crate) fn ink(&self) -> Option<&ModelInk> {
        self.resources.ink.as_ref()
    }

    /// How far the skin reaches.
    pub(crate) fn extent(&self) -> &Extent {
        &self.resources.extent
    }

    /// Whether the other shares all buffers and textures with it.
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.resources, &other.resources)
    }

    pub(crate) fn parts(&self) -> &[Part] {
        &self.resources.parts
    }

    /// How far the simplified lists deviate from the mesh, metres at rest, rising.
    pub(crate) fn deviations_m(&self) -> &[f32] {
        &self.resources.deviations_m
    }

    /// Triangles of the mesh, or of one of its simplified lists.
    pub(crate) fn triangles(&self, list: usize) -> u32 {
        self.resources.parts.iter().filter_map(|part| part.indices.get(list)).map(|range| range.len() as u32 / 3).sum()
    }
}
