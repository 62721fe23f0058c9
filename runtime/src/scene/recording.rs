//! Frame in preparation: all data that passes need to plan their work.

use super::ink::InkScene;
use super::nearest::{NearestBuffers, NearestSegments};
use super::ribbons::Ribbons;
use super::visible_instance::VisibleInstance;
use crate::contours::ContourBuffers;
use crate::debug;
use crate::gpu::{
    Cache, ComputeSpec, Constants, Draw, DrawBindGroup, Gpu, Pool, RenderSpec, Shader, TargetSet, UniformRange,
    UniformRing, UniformSlot, depth_state, primitive_state,
};
use crate::ink::SealTexture;
use crate::light::{Casters, EnvironmentCache, ShadowMaps};
use crate::model::Part;
use crate::motion::OwnerStates;
use crate::painting::PaintedStrokes;
use crate::params::{FrameParams, RendererOptions};
#[cfg(feature = "study")]
use crate::study;
use crate::surface::{STREAMS, Surfaces};
use std::ops::Range;
use std::sync::Arc;

/// State that a renderer keeps between frames.
#[derive(Debug)]
pub(crate) struct RendererState {
    pub(crate) gpu: Gpu,
    pub(crate) cache: Cache,
    pub(crate) surfaces: Surfaces,
    pub(crate) options: RendererOptions,
    pub(crate) states: OwnerStates,
    pub(crate) shadows: Pool<ShadowMaps>,
    pub(crate) ribbons: Pool<Ribbons>,
    pub(crate) contours: Pool<ContourBuffers>,
    pub(crate) nearest: Pool<NearestBuffers>,
    pub(crate) painted: Pool<PaintedStrokes>,
    pub(crate) skies: EnvironmentCache,
    pub(crate) seal: SealTexture,
    pub(crate) ring: UniformRing,
}

/// Data with which passes plan a frame, and the encoder that they record into.
pub(crate) struct Recording<'f> {
    pub(crate) gpu: &'f Gpu,
    pub(crate) cache: &'f mut Cache,
    pub(crate) surfaces: &'f Surfaces,
    pub(crate) options: &'f RendererOptions,
    pub(crate) params: &'f FrameParams,
    pub(crate) encoder: &'f mut wgpu::CommandEncoder,
    /// Instances in the order in which the application gave them.
    pub(crate) instances: Arc<[VisibleInstance]>,
    /// Shadow maps of the key light, if the frame has any.
    pub(crate) maps: Option<Arc<ShadowMaps>>,
    pub(crate) casters: Option<Casters<'f>>,
    /// Buffers of the nearest hair segments, if strands are drawn with blended edges.
    pub(crate) nearest: Option<NearestSegments>,
    /// Textures of the picture's size that passes share.
    pub(crate) targets: Arc<TargetSet>,
    pub(crate) ink: Option<InkScene>,
    pub(crate) seal: &'f mut SealTexture,
    /// Location of the [`crate::painting::PaintingFrame`] block, if ink is painted with strokes.
    pub(crate) painting: Option<UniformRange>,
    pub(crate) uniforms: UniformSlot,
    pub(super) ring: &'f mut UniformRing,
    /// Bind group 0 for the eye.
    pub(super) view: wgpu::BindGroup,
    /// Bind group 0 for the key light; `None` if the shadow maps are not redrawn.
    pub(super) light: Option<wgpu::BindGroup>,
}

