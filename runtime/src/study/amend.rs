//! Modification of pipelines for studies, by shader name.

use super::{light_is_slanted, opacity_spans_all, penumbra_is_centred, spacing_is_printed};
use crate::gpu::{ComputeSpec, RenderSpec, on};
use crate::params::{Anchoring, FeatureRule, FrameParams, Lighting, SlantForm};

/// Replaces a requested pipeline by its study variant.
pub(crate) fn amend(params: &FrameParams, spec: &mut RenderSpec) {
    let study = &params.study;
    let lit = [
        on("LOOK_SLANTED", study.look_slant == SlantForm::Corrected),
        on("LIGHT_SLANTED", light_is_slanted(params)),
        on("CENTRED", penumbra_is_centred(params)),
        // Scattering tables are read per fragment.
        on("VERTEX_LIGHTING", study.lighting == Lighting::Vertex && !spec.constants.contains(&on("SCATTERING", true))),
    ];
    match spec.shader.name {
        "pelage skin" | "pelage fins" | "pelage shells" => spec.constants.extend(lit),
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
        "pelage ink composite" => spec.constants.push(on("SOFT", !study.printed_lines)),
        _ => {}
    }
}

/// Replaces a compute pipeline by its study variant.
pub(crate) fn amend_compute(params: &FrameParams, mut spec: ComputeSpec) -> ComputeSpec {
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
    spec
}
