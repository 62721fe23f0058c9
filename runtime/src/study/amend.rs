//! Modification of pipelines for studies, selected by shader name.

use super::{light_is_slanted, opacity_spans_all, penumbra_is_centred, spacing_is_printed};
use crate::gpu::{ComputeSpec, RenderSpec, flag};
use crate::params::{Anchoring, FeatureRule, FrameParams, LightingStage, SlantForm};

/// Replaces the pipeline in `spec` by its study variant.
pub(crate) fn amend(params: &FrameParams, spec: &mut RenderSpec) {
    let study = &params.study;
    let lit = [
        flag("LOOK_SLANTED", study.view_slant == SlantForm::Corrected),
        flag("LIGHT_SLANTED", light_is_slanted(params)),
        flag("CENTRED", penumbra_is_centred(params)),
        // Scattering tables are sampled per fragment, so they cannot be combined with lighting at vertices.
        flag(
            "VERTEX_LIGHTING",
            study.lighting == LightingStage::Vertex && !spec.constants.contains(&flag("SCATTERING", true)),
        ),
    ];
    match spec.shader.name {
        "pelage skin" | "pelage fins" | "pelage shells" => spec.constants.extend(lit),
        "pelage layer shadow" => spec.constants.extend(&lit[1..2]),
        "pelage ink normals" => {
            spec.constants.push(("SPHERE_MAP", study.sphere_map as u32));
            spec.constants.push(flag("ON_SCREEN", study.anchoring == Anchoring::Screen));
        }
        "pelage ink features" => spec.constants.push(flag("ALL_BELOW", study.features == FeatureRule::AllBelow)),
        "pelage ink trace" => {
            spec.constants.push(flag("FOLLOWED", !study.printed_lines && study.features == FeatureRule::AnyBelow));
        }
        "pelage ink dilate" => spec.constants.push(flag("SQUARES", study.printed_lines)),
        "pelage ink stroke" => spec.constants.extend([
            flag("SQUARES", study.printed_lines),
            flag("HARD", study.printed_lines),
            flag("TEMPLATE", study.template),
        ]),
        "pelage ink composite" => spec.constants.push(flag("SOFT", !study.printed_lines)),
        _ => {}
    }
}

/// Returns the study variant of a compute pipeline.
pub(crate) fn amend_compute(params: &FrameParams, mut spec: ComputeSpec) -> ComputeSpec {
    let of_slabs = [
        flag("WHOLE_DEPTH", opacity_spans_all(params)),
        flag("PRINTED_SPACING", spacing_is_printed(params)),
        flag("ON_AXIS", params.study.light_on_axis),
    ];
    match (spec.shader.name, spec.entry) {
        ("pelage strand light", "light_strands") => {
            spec.constants.push(flag("CENTRED", penumbra_is_centred(params)));
            spec.constants.extend(of_slabs);
        }
        ("pelage strand shadow", "add_opacity") => spec.constants.extend(of_slabs),
        _ => {}
    }
    spec
}
