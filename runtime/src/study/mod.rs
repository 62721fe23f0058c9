//! What only measuring needs: the forms that the papers print beside those that pelage draws with, single layers, the yardstick. Compiled
//! with the feature `study`; without it [`off.rs`](../off.rs) stands here, and neither code nor shaders know of any of this.
//!
//! Shaders keep what has another form in files of their own (`light/forms.wgsl`, `light/deep_forms.wgsl`, `ink/line_forms.wgsl`, `ink/surface_forms.wgsl`): here are files
//! that take their place. [`amend`] then turns a pipeline that a pass asks for into the one that is studied.

use crate::gpu::{ComputeSpec, RenderSpec, Shader, on};
use crate::params::{
    Anchoring, FeatureRule, FrameParams, FurShow, InkShow, Lighting, OpacityForm, PenumbraForm, SlantForm,
};
use crate::shared::kajiya_kay;

macro_rules! form_wgsl {
    ("light") => {
        include_str!("../../study/forms.wgsl")
    };
    ("shown") => {
        include_str!("../../study/shown.wgsl")
    };
    ("behind strands") => {
        include_str!("../../study/shown_strands.wgsl")
    };
    ("behind strand_blend") => {
        include_str!("../../study/shown_blend.wgsl")
    };
    ("strand shadows") => {
        include_str!("../../study/deep_forms.wgsl")
    };
    ("ink lines") => {
        include_str!("../../study/ink_line_forms.wgsl")
    };
    ("ink surfaces") => {
        include_str!("../../study/ink_surface_forms.wgsl")
    };
    ("behind shells") => {
        include_str!("../../study/yardstick.wgsl")
    };
    ("behind ink_composite") => {
        include_str!("../../study/ink_show.wgsl")
    };
}
pub(crate) use form_wgsl;

/// The pipeline that is studied instead of `spec`.
pub(crate) fn amend(params: &FrameParams, spec: &mut RenderSpec) {
    let study = &params.study;
    let lit = [
        on("LOOK_SLANTED", study.look_slant == SlantForm::Corrected),
        on("LIGHT_SLANTED", light_is_slanted(params)),
        on("CENTRED", penumbra_is_centred(params)),
        on("VERTEX_LIGHTING", study.lighting == Lighting::Vertex),
    ];
    // Tables are looked up where hair is seen.
    let by_tables = spec.constants.contains(&on("SCATTERING", true));
    let lit = lit.map(|(name, value)| (name, if name == "VERTEX_LIGHTING" && by_tables { 0 } else { value }));
    let Shader { name, .. } = spec.shader;
    let shown = ("SHOW_AS", study.fur as u32);
    match name {
        "pelage shells" if study.yardstick => {
            (spec.vertex, spec.fragment) = ("vs_yardstick", Some("fs_yardstick"));
            spec.constants.retain(|(name, _)| ["LEAN", "DETAIL"].contains(name));
        }
        "pelage skin" | "pelage fins" | "pelage shells" => {
            spec.constants.extend(lit);
            spec.constants.push(shown);
        }
        "pelage strands" | "pelage strand blend"
            if study.fur != FurShow::Picture && spec.fragment != Some("fs_depth") =>
        {
            spec.fragment = Some("fs_shown");
            spec.constants.push(shown);
        }
        "pelage layer shadow" => spec.constants.extend(&lit[1..2]),
        "pelage ink normals" => {
            spec.constants.push(("SPHERE_MAP", study.sphere_map as u32));
            spec.constants.push(on("ON_SCREEN", study.anchoring == Anchoring::Screen));
        }
        "pelage ink features" => spec.constants.push(on("ALL_BELOW", study.features == FeatureRule::AllBelow)),
        "pelage ink trace" => {
            spec.constants.push(on("FOLLOWED", !study.printed_lines && study.features == FeatureRule::AnyBelow));
        }
        "pelage ink dilate" => spec.constants.push(on("SQUARES", study.printed_lines)),
        "pelage ink stroke" => spec.constants.extend([
            on("SQUARES", study.printed_lines),
            on("HARD", study.printed_lines),
            on("TEMPLATE", study.template),
        ]),
        "pelage ink composite" => {
            spec.constants.push(on("SOFT", !study.printed_lines));
            if !paints(params) {
                spec.fragment = Some("fs_show");
                spec.constants.retain(|(name, _)| *name != "PICTURE");
                spec.constants.push(("SHOW", study.show as u32));
            }
        }
        _ => {}
    }
}

/// The same of what is computed.
pub(crate) fn amend_compute(params: &FrameParams, spec: &mut ComputeSpec) {
    let of_slabs = [
        on("WHOLE_DEPTH", opacity_spans_all(params)),
        on("PRINTED_SPACING", spacing_is_printed(params)),
        on("ON_AXIS", params.study.light_on_axis),
    ];
    match (spec.shader.name, spec.entry) {
        ("pelage strand light", "light_strands") => {
            spec.constants.push(on("CENTRED", penumbra_is_centred(params)));
            spec.constants.extend(of_slabs);
        }
        ("pelage strand shadow", "add_opacity") => spec.constants.extend(of_slabs),
        _ => {}
    }
}

/// Whether the slabs of strands' shadows divide the whole depth of the hair.
pub(crate) fn opacity_spans_all(params: &FrameParams) -> bool {
    params.study.opacity != OpacityForm::Deep
}

/// Whether they do with the printed spacing.
pub(crate) fn spacing_is_printed(params: &FrameParams) -> bool {
    params.study.opacity == OpacityForm::Printed
}

/// Whether the texels of strands' shadows may be narrower than a strand.
pub(crate) fn texels_may_be_thin(params: &FrameParams) -> bool {
    params.study.thin_texels
}

/// Pieces that strands are drawn in, where the size on screen does not say.
pub(crate) fn strand_pieces(params: &FrameParams) -> Option<u32> {
    params.study.strand_pieces
}

/// Whether the light's way through a layer grows with its slant.
pub(crate) fn light_is_slanted(params: &FrameParams) -> bool {
    params.study.light_slant == SlantForm::Corrected
}

/// Whether the penumbra lies on both sides of the hard edge.
pub(crate) fn penumbra_is_centred(params: &FrameParams) -> bool {
    params.study.penumbra == PenumbraForm::Centred
}

/// r of Attenu_Back.
pub(crate) fn back_light_range(params: &FrameParams, range: f32) -> f32 {
    if params.study.back_attenuation { range } else { kajiya_kay::BACK_ATTENUATION_OFF }
}

/// ε of γ.
pub(crate) fn ambient_floor(params: &FrameParams, floor: f32) -> f32 {
    if params.study.ambient_attenuation { floor } else { 1.0 }
}

/// The one layer that is drawn, where it is not all.
pub(crate) fn only_layer(params: &FrameParams) -> Option<u32> {
    params.study.only_layer
}

/// What is said of shells besides.
pub(crate) fn words_of_shells(params: &FrameParams) -> &'static str {
    if params.study.yardstick { ", yardstick: one read, no lighting" } else { "" }
}

/// Whether the painting is shown, and not a part of it.
pub(crate) fn paints(params: &FrameParams) -> bool {
    params.study.show == InkShow::Painting
}

/// Whether features stand in for the lines.
pub(crate) fn shows_features(params: &FrameParams) -> bool {
    params.study.show == InkShow::Features
}
