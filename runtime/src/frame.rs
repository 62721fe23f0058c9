//! A frame: its list of passes in order, and the report of what ran.

use crate::error::RuntimeError;
use crate::gpu::{Draw, Target, TargetSet, record};
use crate::hooks::Hooks;
use crate::instance::Instance;
use crate::light::{Casters, ShadowMaps};
use crate::painting::{self, PictureStroke};
use crate::params::FrameParams;
use crate::passes::*;
use crate::report::{FrameReport, PassReport};
use crate::scene::{self, NearestSegments, RendererState, VisibleInstance};
use crate::shared::receiver::ShadowReceiver;
use std::sync::Arc;

/// Passes of a frame, in order. Each line is a folder of `passes/`.
pub(crate) const PASSES: &[&Pass] = &[
    &pose::PASS,
    &fur_motion::PASS,
    &strand_pose::PASS,
    &hair_motion::PASS,
    &hair_pose::PASS,
    &strand_shadow::PASS,
    &layer_shadow::PASS,
    &shadow_width::PASS,
    &strand_light::PASS,
    &strand_gather::PASS,
    &ink_normals::PASS,
    &ink_features::PASS,
    &ink_trace::PASS,
    &ink_dilate::PASS,
    &ink_stroke::PASS,
    &painting_depth::PASS,
    &painting_strokes::PASS,
    &painting_ribbons::PASS,
    &painting_wet::PASS,
    &ink_contours::PASS,
    &ink_lines::PASS,
    &skin::PASS,
    &strands::PASS,
    &fins::PASS,
    &shells::PASS,
    &strand_blend::PASS,
    &ink_composite::PASS,
    &ink_fur::PASS,
    &painting_sheet::PASS,
    &ink_seal::PASS,
    #[cfg(test)]
    &probe::PASS,
];

impl PassId {
    /// Returns all passes in the order in which they run.
    pub fn all() -> impl ExactSizeIterator<Item = Self> + DoubleEndedIterator + Clone {
        PASSES.iter().map(|pass| Self(pass))
    }
}

/// Prepared frame: everything that [`Frame::draw`] needs. Keep it until the encoder it was drawn into is submitted.
#[derive(Debug)]
pub struct Frame {
    draws: Vec<(PassId, Vec<Draw>)>,
    shadows: Option<Arc<ShadowMaps>>,
    shadow_map: wgpu::TextureView,
    report: FrameReport,
    /// While this reference exists, no other frame writes to this frame's uniforms or to the textures it reads.
    _uniforms: Arc<()>,
    _targets: Arc<TargetSet>,
    _instances: Arc<[VisibleInstance]>,
    _nearest: Option<NearestSegments>,
}

/// Prepares a frame: plans every pass and records those that run before the picture.
pub(crate) fn prepare(
    kept: &mut RendererState,
    encoder: &mut wgpu::CommandEncoder,
    params: &FrameParams,
    instances: &[&Instance],
    hooks: Hooks<'_>,
) -> Result<Frame, RuntimeError> {
    let style = params.style.kind();
    let lines = params.style.ink().map(|ink| scene::drawn_lines(kept, ink, instances));
    let of_lines = |pass: &Pass| pass.lines.is_none() || pass.lines == lines;
    let of_style = |pass: &&&Pass| pass.styles.contains(&style) && of_lines(pass);
    let targets: Vec<Target> = PASSES.iter().filter(of_style).flat_map(|pass| pass.targets).copied().collect();
    let before = kept.gpu.created();
    let Hooks { casters, mut mark } = hooks;
    let mut recording =
        scene::begin(kept, encoder, params, lines, instances, casters.map(Casters::for_frame), &targets)?;
    let (mut draws, mut passes) = (Vec::new(), Vec::new());
    for pass in PASSES {
        let id = PassId(pass);
        let outcome = match pass.styles.contains(&style) {
            true if of_lines(pass) => (pass.run)(&mut recording),
            true => skipped_for_lines(lines),
            false => skipped_for_style(style),
        };
        if let (PassStage::Before, Some(mark)) = (id.stage(), &mut mark) {
            // Write the uniforms first: the callback may submit the commands recorded so far.
            recording.uniforms.write(recording.gpu);
            mark(recording.encoder, id);
        }
        let (ran, reason) = match outcome {
            Outcome::Skipped(why) => (false, why.into()),
            Outcome::Ran(words, planned) => {
                draws.push((id, planned));
                (true, words)
            }
        };
        passes.push(PassReport { name: id.name(), ran, reason });
    }
    let seen = recording.instances.clone();
    let instances = seen.iter().map(VisibleInstance::detail_report).collect();
    let (shadows, targets) = (recording.maps.clone(), recording.targets.clone());
    let width = shadows.as_ref().and_then(|maps| maps.width.as_ref());
    let shadow_map = width.map_or(&recording.surfaces.white, |width| &width.width.view).clone();
    let created = recording.gpu.created().since(before);
    recording.uniforms.write(recording.gpu);
    let uploaded_bytes = recording.uniforms.uploaded();
    let nearest = recording.nearest.clone();
    let target_bytes = targets.gpu_bytes() + nearest.as_ref().map_or(0, |nearest| nearest.lists.gpu_bytes());
    let hair_moves = seen.iter().any(VisibleInstance::is_animating);
    let report = FrameReport { passes, instances, hair_moves, created, uploaded_bytes, target_bytes };
    Ok(Frame {
        draws,
        shadows,
        shadow_map,
        report,
        _uniforms: recording.finish(),
        _targets: targets,
        _instances: seen,
        _nearest: nearest,
    })
}

