//! uses painting/frame, painting/strokes
// Strokes as ribbons: the marks of a brush, in the density of ink.

@group(0) @binding(0) var<uniform> painting: PaintingFrame;
@group(0) @binding(1) var<storage, read> pool: array<PoolStroke>;
@group(0) @binding(2) var<storage, read> brush_points: array<BrushPoint>;
@group(0) @binding(3) var depths: texture_depth_2d;
@group(0) @binding(4) var paper: texture_2d<f32>;
@group(0) @binding(5) var paper_sampler: sampler;
@group(0) @binding(6) var<uniform> painted: PaintedModel;

struct Ribbon {
    @builtin(position) position: vec4<f32>,
    // Offset across the ribbon, and beyond its ends, in half widths; share of the length; distance along it, pixels.
    @location(0) across: vec4<f32>,
    // Half width in pixels, density, dryness, load of the sides.
    @location(1) brush: vec4<f32>,
    @location(2) depth: f32,
    @location(3) @interpolate(flat) kind_seed: vec2<u32>,
    @location(5) @interpolate(flat) pigment: u32,
    // Middle of the stroke and half width there, pixels.
    @location(4) @interpolate(flat) middle: vec3<f32>,
}

// Width of the ribbon over that of the stroke: rough edges extend beyond it.
const MARGIN: f32 = 1.3;

// Minimum half width of a ribbon, pixels. Narrower strokes are as wide, and paler.
const LEAST_HALF: f32 = 0.6;

// Whether strokes of pigment are drawn, and not those of ink.
override PIGMENT: bool = false;

@vertex
fn vs_ribbon(@builtin(vertex_index) vertex: u32, @builtin(instance_index) number: u32) -> Ribbon {
    let stroke = pool[number];
    let column = vertex / 2u;
    let side = select(-MARGIN, MARGIN, (vertex & 1u) == 1u);
    let i = clamp(column, 1u, STROKE_POINTS) - 1u;
    let first = number * STROKE_POINTS;
    let here = brush_points[first + i];
    let before = brush_points[first + select(i - 1u, 0u, i == 0u)].place.xy;
    let after = brush_points[first + min(i + 1u, STROKE_POINTS - 1u)].place.xy;
    let way = after - before;
    let along = select(vec2(1.0, 0.0), way * inverseSqrt(max(dot(way, way), 1e-12)), dot(way, way) > 1e-8);
    let cap = select(select(0.0, MARGIN, column > STROKE_POINTS), -MARGIN, column == 0u);
    let half = select(0.0, max(here.place.w, LEAST_HALF), here.place.w > 0.0);
    let thinned = here.place.w / max(half, 1e-6);
    let px = here.place.xy + half * (vec2(-along.y, along.x) * side + along * cap);
    var out: Ribbon;
    let ndc = (px / painting.size - 0.5) * vec2(2.0, -2.0);
    // Ink and pigments are drawn apart.
    let is_drawn = ((stroke.pigment >> 24u) != 0u) == PIGMENT;
    out.position = select(vec4(2.0, 2.0, 0.5, 1.0), vec4(ndc, 0.5, 1.0), is_drawn);
    out.pigment = stroke.pigment;
    out.across = vec4(side, cap, f32(i) / f32(STROKE_POINTS - 1u), here.brush.z);
    out.brush = vec4(half, here.brush.x * thinned, here.brush.y, here.brush.w);
    out.depth = here.place.z;
    out.kind_seed = vec2(stroke.kind, stroke.seed & 0xffffu);
    let middle = brush_points[first + STROKE_POINTS / 2u].place;
    out.middle = vec3(middle.xy, middle.w);
    return out;
}

// Returns 1 where a stroke of a wash lies on its own part of the body, and 0 beside it. The border is uneven, by less
// than `half_px`, the half width of the stroke.
fn on_own_part(position: vec2<f32>, depth: f32, half_px: f32, half_m: f32) -> f32 {
    let jitter = vec2(
        plane_noise(position / (5.0 * painting.unit_px), 11u),
        plane_noise(position / (5.0 * painting.unit_px), 12u),
    ) - 0.5;
    let moved = vec2<i32>(position + jitter * min(7.0 * painting.unit_px, half_px));
    let p = clamp(moved, vec2(0), vec2<i32>(painting.size) - 1);
    let tolerance = half_m + 0.022 * painted.size;
    let off = abs(eye_distance(painting, textureLoad(depths, p, 0)) - depth);
    return 1.0 - smoothstep(tolerance, 1.5 * tolerance, off);
}

