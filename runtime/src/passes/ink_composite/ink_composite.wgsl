//! uses ink/line_forms, ink/screen, shared/srgb
// Composition of paper, wash and lines over the application's picture (formulas 5.9), with the depth of the painted
// surface.

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<f32>;
@group(0) @binding(3) var strokes: texture_2d<f32>;
@group(0) @binding(4) var depths: texture_depth_2d;
@group(0) @binding(5) var paper: texture_2d<f32>;
@group(0) @binding(6) var paper_sampler: sampler;
@group(0) @binding(7) var clamped: sampler;

// Whether the application's picture stays where nothing is painted.
override PICTURE: bool = false;

struct Painted {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

// Distance that the ink of the wash bleeds into the paper, pixels, along x and y.
const WASH_RUNS: vec2<f32> = vec2(1.1, 0.6);
// Distance that the ink of lines bleeds into the paper, pixels, along x and y; lines bleed less than the wash.
const LINES_RUN: vec2<f32> = vec2(0.44, 0.24);
// Depth offset of a line outside the body, as a fraction of the distance from its feature to the background.
const LINE_BEHIND: f32 = 0.05;
// Weight of the paper's absorption in the density of the wash.
const ABSORPTION_IN_WASH: f32 = 0.25;
// Weight of the paper's relief in the density of the wash.
const RELIEF_IN_WASH: f32 = 0.15;
// Weight of the paper's relief in the brightness of the paper.
const RELIEF_IN_PAPER: f32 = 0.035;
// Weight of the paper's tone in the brightness of the paper.
const TONE_IN_PAPER: f32 = 0.3;

// Samples a texture blurred by bleeding: the mean of two reads, each of which filters four texels.
fn sample_bleed(map: texture_2d<f32>, uv: vec2<f32>, runs: vec2<f32>) -> vec2<f32> {
    let px = runs / ink.size;
    let one = textureSampleLevel(map, clamped, uv + px, 0.0).rg;
    let other = textureSampleLevel(map, clamped, uv - px, 0.0).rg;
    return 0.5 * (one + other);
}

// Returns the depth of a pixel. Outside the body, a line is slightly behind its feature at `q`, so that hair in front
// of it covers it. A faint edge of a line keeps the depth of its own pixel and therefore occludes nothing.
fn depth_at(p: vec2<i32>, q: vec2<i32>, on_body: bool, opacity: f32) -> f32 {
    let beside = mix(textureLoad(depths, q, 0), ink.far_depth, LINE_BEHIND);
    return select(beside, textureLoad(depths, p, 0), on_body || opacity <= 0.5);
}

// Returns the pixel position of the feature whose line reaches the pixel `p`.
fn feature_of(p: vec2<i32>, stroke: vec4<f32>) -> vec2<i32> {
    return clamp_to_target(p + vec2<i32>(round(stroke.zw * 255.0)) - 128);
}

// Returns the opacity and ink of the line.
fn line_at(uv: vec2<f32>, stroke: vec4<f32>) -> vec2<f32> {
    if SOFT {
        return sample_bleed(strokes, uv, LINES_RUN);
    }
    return stroke.xy;
}

// Returns the grey of the wash, which gathers between the paper's fibres. Where there is enough ink for the whole
// paper, raised fibres also take ink; otherwise they would show as white scratches.
fn wash_at(uv: vec2<f32>, sheet: vec4<f32>) -> f32 {
    let dens = 1.0 - sample_bleed(surfaces, uv, WASH_RUNS).r;
    let thirst = min(2.0 * (1.0 - dens), 1.0);
    let uneven = ink.paper_grain * thirst * thirst;
    let grain = ABSORPTION_IN_WASH * (sheet.g - 0.5) + RELIEF_IN_WASH * (0.5 - sheet.r);
    return clamp(1.0 - dens * (1.0 + uneven * grain), 0.0, 1.0);
}

@fragment
fn fs_composite(@builtin(position) position: vec4<f32>) -> Painted {
    let p = clamp_to_target(vec2<i32>(position.xy));
    let uv = position.xy / ink.size;
    let here = textureLoad(normals, p, 0);
    let stroke = textureLoad(strokes, p, 0);
    let q = feature_of(p, stroke);
    let depth = depth_at(p, q, here.w > 0.0, stroke.x);
    let line = line_at(uv, stroke);
    let sheet = textureSampleLevel(paper, paper_sampler, position.xy / ink.paper_period, 0.0);
    let wash = wash_at(uv, sheet);
    var grey = wash * (1.0 - line.y);
    if ink.mist_to > ink.mist_from {
        let nearness = select(textureLoad(normals, q, 0).w, here.w, here.w > 0.0);
        let far = 1.0 / max(nearness, 1e-9);
        grey = mix(grey, 1.0, clamp((far - ink.mist_from) / (ink.mist_to - ink.mist_from), 0.0, 1.0));
    }
    let shade = RELIEF_IN_PAPER * (sheet.r - 0.5) - TONE_IN_PAPER * (1.0 - sheet.b);
    let relief = 1.0 + ink.paper_grain * shade;
    let sheet_color = ink.paper * relief;
    let color = linear_of(sheet_color * mix(ink.ink, vec3(1.0), grey));
    if !PICTURE {
        return Painted(vec4(color, 1.0), depth);
    }
    // Outside the body, only the lines of the body and the bleeding of its wash are painted.
    let opacity = select(max(line.x, 1.0 - wash), 1.0, here.w > 0.0);
    if opacity <= 0.0 {
        discard;
    }
    return Painted(vec4(select(linear_of(sheet_color * ink.ink), color, here.w > 0.0) * opacity, opacity), depth);
}
