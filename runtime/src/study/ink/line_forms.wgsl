//! uses ink/screen
// Line functions in pelage's own form and in the published form of Fang 2006 (formulas 5.2), selected by override
// constants. Replaces ink/line_forms.wgsl in studies.

// Whether a pixel is a feature only if all four dot products of its normal are below the threshold. The strength then
// changes in steps instead of gradually.
override ALL_BELOW: bool = false;
// Whether the dilation uses squares instead of discs.
override SQUARES: bool = false;
// Whether pixels are either ink or not, without partial coverage.
override HARD: bool = false;
// Whether the template limits the line width. If not, the sphere map alone determines it.
override TEMPLATE: bool = true;
// Whether lines bleed into the paper.
override SOFT: bool = true;

// Whether features are traced. If not, every feature is a line.
override FOLLOWED: bool = true;

// Grey of the sphere map below which a pixel is ink, for hard lines.
const DARK: f32 = 0.5;
// Strength of lines between the two thresholds: just above that of no feature.
const WEAK: f32 = 0.004;

fn form_of_features(strength: f32, dots: vec4<f32>) -> f32 {
    if !ALL_BELOW {
        return strength;
    }
    return select(0.0, 1.0, all(dots <= vec4(ink.t1))) * select(WEAK, 1.0, all(dots <= vec4(ink.t2)));
}

fn form_of_reach(w: f32, strength: f32) -> f32 {
    return select(w * sqrt(sqrt(strength)), w, SQUARES);
}

fn line_cost(d: vec2<f32>, w: f32) -> f32 {
    if SQUARES {
        return max(abs(d.x), abs(d.y)) - w;
    }
    return dot(d, d) - w * w;
}

fn line_distance(d: vec2<f32>) -> f32 {
    if SQUARES {
        return max(abs(d.x), abs(d.y));
    }
    return length(d);
}

fn form_of_line(
    brushed: vec2<f32>,
    even_grey: f32,
    in_reach: bool,
    distance: f32,
    half_width: f32,
    on_body: bool,
    stroke: f32,
) -> vec2<f32> {
    if !HARD {
        return brushed;
    }
    let core = select(0.0, 1.0, in_reach && distance == 0.0);
    let band = select(0.0, 1.0, !TEMPLATE || (in_reach && distance <= half_width));
    let dark = select(0.0, 1.0, on_body && stroke < DARK);
    return vec2(max(core, band * dark), even_grey);
}