// Maximum softness of an edge, in half widths: the middle of a narrow stroke keeps its density.
const SOFTEST: f32 = 1.5;

// Returns the mark of a brush: density and coverage. `soft`: softness of the edge, pixels; `spacing`: width of a
// bristle, pixels; `ragged`: share of the length over which the end breaks up; `pool_rim`: pigment at the edge.
fn brush_mark(in: Ribbon, relief: f32, soft: f32, spacing: f32, ragged: f32, pool_rim: f32, rough: f32) -> vec2<f32> {
    let unit = painting.unit_px;
    let half = max(in.brush.x, 1e-3);
    let seed = in.kind_seed.y;
    let v = in.across.x;
    let s = in.across.w / unit;
    let width = half / unit;
    let r = length(in.across.xy);
    let edge = r * (1.0 + rough * (plane_noise(vec2(s / 4.5, v * 1.5 + 7.0), seed + 5u) - 0.5)
        + 0.6 * rough * (relief - 0.5));
    let softness = min(soft / width, SOFTEST);
    let coverage = 1.0 - smoothstep(1.0 - softness, 1.0 + 0.4 * softness + 0.02, edge);
    let bristle = 0.6 * plane_noise(vec2(v * width / spacing + 50.0, s / 35.0), seed)
        + 0.4 * plane_noise(vec2(v * width / (0.45 * spacing) + 90.0, s / 16.0), seed + 1u);
    let end = 1.0 - ragged * plane_noise(vec2(0.8 * v * width / spacing + 20.0, 3.0), seed + 9u);
    let lifted = smoothstep(end - 0.12, end + 0.02, in.across.z) * select(0.0, 1.0, ragged > 0.0);
    let threshold = in.brush.z * 0.62 - 0.06 + 0.8 * lifted;
    let grain = smoothstep(0.12, 0.88, 0.68 * bristle + 0.32 * relief);
    var touching = smoothstep(threshold - 0.1, threshold + 0.14, grain);
    if in.brush.z <= 0.001 && lifted <= 0.0 {
        touching = 1.0;
    }
    let load = max(1.0 + in.brush.w * clamp(v, -1.0, 1.0), 0.05);
    let k = (1.0 - edge) * width / 2.5;
    let rim = 1.0 + pool_rim * exp(-k * k);
    return vec2(in.brush.y * coverage * touching * load * (0.86 + 0.28 * bristle) * rim, coverage);
}

// Returns the marks of the hairs of a split brush.
fn split_mark(in: Ribbon, relief: f32) -> f32 {
    let unit = painting.unit_px;
    let seed = in.kind_seed.y;
    let hairs = 4.0 + floor(9.0 * hashed(1, 1, seed));
    let v = clamp(in.across.x, -0.999, 0.999) * 0.5 + 0.5;
    let at = v * hairs;
    let u = in.across.z;
    var mark = 0.0;
    for (var k = -1; k <= 1; k++) {
        let j = i32(floor(at)) + k;
        if j < 0 || j >= i32(hairs) {
            continue;
        }
        let a = hashed(j, 3, seed);
        let from_u = 0.22 * a * a;
        let to_u = 1.0 - 0.45 * hashed(j, 5, seed);
        let q = (u - from_u) / (to_u - from_u);
        if q < 0.0 || q > 1.0 {
            continue;
        }
        let c = hashed(j, 7, seed);
        let center = f32(j) + 0.5 + 0.7 * (c - 0.5) + 0.35 * sin(3.0 * q + 6.0 * c);
        let off = abs(at - center) * 2.0 * in.brush.x / hairs;
        let thick = (0.45 + 0.9 * hashed(j, 11, seed)) * 0.75 * unit * min(1.0, 7.0 * q + 0.35) * pow(1.0 - q, 0.6);
        let line = (1.0 - smoothstep(thick - 0.5, thick + 0.5, off)) * min(1.0, thick * 1.6);
        let grain = 0.55 * relief + 0.45 * plane_noise(vec2(f32(j) * 3.0, in.across.w / (9.0 * unit)), seed + 2u)
            + 0.05;
        let dry = 0.9 * in.brush.z;
        mark = max(mark, line * smoothstep(dry - 0.15, dry + 0.15, grain) * (0.65 + 0.35 * a));
    }
    return in.brush.y * mark;
}