impl Recording<'_> {
    /// Returns the pipeline of a specification, with the changes that the study and the debug view require.
    pub(crate) fn pipeline(&mut self, mut spec: RenderSpec) -> wgpu::RenderPipeline {
        #[cfg(feature = "study")]
        study::amend(self.params, &mut spec);
        debug::amend(self.params, &mut spec);
        self.cache.pipelines.render(self.gpu, spec)
    }

    /// Returns the compute pipeline of a specification, with the changes that the study requires.
    pub(crate) fn compute_pipeline(&mut self, spec: ComputeSpec) -> wgpu::ComputePipeline {
        #[cfg(feature = "study")]
        let spec = study::amend_compute(self.params, spec);
        self.cache.pipelines.compute(self.gpu, spec)
    }

    /// Returns draws of the `wanted` parts of an instance, with one instance for each of `layers`. `at`: bind group 0;
    /// `hair`: bind group 2; `spec`: returns the pipeline of a part.
    pub(crate) fn part_draws(
        &mut self,
        seen: &VisibleInstance,
        wanted: impl Fn(&Part) -> bool,
        [at, hair]: [Option<DrawBindGroup>; 2],
        layers: Range<u32>,
        spec: impl Fn(&Self, &Part) -> RenderSpec,
    ) -> Vec<Draw> {
        let mut draws = Vec::new();
        for part in seen.model.parts().iter().filter(|part| wanted(part)) {
            // A part may be empty in a simplified index list.
            let Some(range) = part.indices.get(seen.drawing.list).filter(|range| !range.is_empty()) else { continue };
            let spec = spec(self, part);
            let pipeline = self.pipeline(spec);
            draws.push(Draw {
                pipeline,
                groups: [at.clone(), DrawBindGroup::of(&part.material), hair.clone(), None],
                vertices: [Some(seen.moved.geometry.clone()), Some(seen.model.attributes().clone()), None, None, None],
                indices: Some(seen.model.indices().clone()),
                range: range.clone(),
                instances: layers.clone(),
                indirect: None,
            });
        }
        draws
    }

    /// Returns the specification of a surface pipeline for the application's pass: opaque, or blended if `over`. Passes
    /// with other targets override its fields.
    pub(crate) fn picture_spec(
        &self,
        shader: Shader,
        [vertex, fragment]: [&'static str; 2],
        constants: Constants,
        [mirrored, double_sided]: [bool; 2],
        over: bool,
    ) -> RenderSpec {
        let surfaces = self.surfaces;
        RenderSpec {
            shader,
            vertex,
            fragment: Some(fragment),
            groups: vec![surfaces.frame.clone(), surfaces.material.clone(), surfaces.fur.clone()],
            streams: STREAMS.to_vec(),
            constants,
            primitive: primitive_state(mirrored, double_sided),
            colors: vec![self.picture_color(over)],
            // The strict comparison hides layers that coincide with the mesh surface, which is fur of height 0.
            depth: Some(self.picture_depth(true, over)),
            samples: self.options.sample_count,
        }
    }

    /// Returns the state of the application's colour target. `over`: blend premultiplied colours over it.
    pub(crate) fn picture_color(&self, over: bool) -> wgpu::ColorTargetState {
        wgpu::ColorTargetState {
            format: self.options.color_format,
            blend: over.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
            write_mask: wgpu::ColorWrites::ALL,
        }
    }

    /// Returns the state of the application's depth target. Nearer fragments pass; equally near ones also, unless
    /// `strictly`.
    pub(crate) fn picture_depth(&self, write: bool, strictly: bool) -> wgpu::DepthStencilState {
        depth_state(self.options.depth_format, write, depth_compare(strictly, self.options.reversed_depth))
    }

    /// Returns bind group 0 of an instance for the eye.
    pub(crate) fn eye_group(&self, seen: &VisibleInstance) -> Option<DrawBindGroup> {
        DrawBindGroup::at(&self.view, seen.view_offset)
    }

    /// Returns whether the shadow maps are redrawn.
    pub(crate) fn redraws_maps(&self) -> bool {
        self.light.is_some()
    }

    /// Returns bind group 0 of an instance for the key light; `None` if the maps are not redrawn.
    pub(crate) fn light_group(&self, seen: &VisibleInstance) -> Option<DrawBindGroup> {
        self.light.as_ref().and_then(|group| DrawBindGroup::at(group, seen.light_offset))
    }

    /// Returns the uniform slot to the ring. The frame keeps the returned handle, which marks the slot as in use.
    pub(crate) fn finish(self) -> Arc<()> {
        self.ring.release(self.uniforms, self.encoder)
    }
}

/// Returns the comparison with which nearer fragments pass the depth test; equally near ones also, unless `strictly`.
pub(crate) fn depth_compare(strictly: bool, reversed_depth: bool) -> wgpu::CompareFunction {
    match (strictly, reversed_depth) {
        (true, false) => wgpu::CompareFunction::Less,
        (true, true) => wgpu::CompareFunction::Greater,
        (false, false) => wgpu::CompareFunction::LessEqual,
        (false, true) => wgpu::CompareFunction::GreaterEqual,
    }
}