impl Frame {
    #[cfg(test)]
    pub(crate) fn instances(&self) -> &[VisibleInstance] {
        &self._instances
    }

    /// Returns the buffers with the strokes of a frame that is painted with strokes; their usages include `COPY_SRC`.
    /// After the frame's encoder was submitted, pass copies of their contents to [`Self::strokes`].
    pub fn stroke_buffers(&self) -> Vec<&wgpu::Buffer> {
        let mut buffers = Vec::new();
        for seen in self._instances.iter() {
            buffers.extend(seen.painted.iter().map(|painted| &painted.strokes.points));
            buffers.extend(seen.contours.iter().flat_map(|lines| [&lines.buffers.counts, &lines.buffers.lines]));
        }
        buffers
    }

    /// Returns the visible strokes of a frame that is painted with strokes, in the order in which they are painted.
    ///
    /// * `contents`: of the buffers from [`Self::stroke_buffers`], in the same order
    pub fn strokes(&self, contents: &[Vec<u8>]) -> Vec<PictureStroke> {
        let mut contents = contents.iter();
        let mut strokes = Vec::new();
        for (number, seen) in self._instances.iter().enumerate() {
            if let Some((_, model, _)) = seen.painting() {
                let points = contents.next().map_or(&[][..], Vec::as_slice);
                strokes.extend(painting::surface_strokes(number, &model.kinds, points));
            }
            if seen.contours.is_some() {
                let [counts, nodes] = [0, 1].map(|_| contents.next().map_or(&[][..], Vec::as_slice));
                let count = counts.get(16..20).map_or(0, bytemuck::pod_read_unaligned::<u32>);
                strokes.extend(painting::lines(number, count as usize, nodes));
            }
        }
        strokes.sort_by_key(|stroke| stroke.layer);
        strokes
    }

    /// Returns the buffers of counts and of nodes of each instance with contour lines, which can be copied. The fifth
    /// count is the number of nodes. A node has 64 bytes; the first four numbers are its pixel position, its distance
    /// from the eye, and its visibility, and word 6 has 255 in its highest byte on creases.
    #[cfg(feature = "study")]
    pub fn contour_buffers(&self) -> impl Iterator<Item = [&wgpu::Buffer; 2]> {
        let buffers = self._instances.iter().filter_map(|seen| Some(&seen.contours.as_ref()?.buffers));
        buffers.map(|buffers| [&buffers.counts, &buffers.nodes])
    }

    #[cfg(test)]
    pub(crate) fn targets(&self) -> &TargetSet {
        &self._targets
    }

    /// Records every pass into the application's render pass. Its targets must match [`crate::RendererOptions`].
    ///
    /// Leaves pipeline, bind groups 0..=3, vertex buffers 0 and 1 and the index buffer changed.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        record(pass, self.draws.iter().flat_map(|(_, draws)| draws));
    }

    /// Records a single pass, for measurement or for drawing between the mesh surface and the shells. Passes with
    /// [`PassStage::Before`] were recorded by [`crate::Renderer::prepare`] and record nothing here.
    pub fn draw_pass(&self, id: PassId, pass: &mut wgpu::RenderPass<'_>) {
        record(pass, self.draws.iter().filter(|(found, _)| *found == id).flat_map(|(_, draws)| draws));
    }

    /// Returns the uniform block of [`crate::shared::receiver`], for application shaders that receive the key light's
    /// shadows. They also need [`Self::shadow_map`].
    ///
    /// Without a shadow-width map ([`FrameParams::soft_shadow`] off, a dark light, no instance), the block casts no
    /// shadow. One pipeline therefore serves all frames.
    pub fn shadow_receiver(&self) -> ShadowReceiver {
        self.shadows().and_then(ShadowMaps::receiver).unwrap_or_default()
    }

    /// Returns the shadow-width map in [`ShadowMaps::WIDTH_FORMAT`], or one white texel if the frame has none. Both are
    /// filterable two-dimensional float textures. The view is valid as long as [`Self::shadows`].
    pub fn shadow_map(&self) -> &wgpu::TextureView {
        &self.shadow_map
    }

    /// Returns the key light's shadow maps; `None` if the frame has none. While this frame lives, no later frame
    /// overwrites them.
    pub fn shadows(&self) -> Option<&ShadowMaps> {
        self.shadows.as_deref()
    }

    /// Returns which passes run in this frame, and why the others do not.
    pub fn report(&self) -> &FrameReport {
        &self.report
    }
}
