//! Output of pipelines: tone mapping, and debug views, which show something other than the final picture. Frames
//! without them pay no cost.

use crate::gpu::RenderSpec;
use crate::params::{FrameParams, FurDebugView, InkDebugView, ToneMapping};

/// Changes the pipeline in `spec` to its variant for the frame's tone mapping and debug view.
pub(crate) fn amend(params: &FrameParams, spec: &mut RenderSpec) {
    let view = &params.debug;
    match spec.shader.name {
        "pelage shells" if view.yardstick => {
            (spec.vertex, spec.fragment) = ("vs_yardstick", Some("fs_yardstick"));
            spec.constants.retain(|(name, _)| ["LEAN", "DETAIL"].contains(name));
        }
        "pelage skin" | "pelage fins" | "pelage shells" | "pelage strands" | "pelage strand blend"
            if view.fur != FurDebugView::Picture && spec.fragment != Some("fs_depth") =>
        {
            spec.constants.push(("SHOW_AS", view.fur as u32));
        }
        "pelage skin" | "pelage fins" | "pelage shells" | "pelage strands" | "pelage strand blend"
            if params.tone_mapping == ToneMapping::Filmic && spec.fragment != Some("fs_depth") =>
        {
            spec.constants.push(("TONE", 1));
        }
        "pelage ink composite" if view.ink != InkDebugView::Painting => {
            spec.fragment = Some("fs_show");
            spec.constants.retain(|(name, _)| *name != "PICTURE");
            spec.constants.push(("SHOW", view.ink as u32));
        }
        _ => {}
    }
}
