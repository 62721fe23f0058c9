//! Frame in preparation: all data that passes need to plan their work. Does not depend on any pass.

mod blocks;
mod depth;
mod dispatch;
mod fins;
mod ink;
mod nearest;
mod prepare;
mod recording;
mod ribbons;
mod screen;
mod strands;
mod visible_instance;

pub(crate) use depth::{DEPTH, MapTarget, begin_maps, light_inside_remark, record_depth};
pub(crate) use dispatch::{Dispatch, record_dispatches};
pub(crate) use fins::fin_draws;
pub(crate) use ink::{has_strokes, ink_surface_wgsl};
#[cfg(test)]
pub(crate) use nearest::{NEAREST, TILE};
pub(crate) use nearest::{NearestHairBlock, NearestSegments};
pub(crate) use prepare::{begin, drawn_lines};
pub(crate) use recording::{Recording, RendererState, depth_compare};
pub(crate) use screen::{ScreenPass, ink_screen_wgsl};
pub(crate) use strands::{posed_layout, strand_sets};
pub(crate) use visible_instance::{StrandsToDraw, VisibleContours, VisibleInstance};
