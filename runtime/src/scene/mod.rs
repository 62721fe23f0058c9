//! Frame during preparation: all data that passes plan with. Does not depend on any pass.

mod begin;
mod blocks;
mod depth;
mod dispatch;
mod fins;
mod ink;
mod nearest;
mod recording;
mod ribbons;
mod screen;
mod seen;
mod strands;

pub(crate) use begin::begin;
pub(crate) use depth::{DEPTH, MapTarget, begin_maps, light_inside, record_depth};
pub(crate) use dispatch::{Dispatch, record_dispatches};
pub(crate) use fins::fin_draws;
pub(crate) use ink::{has_strokes, ink_surface_wgsl};
#[cfg(test)]
pub(crate) use nearest::{NEAREST, TILE};
pub(crate) use nearest::{Nearest, NearestHair};
pub(crate) use recording::{Kept, Recording, nearer};
pub(crate) use screen::{Screen, ink_screen_wgsl};
pub(crate) use seen::{Seen, StrandSet};
pub(crate) use strands::{posed_layout, strand_sets};
