//! The application's own geometry among the shadows.

use super::view::LightView;
use crate::bounds::Sphere;

/// The application's own geometry among the shadows: it throws shadows on the fur, and the fur on it. Give it to
/// [`crate::Renderer::prepare_with`] in every frame.
///
/// What only receives, such as a ground, belongs to it as well: the maps must know where a shadow falls. The application's own shader
/// then reads them with [`crate::shared::receiver`]. `cargo run --example shadows_on_your_ground` shows all of it.
///
/// `draw` records the geometry into a pass of depth alone, with pipelines of the application's own, one for each [`CasterPass`]:
/// depth format [`crate::ShadowMaps::DEPTH_FORMAT`], depth written, [`CasterPass::compare`], [`CasterPass::cull_mode`] with
/// counter-clockwise fronts, one sample, no colour target, and positions put through [`LightView::clip_from_world`]. It is called
/// while the frame is prepared, once for each of the maps that are drawn anew, and not at all where they are kept. Keep the matrix
/// in a buffer made there: one that is written for several frames of one submission would hold the last of them for all.
///
/// ```no_run
/// # use pelage_runtime::{wgpu, *};
/// # fn f(renderer: &mut Renderer, encoder: &mut wgpu::CommandEncoder, params: &FrameParams,
/// #      fox: &Instance, scene_bounds: Sphere, frames_with_changes: u64,
/// #      draw_scene_depth: &dyn Fn(&mut wgpu::RenderPass<'_>, glam::Mat4, CasterPass)) -> Result<(), RuntimeError> {
/// let mut draw = |pass: &mut wgpu::RenderPass<'_>, view: &LightView, which: CasterPass| {
///     draw_scene_depth(pass, view.clip_from_world, which);
/// };
/// let casters = Casters { bounds: Some(scene_bounds), revision: frames_with_changes, draw: &mut draw };
/// let frame = renderer.prepare_with(encoder, params, [fox], Hooks::default().casters(casters))?;
/// // For a bind group of the application's own pipeline, whose shader calls `light_received`:
/// let (uniform, texture) = (frame.shadow_receiver(), frame.shadow_map());
/// # Ok(()) }
/// ```
pub struct Casters<'a> {
    /// What the maps must cover besides the furry things: whatever throws a shadow or receives one. What lies beyond throws none
    /// and is lit. Keep them to the fur's surroundings: the larger they are, the larger the maps' texels, and things nearer to what
    /// they shade than a thousandth of the bounds throw no shadow on it. `None` adds nothing.
    pub bounds: Option<Sphere>,
    /// A number that is another whenever the geometry is; the maps are kept while it stays the same.
    pub revision: u64,
    /// Records the draws, as said above.
    pub draw: &'a mut dyn FnMut(&mut wgpu::RenderPass<'_>, &LightView, CasterPass),
}

impl std::fmt::Debug for Casters<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Casters")
            .field("bounds", &self.bounds)
            .field("revision", &self.revision)
            .finish_non_exhaustive()
    }
}

impl<'a> Casters<'a> {
    /// The same for a shorter time.
    pub(crate) fn for_frame<'f>(self) -> Casters<'f>
    where
        'a: 'f,
    {
        Casters { bounds: self.bounds, revision: self.revision, draw: self.draw }
    }
}

/// The two depth maps that casters are drawn into. Both get the same geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CasterPass {
    /// What the light reaches first: it throws the shadows.
    Nearest,
    /// The farthest surface that faces the light: it receives them. Drawn only for soft shadows.
    Farthest,
}

impl CasterPass {
    /// Depth comparison of the pipeline, which writes depth.
    pub fn compare(self) -> wgpu::CompareFunction {
        match self {
            Self::Nearest => wgpu::CompareFunction::LessEqual,
            Self::Farthest => wgpu::CompareFunction::GreaterEqual,
        }
    }

    /// Which faces of closed things to leave out. Sheets that are seen from both sides leave out none, and receive on both.
    pub fn cull_mode(self) -> Option<wgpu::Face> {
        match self {
            Self::Nearest => None,
            Self::Farthest => Some(wgpu::Face::Back),
        }
    }

    /// What depth is cleared to.
    pub(crate) fn clear(self) -> f32 {
        match self {
            Self::Nearest => 1.0,
            Self::Farthest => 0.0,
        }
    }
}
