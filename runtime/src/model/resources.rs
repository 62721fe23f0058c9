//! Package in GPU memory.

use super::bounds::ModelBounds;
use super::contours::ModelContours;
use super::ink::ModelInk;
use super::painting::ModelPainting;
use super::strands::StrandSet;
use crate::error::RuntimeError;
use crate::params::check_shading;
use pelage_formats::meaning::fur_motion;
use pelage_formats::meaning::hair_motion::rest_s;
use pelage_formats::{Animation, BodyCollider, Clip, FibreInfo, Manifest, MeshView, MorphTarget, Shading};
use std::ops::Range;
use std::sync::Arc;

/// Package in GPU memory: vertices, textures, materials. Cheap to clone; the clones share all resources.
#[derive(Clone, Debug)]
pub struct Model {
    pub(super) manifest: Arc<Manifest>,
    pub(super) resources: Arc<Resources>,
}

#[derive(Debug)]
pub(super) struct Resources {
    /// Animation as stored in the package.
    pub(super) animation: Option<Arc<Animation>>,
    pub(super) geometry: wgpu::Buffer,
    pub(super) attributes: wgpu::Buffer,
    /// Normals of bare surface, if they differ from those of the hair.
    pub(super) bare_normals: Option<wgpu::Buffer>,
    pub(super) skin: Option<wgpu::Buffer>,
    pub(super) morphs: Option<MorphBuffers>,
    pub(super) indices: wgpu::Buffer,
    pub(super) fur: Option<wgpu::BindGroup>,
    pub(super) fins: Option<Fins>,
    pub(super) strands: Vec<StrandSet>,
    pub(super) colliders: Vec<BodyCollider>,
    pub(super) planar_directions: bool,
    pub(super) knows_visibility: bool,
    /// Fibre scattering data, if the package has it.
    pub(super) fibres: Option<Arc<FibreInfo>>,
    pub(super) varies: VaryingAttributes,
    pub(super) parts: Vec<Part>,
    pub(super) deviations_m: Vec<f32>,
    pub(super) layer_opacities: Vec<f32>,
    pub(super) extent: ModelBounds,
    pub(super) ink: Option<ModelInk>,
    pub(super) painting: Option<ModelPainting>,
    pub(super) contours: Option<ModelContours>,
    pub(super) gpu_bytes: u64,
}

/// Morph target deltas of a model's vertices. The deltas of all vertices are concatenated.
#[derive(Debug)]
pub(crate) struct MorphBuffers {
    /// Offset of each vertex's deltas, followed by the end of the last.
    pub(crate) first: wgpu::Buffer,
    pub(crate) deltas: wgpu::Buffer,
}

#[derive(Debug)]
pub(crate) struct Fins {
    /// Fins of all parts, concatenated.
    pub(crate) buffer: wgpu::Buffer,
    /// Fin textures, in the same layout as the shell textures.
    pub(crate) textures: wgpu::BindGroup,
    /// Whether the direction texture has two components.
    pub(crate) planar_directions: bool,
}

/// Attributes that vary over the vertices of a model. Shaders skip the others.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VaryingAttributes {
    /// Whether at least one vertex leans more than the tile's strands.
    pub(crate) lean: bool,
    /// Whether at least one vertex has fur whose length differs from the manifest's height, the height of the tile.
    pub(crate) length: bool,
    /// Whether at least one vertex is bare or wet.
    pub(crate) groom: bool,
    /// Whether at least one vertex has fur higher than the manifest's height.
    pub(crate) beyond_height: bool,
}

impl VaryingAttributes {
    pub(super) fn of(mesh: &MeshView<'_>, height_m: f32) -> Self {
        Self {
            lean: mesh.geometry().any(|v| v.lean > 0.0),
            length: mesh.geometry().any(|v| v.fur_height > 0.0 && (v.fur_height / height_m - 1.0).abs() > 1e-3),
            groom: mesh.attributes().any(|v| v.groom != [0; 4]),
            beyond_height: mesh.geometry().any(|v| v.fur_height > height_m * 1.001),
        }
    }
}

/// Range of the index buffer that has one material.
#[derive(Debug)]
pub(crate) struct Part {
    /// Index ranges: in the mesh, and in each of its simplified lists.
    pub(crate) indices: Vec<Range<u32>>,
    pub(crate) fins: Range<u32>,
    /// Strand ranges, one for each of the model's strand sets.
    pub(crate) strands: Vec<Range<u32>>,
    pub(crate) material: wgpu::BindGroup,
    pub(crate) has_texture: bool,
    /// Whether hair uses the base colour of the surface at its root.
    pub(crate) at_root: bool,
    /// Whether hair has a colour of its own in place of the base colour.
    pub(crate) has_hair_color: bool,
    pub(crate) has_groom_texture: bool,
    /// Whether bare surface is glossy.
    pub(crate) glossy: bool,
    pub(crate) cutout: bool,
    pub(crate) furred: bool,
    pub(crate) double_sided: bool,
}

