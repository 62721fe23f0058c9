//! Frame during preparation: all data that passes plan with. Does not depend on any pass.

mod prepare;
mod blocks;
mod depth;
mod dispatch;
mod fins;
mod ink;
mod nearest;
mod recording;
mod ribbons;
mod screen;
mod visible_instance;
mod strands;

pub(crate) use prepare::begin;
pub(crate) use depth::{DEPTH, MapTarget, begin_maps, light_inside_remark, record_depth};
pub(crate) use dispatch::{Dispatch, record_dispatches};
pub(crate) use fins::fin_draws;
pub(crate) use ink::{has_strokes, ink_surface_wgsl};
#[cfg(test)]
pub(crate) use nearest::{NEAREST, TILE};
pub(crate) use nearest::{NearestSegments, NearestHairBlock};
pub(crate) use recording::{RendererState, Recording, depth_compare};
pub(crate) use screen::{ScreenPass, ink_screen_wgsl};
pub(crate) use visible_instance::{VisibleInstance, StrandSet};
pub(crate) use strands::{posed_layout, strand_sets};
