//! Ink-specific data of a frame: uniform blocks, and the WGSL shared by the passes over surfaces.

use super::visible_instance::VisibleInstance;
use crate::bounds::Hull;
use crate::gpu::{Gpu, UniformRange, UniformSlot};
use crate::ink::{InkFrame, InkModel, painted_rect};
use crate::model::ModelInk;
use crate::params::InkParams;
use glam::Mat4;

/// Joins the WGSL shared by the ink passes over a model's surface with the given files.
macro_rules! ink_surface_wgsl {
    ($($file:expr),+ $(,)?) => {
        &[
            include_str!("../../shared/fins.wgsl"),
            include_str!("../../shared/frame.wgsl"),
            include_str!("../../shared/ink.wgsl"),
            include_str!("../../shared/skinning.wgsl"),
            include_str!("../../shared/tile_frame.wgsl"),
            include_str!("../../surface/place.wgsl"),
            include_str!("../../ink/model.wgsl"),
            $($file,)+
        ]
    };
}
pub(crate) use ink_surface_wgsl;

/// Viewport, camera matrices and depth convention of a frame.
pub(super) struct InkView {
    pub(super) viewport: [u32; 2],
    pub(super) view_from_world: Mat4,
    pub(super) clip_from_view: Mat4,
    pub(super) reversed_depth: bool,
}

/// Ink data of a frame.
#[derive(Clone, Debug)]
pub(crate) struct InkScene {
    /// Rectangle of the picture that may be painted: left, top, width and height, pixels.
    pub(super) painted: [u32; 4],
    /// Location of the [`InkFrame`] block.
    pub(super) frame: UniformRange,
    /// Location of the [`InkModel`] blocks, one per instance.
    pub(super) models: UniformRange,
}

impl InkScene {
    pub(super) fn new(
        uniforms: &mut UniformSlot,
        gpu: &Gpu,
        params: &InkParams,
        view: &InkView,
        instances: &[VisibleInstance],
    ) -> Self {
        let models: Vec<_> = instances
            .iter()
            .filter_map(|seen| seen.model.ink())
            .map(|ink| InkModel::new(ink, params, view.viewport, view.view_from_world, view.clip_from_view))
            .collect();
        let mut hull = Hull::default();
        instances.iter().filter(|seen| seen.in_picture()).for_each(|seen| hull.0.extend(&seen.moved.hull.0));
        let constants = InkFrame::new(params, view.viewport, view.clip_from_view, view.reversed_depth);
        Self {
            painted: painted_rect(&hull, view.clip_from_view * view.view_from_world, params, view.viewport),
            frame: uniforms.put(gpu, &[constants]),
            models: uniforms.put(gpu, &models),
        }
    }
}

/// Returns whether a model has fur strokes to draw.
pub(crate) fn has_strokes(seen: &VisibleInstance, params: &InkParams) -> bool {
    let fur = |ink: &ModelInk| params.shading.unwrap_or(ink.info.shading).fur;
    seen.model.ink().is_some_and(|ink| ink.fur.is_some() && fur(ink) > 0.0)
}
