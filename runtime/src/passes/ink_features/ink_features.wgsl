//! uses ink/line_forms, ink/screen, shared/ink
// Detection of line features: pixels where the normal turns (Fang 2006, §2) or depth steps (formulas 5.2).

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<f32>;

// Range, in multiples of `ink.depth_step`, over which a depth step grows from the strength of a fold to that of an
// outline (formulas 5.2).
const DEEP: f32 = 2.0;
// Factor on line width at a stored value of 1; ink_normals stores a quarter of the factor.
const WIDTH_SCALE: f32 = 4.0;

// Returns: half of the widest line through the pixel over WIDEST_HALF, 0 for no feature; strength; strength as an
// outline against the background.
@fragment
fn fs_features(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = vec2<i32>(position.xy);
    let here = textureLoad(normals, p, 0);
    // Background.
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
    // Folds are drawn lighter than outlines.
    if min(min(a.w, b.w), min(c.w, d.w)) > 0.0 {
        strength *= FOLD;
        outline = 0.0;
    }
    if ink.depth_step > 0.0 {
        // Second differences are zero on a plane, however slanted. The nearer side of a step carries the line.
        let bend = max(2.0 * here.w - a.w - c.w, 2.0 * here.w - b.w - d.w) / here.w;
        // Folds seen nearly edge on bend as much as small steps do, and get the same light strength.
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
    // Keeps weak features nonzero at eight bits.
    return vec4(max(half_width / WIDEST_HALF, 1.0 / 255.0), max(strength, 1.0 / 255.0), outline, 1.0);
}
