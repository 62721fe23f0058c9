//! uses ink/line_forms, ink/screen, shared/ink
// Detection of line features: pixels where the normal changes (Fang 2006, §2) or the depth is discontinuous (formulas
// 5.2).

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<f32>;

// Range of depth steps over which the strength grows from that of a fold to that of an outline, in multiples of
// `ink.depth_step` (formulas 5.2).
const DEEP: f32 = 2.0;
// Factor on line width for a stored value of 1: ink_normals stores a quarter of the factor.
const WIDTH_SCALE: f32 = 4.0;

// Returns the feature of a pixel:
// * x: half the width of the widest line through the pixel, divided by WIDEST_HALF, 0 for no feature
// * y: strength
// * z: strength as an outline against the background
@fragment
fn fs_features(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = vec2<i32>(position.xy);
    let here = textureLoad(normals, p, 0);
    // The pixel is background.
    if here.w <= 0.0 {
        return vec4(0.0);
    }
    let s = ink.step;
    let a = textureLoad(normals, clamp_to_target(p + vec2(-s, -s)), 0);
    let b = textureLoad(normals, clamp_to_target(p + vec2(-s, s)), 0);
    let c = textureLoad(normals, clamp_to_target(p + vec2(s, s)), 0);
    let d = textureLoad(normals, clamp_to_target(p + vec2(s, -s)), 0);
    let dots = vec4(dot(here.xyz, a.xyz), dot(here.xyz, b.xyz), dot(here.xyz, c.xyz), dot(here.xyz, d.xyz));
    var strength = ink_feature_strength(min(min(dots.x, dots.y), min(dots.z, dots.w)), ink.t1, ink.t2);
    var outline = strength;
    // All neighbours are on the body, so this is a fold, which is drawn lighter than an outline.
    if min(min(a.w, b.w), min(c.w, d.w)) > 0.0 {
        strength *= FOLD;
        outline = 0.0;
    }
    if ink.depth_step > 0.0 {
        // Second differences are zero on a plane of any slope. The line is drawn on the nearer side of a step.
        let bend = max(2.0 * here.w - a.w - c.w, 2.0 * here.w - b.w - d.w) / here.w;
        // Folds seen nearly edge-on have the same second difference as small steps, and get the same low strength.
        let steps = bend / ink.depth_step - 1.0;
        let strength_of_step = clamp(steps, 0.0, FOLD) + clamp((steps - 1.0) / DEEP, 0.0, 1.0) * (1.0 - FOLD);
        strength = max(strength, strength_of_step);
    }
    strength = form_of_features(strength, dots);
    let surface = textureLoad(surfaces, p, 0);
    var half_width = ink.half_width + ink.half_width_scaled * here.w;
    half_width = min(half_width * WIDTH_SCALE * surface.b, WIDEST_HALF);
    if strength <= 0.0 || half_width <= 0.0 {
        return vec4(0.0);
    }
    // The minimum keeps weak features above zero at eight bits.
    return vec4(max(half_width / WIDEST_HALF, 1.0 / 255.0), max(strength, 1.0 / 255.0), outline, 1.0);
}
