// Slabs of a deep opacity map, or of an opacity shadow map (formulas 4.10); override constants select the form. The
// slabs of an opacity shadow map divide the whole depth of the hair (Nguyen and Donnelly 2005, "Hair Animation and
// Rendering in the Nalu Demo"). Replaces light/deep_forms.wgsl in studies.

// Whether the slabs divide the whole depth of the hair, as in an opacity shadow map.
override WHOLE_DEPTH: bool = false;
// Whether the published spacing is used: the last plane is a sixteenth of the depth before the end. Hair behind it is
// in no plane, and no plane shadows it.
override PRINTED_SPACING: bool = false;
// Whether the light of a strand is looked up on its axis rather than on the side facing the eye.
override ON_AXIS: bool = false;

fn slabs_begin(first: f32, whole: f32) -> f32 {
    return select(first, whole, WHOLE_DEPTH);
}

fn is_kept(behind: f32, slabs: u32) -> bool {
    return !PRINTED_SPACING || behind < f32(slabs);
}

fn shadowing(behind: f32, slabs: u32) -> f32 {
    // The weight of a plane, max(0, 1 - |z - z_i| / dz), falls to 0 one spacing behind the last plane.
    return select(1.0, clamp(f32(slabs) + 1.0 - behind, 0.0, 1.0), PRINTED_SPACING);
}

fn radii_towards_eye() -> f32 {
    return select(1.0, 0.0, ON_AXIS);
}
