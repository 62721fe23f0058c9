// Uniform block of a frame, and a full-screen triangle; shared by the screen passes.

struct InkFrame {
    // Ink colour, sRGB-encoded, because ink and paper are mixed in that encoding.
    ink: vec3<f32>,
    // Displacement of line edges by the paper's relief, pixels.
    roughness: f32,
    paper: vec3<f32>,
    // Weight of the paper's relief and tone.
    paper_grain: f32,
    // Size of the target, pixels.
    size: vec2<f32>,
    // Thresholds T1 and T2 of Fang 2006.
    t1: f32,
    t2: f32,
    // Distance in pixels to the neighbours whose normals are compared.
    step: i32,
    // Greatest distance between a line's pixel and its feature, whole pixels.
    reach: i32,
    // Constant part of the widest line's half width, pixels.
    half_width: f32,
    // Part of the widest line's half width that scales with distance: metres times pixels per metre at clip-space
    // w = 1.
    half_width_scaled: f32,
    // Factor k in the line grey D of Fang 2006.
    tone: f32,
    // Lightness of weak lines, levelColor of Fang 2006.
    lightness: f32,
    // Dryness of lines.
    dryness: f32,
    // Period of the paper, pixels.
    paper_period: f32,
    // Clip-space w at which mist begins.
    mist_from: f32,
    // Clip-space w beyond which only mist is visible.
    mist_to: f32,
    // Minimum relative difference of 1 / clip w between neighbouring pixels that makes a feature; 0 switches this off.
    depth_step: f32,
    // Depth of the background.
    far_depth: f32,
}

@group(0) @binding(0) var<uniform> ink: InkFrame;

// Largest half width of a line that the feature texture can hold, pixels.
const WIDEST_HALF: f32 = 16.0;
// Strength of folds, which are lines with the body on both sides (formulas 5.2). A depth discontinuity raises it.
const FOLD: f32 = 0.5;

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Returns the pixel of the target nearest to `p`.
fn clamp_to_target(p: vec2<i32>) -> vec2<i32> {
    return clamp(p, vec2(0), vec2<i32>(ink.size) - 1);
}

// Returns the weight of a pixel at a distance along a row or column: 1 at distance 0, 0 beyond the reach. Over both
// sides, the weights add up to reach + 1.
fn nearness(distance: f32) -> f32 {
    return 1.0 - abs(distance) / f32(ink.reach + 1);
}
