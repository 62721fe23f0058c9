//! Geometry of the application that casts and receives shadows.

use super::view::LightView;
use crate::bounds::Sphere;

/// Geometry of the application that casts shadows on the fur and receives the fur's shadows. Pass it to
/// [`crate::Renderer::prepare_with`] in every frame.
///
/// Include geometry that only receives, such as a ground: the maps must store where a shadow falls. The application's
/// own shader then reads them with [`crate::shared::receiver`]. `cargo run --example shadows_on_your_ground` shows all
/// of it.
///
/// `draw` records the geometry into a depth-only pass, with one pipeline of the application for each [`CasterPass`]:
///
/// * depth format [`crate::ShadowMaps::DEPTH_FORMAT`], depth written, compared by [`CasterPass::compare`]
/// * [`CasterPass::cull_mode`] with counter-clockwise fronts
/// * one sample, no colour target
/// * positions transformed by [`LightView::clip_from_world`]
///
/// `draw` is called while the frame is prepared: once for each map that is redrawn, and not at all if the maps are
/// reused. Store the matrix in a new buffer that `draw` creates. A buffer written for several frames of one submission
/// would hold the last matrix for all of them.
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
    /// Bounds that the maps must cover in addition to the furry instances: all objects that cast or receive a shadow.
    /// Objects outside cast no shadow and are fully lit. `None` adds nothing.
    ///
    /// Keep the bounds close to the fur, because larger bounds give larger texels. An object casts no shadow on a
    /// surface that is very near to it: nearer than a thousandth of the bounds' size.
    pub bounds: Option<Sphere>,
    /// Revision; change it whenever the geometry changes. While it stays the same, the maps are reused.
    pub revision: u64,
    /// Callback that records the draws, as described above.
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
    /// Reborrows the casters for a shorter lifetime.
    pub(crate) fn for_frame<'f>(self) -> Casters<'f>
    where
        'a: 'f,
    {
        Casters { bounds: self.bounds, revision: self.revision, draw: self.draw }
    }
}

/// Depth maps into which casters are drawn, both with the same geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CasterPass {
    /// Surface nearest to the light; it casts the shadows.
    Nearest,
    /// Farthest surface that faces the light; it receives shadows. Drawn only for soft shadows.
    Farthest,
}

impl CasterPass {
    /// Returns the depth comparison of the pipeline; depth writes are enabled.
    pub fn compare(self) -> wgpu::CompareFunction {
        match self {
            Self::Nearest => wgpu::CompareFunction::LessEqual,
            Self::Farthest => wgpu::CompareFunction::GreaterEqual,
        }
    }

    /// Returns the faces to cull of closed objects. Sheets visible from both sides need no culling, and receive shadows
    /// on both sides.
    pub fn cull_mode(self) -> Option<wgpu::Face> {
        match self {
            Self::Nearest => None,
            Self::Farthest => Some(wgpu::Face::Back),
        }
    }

    /// Returns the clear value of the depth.
    pub(crate) fn clear(self) -> f32 {
        match self {
            Self::Nearest => 1.0,
            Self::Farthest => 0.0,
        }
    }
}