// Returns the mark of an eye: density of full ink, and the highlight that it and the washes spare.
fn eye_mark(in: Ribbon, relief: f32) -> vec2<f32> {
    let width = max(in.brush.x, 1e-3) / painting.unit_px;
    let edge = length(in.across.xy) * (1.0 + 0.12 * (relief - 0.5));
    let covered = 1.0 - smoothstep(1.0 - 0.8 / width, 1.0 + 0.3 / width, edge);
    // The light is above and left of the middle. Small eyes have none.
    let whole = in.middle.z / painting.unit_px;
    let radius = 0.24 * whole;
    let off = distance(in.position.xy, in.middle.xy - vec2(0.28, 0.36) * in.middle.z) / painting.unit_px;
    let spared = (1.0 - smoothstep(radius - 0.4, radius + 0.4, off)) * smoothstep(1.3, 2.2, whole);
    return vec2(in.brush.y * covered * (1.0 - spared), spared * min(in.brush.y, 1.0));
}

fn relief_at(position: vec2<f32>) -> f32 {
    return textureSampleLevel(paper, paper_sampler, position / painting.paper_period, 0.0).a;
}

// Washes: greatest density, coverage, and the sum of densities.
@fragment
fn fs_wash(in: Ribbon) -> @location(0) vec4<f32> {
    let relief = relief_at(in.position.xy);
    let pale = in.kind_seed.x != MIDDLE;
    let mark = brush_mark(in, relief, select(6.5, 3.0, pale), select(3.8, 5.0, pale), 0.32, 0.12, 0.16);
    var part = 1.0;
    if in.kind_seed.x != GROUND {
        let half_m = 0.6 * in.brush.x * painted.size / max(painting.size.y, 1.0);
        part = on_own_part(in.position.xy, in.depth, in.brush.x, half_m);
    }
    let density = mark.x * part;
    return vec4(density, mark.y * part, 0.0, density);
}

// Full ink: density of wet lines, of dry strokes, of dark wet strokes; light spared in eyes.
@fragment
fn fs_ink_ribbon(in: Ribbon) -> @location(0) vec4<f32> {
    let relief = relief_at(in.position.xy);
    let kind = in.kind_seed.x;
    if kind == TUFT || kind == LOCK {
        return vec4(0.0, split_mark(in, relief), 0.0, 0.0);
    }
    if kind == DARK {
        let mark = brush_mark(in, relief, 0.8, 1.9, 0.3, 0.1, 0.18).x
            * on_own_part(in.position.xy, in.depth, in.brush.x, 0.02 * painted.size);
        return vec4(0.0, mark, 0.0, 0.0);
    }
    if kind == EYE {
        let mark = eye_mark(in, relief);
        return vec4(mark.x, 0.0, 0.0, mark.y);
    }
    let wet = brush_mark(in, relief, 0.7, 1.7, select(0.0, 0.12, kind == BONE), 0.15, 0.2).x;
    return vec4(wet, 0.0, 0.0, 0.0);
}

// Mineral pigment, opaque where it is thick: premultiplied colour, sRGB-encoded, and opacity.
@fragment
fn fs_pigment(in: Ribbon) -> @location(0) vec4<f32> {
    let relief = relief_at(in.position.xy);
    let mark = brush_mark(in, relief, 1.6, 2.6, 0.1, 0.25, 0.2).x;
    let opacity = 1.0 - exp(-1.4 * mark);
    return vec4(unpack4x8unorm(in.pigment).rgb, 1.0) * opacity;
}
