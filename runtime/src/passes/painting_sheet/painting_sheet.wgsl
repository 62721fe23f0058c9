//! uses painting/frame, shared/srgb
// The sheet: paper, wet washes and full ink over the application's picture, with the depth of the painted surface.

@group(0) @binding(0) var<uniform> painting: PaintingFrame;
@group(0) @binding(1) var washes: texture_2d<f32>;
@group(0) @binding(2) var wet: texture_2d<f32>;
@group(0) @binding(3) var inks: texture_2d<f32>;
@group(0) @binding(4) var depths: texture_depth_2d;
@group(0) @binding(5) var paper: texture_2d<f32>;
@group(0) @binding(6) var paper_sampler: sampler;
@group(0) @binding(7) var clamped: sampler;
@group(0) @binding(8) var pigments: texture_2d<f32>;

// Whether the application's picture stays where nothing is painted.
override PICTURE: bool = false;

struct Sheet {
    @location(0) color: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

@vertex
fn vs_sheet(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4(corner * 2.0 - 1.0, 0.0, 1.0);
}

// Factor from stored densities to optical density.
const STRENGTH: f32 = 0.88;
// Colour of ink: absorption of red, green and blue by dense and by thin ink.
const DENSE: vec3<f32> = vec3(1.0, 0.985, 0.945);
const THIN: vec3<f32> = vec3(1.05, 1.0, 0.93);
// Weight of the paper's relief in the brightness of the paper, and of its tone.
const RELIEF: f32 = 0.035;
const TONE: f32 = 0.3;

// Returns the optical density of the washes at a pixel: pigment spread within the wet area, which has a crisp, uneven
// edge with pigment gathered at it.
fn wash_density(uv: vec2<f32>, position: vec2<f32>, relief: f32) -> f32 {
    let s = textureSampleLevel(washes, clamped, uv, 0.0);
    let blurred = textureSampleLevel(wet, clamped, uv, 0.0);
    let noise = plane_noise(position / (5.5 * painting.unit_px), 21u)
        + 0.5 * plane_noise(position / (2.2 * painting.unit_px), 22u) - 0.75;
    let own = (s.x + 0.2 * max(s.w - s.x, 0.0)) / (s.y + 1e-3);
    let spread = blurred.x / (blurred.y + 1e-3);
    let pigment = select(spread, mix(own, spread, 0.35 + 0.5 * painting.wetness * painting.bleed), s.y > 0.02);
    let near = blurred.w;
    let covered = max(near, 0.7 * s.y);
    let edge = smoothstep(0.3, 0.62, covered
        + 0.3 * (relief - 0.5 + noise) * painting.bleed * smoothstep(0.04, 0.2, covered)
        * smoothstep(1.0, 0.7, covered));
    let rim = clamp(edge - near, 0.0, 1.0);
    let gathered = 1.0 + 2.0 * painting.wetness * rim * clamp(0.8 + noise, 0.2, 1.6);
    return pigment * edge * gathered * (1.0 + 0.25 * (0.5 - relief));
}

// Returns the density of full ink; it bleeds where the wash is wet.
fn ink_density(uv: vec2<f32>, damp: f32) -> f32 {
    let here = textureSampleLevel(inks, clamped, uv, 0.0);
    let px = 1.1 * painting.unit_px / painting.size;
    let around = 0.25 * (textureSampleLevel(inks, clamped, uv + px * vec2(1.0, 0.4), 0.0)
        + textureSampleLevel(inks, clamped, uv + px * vec2(-0.4, 1.0), 0.0)
        + textureSampleLevel(inks, clamped, uv - px * vec2(1.0, 0.4), 0.0)
        + textureSampleLevel(inks, clamped, uv - px * vec2(-0.4, 1.0), 0.0));
    return mix(here.x, around.x, damp) + here.y + here.z;
}

// Tint of silk, brightness of its threads, and distance between them, 1/424 of the picture's height.
const SILK: vec3<f32> = vec3(0.93, 0.84, 0.68);
const THREADS: f32 = 0.1;
const THREAD_DISTANCE: f32 = 2.6;

// Returns the pattern of a plain weave with uneven threads, 0..=1.
fn woven(position: vec2<f32>) -> f32 {
    let p = position / max(THREAD_DISTANCE * painting.unit_px, 2.6);
    let uneven = vec2(plane_noise(p * vec2(1.0, 0.06), 31u), plane_noise(p * vec2(0.06, 1.0), 32u));
    let wave = 0.5 + 0.5 * sin(6.2832 * p + 2.0 * uneven);
    return clamp(0.35 * (wave.x + wave.y) + 0.3 * (uneven.x + uneven.y) - 0.15, 0.0, 1.0);
}

@fragment
fn fs_sheet(@builtin(position) position: vec4<f32>) -> Sheet {
    let p = vec2<i32>(position.xy);
    let uv = position.xy / painting.size;
    let sheet = textureSampleLevel(paper, paper_sampler, position.xy / painting.paper_period, 0.0);
    let depth = textureLoad(depths, p, 0);
    let wetted = smoothstep(0.1, 0.7, textureSampleLevel(wet, clamped, uv, 0.0).w);
    let damp = 0.88 * wetted * painting.wetness * painting.bleed;
    var density = STRENGTH * (wash_density(uv, position.xy, sheet.a) + ink_density(uv, damp));
    density *= 1.0 - textureSampleLevel(inks, clamped, uv, 0.0).w;
    if painting.mist_to > painting.mist_from {
        let far = eye_distance(painting, depth);
        density *= 1.0 - clamp((far - painting.mist_from) / (painting.mist_to - painting.mist_from), 0.0, 1.0);
    }
    let shade = RELIEF * (sheet.r - 0.5) - TONE * (1.0 - sheet.b);
    let threads = painting.weave * painting.paper_grain * (woven(position.xy) - 0.5);
    let tint = mix(vec3(1.0), SILK, painting.weave);
    let ground = painting.paper * tint * (1.0 + painting.paper_grain * shade + THREADS * threads);
    let absorbs = mix(DENSE, THIN, exp(-1.2 * density));
    let pigment = textureSampleLevel(pigments, clamped, uv, 0.0);
    let inked = max(ground * exp(-density * absorbs), painting.ink * ground);
    let color = linear_of(inked * (1.0 - pigment.a) + ground * pigment.rgb);
    if !PICTURE {
        return Sheet(vec4(color, 1.0), depth);
    }
    let body = depth != painting.far_depth;
    let opacity = select(max(1.0 - exp(-density), pigment.a), 1.0, body);
    if opacity <= 0.004 {
        discard;
    }
    return Sheet(vec4(select(linear_of(painting.ink), color, body) * opacity, opacity), depth);
}
