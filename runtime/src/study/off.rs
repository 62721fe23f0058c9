//! In the place of [`study`](mod.rs) without the feature: pelage draws with its own forms alone.

use crate::gpu::{ComputeSpec, RenderSpec};
use crate::params::FrameParams;

macro_rules! form_wgsl {
    ("light") => {
        include_str!("../../light/forms.wgsl")
    };
    ("strand shadows") => {
        include_str!("../../light/deep_forms.wgsl")
    };
    ("ink lines") => {
        include_str!("../../ink/line_forms.wgsl")
    };
    ("ink surfaces") => {
        include_str!("../../ink/surface_forms.wgsl")
    };
    ($behind:literal) => {
        ""
    };
}
pub(crate) use form_wgsl;

pub(crate) fn amend(_: &FrameParams, _: &mut RenderSpec) {}

pub(crate) fn amend_compute(_: &FrameParams, _: &mut ComputeSpec) {}

pub(crate) fn opacity_spans_all(_: &FrameParams) -> bool {
    false
}

pub(crate) fn spacing_is_printed(_: &FrameParams) -> bool {
    false
}

pub(crate) fn texels_may_be_thin(_: &FrameParams) -> bool {
    false
}

pub(crate) fn strand_pieces(_: &FrameParams) -> Option<u32> {
    None
}

pub(crate) fn light_is_slanted(_: &FrameParams) -> bool {
    true
}

pub(crate) fn penumbra_is_centred(_: &FrameParams) -> bool {
    true
}

pub(crate) fn back_light_range(_: &FrameParams, range: f32) -> f32 {
    range
}

pub(crate) fn ambient_floor(_: &FrameParams, floor: f32) -> f32 {
    floor
}

pub(crate) fn only_layer(_: &FrameParams) -> Option<u32> {
    None
}

pub(crate) fn words_of_shells(_: &FrameParams) -> &'static str {
    ""
}

pub(crate) fn paints(_: &FrameParams) -> bool {
    true
}

pub(crate) fn shows_features(_: &FrameParams) -> bool {
    false
}