impl Model {
    /// Returns the manifest of the package.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns a copy of the model whose lighting constants replace those of its package. The copy shares everything
    /// else with the original, including poses, shadow maps and pipelines.
    ///
    /// Fails with [`RuntimeError::Params`] for constants out of range.
    pub fn with_shading(&self, shading: Shading) -> Result<Self, RuntimeError> {
        check_shading("Model::with_shading", &shading)?;
        let manifest = Manifest { shading, ..(*self.manifest).clone() };
        Ok(Self { manifest: Arc::new(manifest), resources: self.resources.clone() })
    }

    /// Returns the animation clips of the model.
    pub fn clips(&self) -> &[Clip] {
        self.resources.animation.as_ref().map_or(&[], |a| &a.clips)
    }

    /// Returns the index of the first clip with that name, for [`crate::Motion::Clip`].
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips().iter().position(|c| c.name == name)
    }

    /// Returns the morph targets, such as facial expressions, for use in [`crate::Instance::morphs`].
    pub fn morph_targets(&self) -> &[MorphTarget] {
        self.resources.animation.as_ref().map_or(&[], |a| &a.morphs.targets)
    }

    /// Returns the index of the first morph target with that name.
    pub fn morph_index(&self, name: &str) -> Option<usize> {
        self.morph_targets().iter().position(|target| target.name == name)
    }

    /// Returns the size of the model's buffers and textures in bytes. All instances share them.
    pub fn gpu_bytes(&self) -> u64 {
        self.resources.gpu_bytes
    }

    /// Returns the skeleton; `None` if the model has none.
    pub fn skeleton(&self) -> Option<&Animation> {
        self.resources.animation.as_deref().filter(|_| self.resources.skin.is_some())
    }

    /// Whether any guided hair of the model moves in frames with hair motion ([`crate::FrameParams::hair_motion`]).
    pub fn has_moving_hair(&self) -> bool {
        self.hair_rest_s().is_some()
    }

    /// Whether the model has fur that leans in frames with hair motion.
    pub fn has_leaning_fur(&self) -> bool {
        self.manifest().fur.height_m > fur_motion::SHORTEST_M
    }

    /// Returns the time without movement after which the model's guided hair comes to rest, seconds; `None` if none of
    /// it can move.
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

    pub(crate) fn bare_normals(&self) -> Option<&wgpu::Buffer> {
        self.resources.bare_normals.as_ref()
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

    /// Returns the strand sets of the model: first the fur strands, if any, then the hair groups.
    pub(crate) fn strands(&self) -> &[StrandSet] {
        &self.resources.strands
    }

    pub(crate) fn fur_strands(&self) -> Option<&StrandSet> {
        self.resources.strands.first().filter(|strands| strands.guided().is_none())
    }

    /// Returns the maximum distance of hair groups from the surface, metres.
    pub(crate) fn hair_reach_m(&self) -> f32 {
        self.resources.strands.iter().filter_map(StrandSet::guided).map(|guided| guided.reach_m).fold(0.0, f32::max)
    }

    pub(crate) fn planar_directions(&self) -> bool {
        self.resources.planar_directions
    }

    /// Returns the fibre scattering data of the model, if the package has it.
    pub(crate) fn fibres(&self) -> Option<&Arc<FibreInfo>> {
        self.resources.fibres.as_ref()
    }

    pub(crate) fn has_baked_visibility(&self) -> bool {
        self.resources.knows_visibility
    }

    pub(crate) fn varies(&self) -> VaryingAttributes {
        self.resources.varies
    }

    pub(crate) fn require_ink(&self) -> Result<(), RuntimeError> {
        if self.resources.ink.is_some() {
            return Ok(());
        }
        Err(RuntimeError::Content {
            package: self.manifest().model.clone(),
            what: "ink style".into(),
            reason: "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into(),
        })
    }

    /// Returns the strokes with which the model is painted, if the package has any.
    pub(crate) fn painting(&self) -> Option<&ModelPainting> {
        self.resources.painting.as_ref()
    }

    /// Returns the contour mesh of the ink style, if the package has one.
    pub(crate) fn contours(&self) -> Option<&ModelContours> {
        self.resources.contours.as_ref()
    }

    pub(crate) fn ink(&self) -> Option<&ModelInk> {
        self.resources.ink.as_ref()
    }

    /// Returns the bounds of the mesh surface.
    pub(crate) fn bounds(&self) -> &ModelBounds {
        &self.resources.extent
    }

    pub(crate) fn shares_resources(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.resources, &other.resources)
    }

    pub(crate) fn parts(&self) -> &[Part] {
        &self.resources.parts
    }

    /// Returns the deviations of the simplified index lists from the mesh, metres at rest, ascending.
    pub(crate) fn deviations_m(&self) -> &[f32] {
        &self.resources.deviations_m
    }

    /// Returns the mean opacity of each layer of hair, beginning with that of the mesh surface; empty without fur.
    pub(crate) fn layer_opacities(&self) -> &[f32] {
        &self.resources.layer_opacities
    }

    /// Returns the triangle count of the mesh (`list` 0) or of a simplified list.
    pub(crate) fn triangles(&self, list: usize) -> u32 {
        self.resources.parts.iter().filter_map(|part| part.indices.get(list)).map(|range| range.len() as u32 / 3).sum()
    }
}
