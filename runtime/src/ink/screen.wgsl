// What the passes over the whole picture share: the frame's constants, and a triangle that covers the target.

struct InkFrame {
    // sRGB-encoded: as ink and paper are mixed.
    ink: vec3<f32>,
    // Of lines: how much the relief of the paper moves their edge, pixels.
    roughness: f32,
    paper: vec3<f32>,
    // Share of the paper's relief and tone.
    paper_grain: f32,
    // Target, pixels.
    size: vec2<f32>,
    // T1 and T2.
    t1: f32,
    t2: f32,
    // Distance of the neighbours that a normal is compared with, pixels.
    step: i32,
    // Farthest that a line reaches from its feature, whole pixels.
    reach: i32,
    // Half of the widest line, pixels; or metres times the pixels that a metre has at clip w 1.
    half_width: f32,
    half_width_scaled: f32,
    // k and levelColor of D.
    tone: f32,
    lightness: f32,
    // How much lines run dry.
    dryness: f32,
    // Period of the paper, pixels.
    paper_period: f32,
    // Clip w where mist begins, and where only it is left.
    mist_from: f32,
    mist_to: f32,
    // Relative step of 1 / clip w between neighbours that is a feature; 0 for none.
    depth_step: f32,
    // Depth where nothing is.
    far_depth: f32,
}

@group(0) @binding(0) var<uniform> ink: InkFrame;

// Halves of lines that the feature texture can hold, pixels.
const WIDEST_HALF: f32 = 16.0;
// Strength of lines with the body on both sides, unless one side is farther.
const FOLD: f32 = 0.5;

@vertex
fn vs_screen(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}

fn inside(p: vec2<i32>) -> vec2<i32> {
    return clamp(p, vec2(0), vec2<i32>(ink.size) - 1);
}

// Weight of what is that many pixels away along a row or column: 1 for none, 0 out of reach. All of them together are reach + 1.
fn nearness(distance: f32) -> f32 {
    return 1.0 - abs(distance) / f32(ink.reach + 1);
}
