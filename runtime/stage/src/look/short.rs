//! Short forms of the look's knobs: command-line flags that can also be used in the table `[view]` of scene files.

/// Flag that sets a knob of the look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShortForm {
    /// Flag without its dashes: `shadow-map`.
    pub flag: &'static str,
    /// Name of the flag's value in the help text.
    pub value_name: &'static str,
    /// Key of the knob: `shadow.map_texels`.
    pub key: &'static str,
    /// Whether the flag may be repeated and appends to a list.
    pub repeats: bool,
}

const fn short(flag: &'static str, value_name: &'static str, key: &'static str) -> ShortForm {
    ShortForm { flag, value_name, key, repeats: false }
}

/// Flags shared by all commands that draw.
pub const SHORT_FORMS: &[ShortForm] = &[
    short("size", "WxH", "picture.size"),
    short("style", "STYLE", "picture.style"),
    short("light", "X,Y,Z", "light.direction"),
    short("point-light", "X,Y,Z", "light.position_m"),
    ShortForm { flag: "fill-light", value_name: "X,Y,Z[/S]", key: "light.fill", repeats: true },
    short("light-strength", "S", "light.strength"),
    short("studio", "auto|old", "light.studio"),
    short("environment", "SKY[:YAW]", "environment.sky"),
    short("environment-strength", "S", "environment.strength"),
    short("environment-lobes", "N", "environment.lobes"),
    short("ground", "COLOR", "environment.ground"),
    short("layers", "N", "fur.layers"),
    short("detail", "full|auto|LEVEL", "fur.detail"),
    short("hair", "auto|shells|strands", "fur.hair"),
    short("strand-edges", "samples|blended", "fur.strand_edges"),
    short("self-shadow", "auto|baked|maps|off", "shadow.self_shadow"),
    short("soft-shadow", "on|off", "shadow.soft_shadow"),
    short("penumbra", "W", "shadow.penumbra"),
    short("penumbra-form", "FORM", "study.penumbra_form"),
    short("shadow-shrink", "N", "shadow.shrink"),
    short("shadow-map", "N", "shadow.map_texels"),
    short("shadow-layers", "N", "shadow.map_layers"),
    short("shadow-density", "D", "shadow.density"),
    short("slant", "FORM", "study.slant"),
    short("view-slant", "FORM", "study.view_slant"),
    short("ambient-attenuation", "on|off", "study.ambient_attenuation"),
    short("back-attenuation", "on|off", "study.back_attenuation"),
    short("fins", "on|off", "fur.fins"),
    short("lighting", "WHERE", "study.lighting"),
    short("scattering", "multiple|single|off", "fur.scattering"),
    short("background", "studio|sky|R,G,B", "picture.background"),
    short("ground-shadow", "on|off", "picture.ground_shadow"),
    short("exposure", "STOPS", "picture.exposure"),
    short("tone-mapping", "auto|filmic|off", "picture.tone_mapping"),
    short("hair-motion", "on|off", "motion.hair"),
    short("fur-motion", "SHARE", "motion.fur"),
    short("wind", "X,Y,Z", "motion.wind"),
    short("gust", "SHARE", "motion.gust"),
    short("gust-seconds", "S", "motion.gust_s"),
    short("turbulence", "SHARE", "motion.turbulence"),
    short("eddy", "M", "motion.eddy_m"),
    short("gravity", "SHARE", "motion.gravity"),
    short("ink-lines", "pixels|strokes", "ink.lines"),
    short("ink-threshold", "T1", "ink.threshold"),
    short("ink-weak", "D", "ink.weak_difference"),
    short("ink-width", "W", "ink.width"),
    short("ink-depth-step", "S", "ink.depth_step"),
    short("ink-tone", "K", "ink.tone"),
    short("ink-lightness", "L", "ink.weak_lightness"),
    short("ink-swell", "F", "ink.swell"),
    short("ink-pressure", "P", "ink.pressure"),
    short("ink-dryness", "D", "ink.dryness"),
    short("ink-roughness", "PX", "ink.roughness_px"),
    short("ink-color", "R,G,B", "ink.color"),
    short("ink-paper-grain", "G", "ink.paper_grain"),
    short("ink-mist", "FROM,TO", "ink.mist_m"),
    short("ink-seal", "FILE", "ink.seal"),
    short("brush-strokes", "N", "brush.strokes"),
    short("brush-wash", "F", "brush.wash"),
    short("brush-wetness", "SHARE", "brush.wetness"),
    short("brush-dryness", "SHARE", "brush.dryness"),
    short("brush-tufts", "N", "brush.tufts"),
    short("brush-width", "F", "brush.line_width"),
    short("brush-omission", "SHARE", "brush.omission"),
    short("brush-ground", "SHARE", "brush.ground"),
    short("brush-sheet", "raw|sized|silk", "brush.sheet"),
    short("brush-progress", "SHARE", "brush.progress"),
    short("ink-rule", "RULE", "study.ink_rule"),
    short("ink-sphere-map", "FORM", "study.ink_sphere_map"),
    short("ink-template", "on|off", "study.ink_template"),
    short("ink-printed-lines", "on|off", "study.ink_printed_lines"),
    short("ink-anchoring", "TO", "study.ink_anchoring"),
    short("ink-show", "WHAT", "ink.show"),
];

/// Additional flag of `render`.
pub const SAMPLES: ShortForm = short("samples", "N", "picture.samples");

/// Returns the reason why this build does not know a key for a published form. `name` is the key's current or former
/// name.
pub(super) fn laboratory_hint(name: &str) -> Option<String> {
    let (table, key) = name.split_once('.').unwrap_or((name, ""));
    let now = format!("study.{}{key}", if table == "ink" { "ink_" } else { "" });
    let is_printed = name == "study" || SHORT_FORMS.iter().any(|short| short.key == now);
    (is_printed && cfg!(not(feature = "study"))).then(|| {
        let expected = "expected the laboratory's build, which alone supports it: `./run chart` or `pelage-lab`";
        format!("found a key for a published formula, {expected}")
    })
}
