//! uses ink/line_forms, ink/screen, shared/ink
// Ink lines: finds the feature whose line reaches a pixel, and fills that line by brush and sphere map (Fang 2006, §2;
// formulas 5.2).

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var surfaces: texture_2d<f32>;
@group(0) @binding(3) var features: texture_2d<f32>;
@group(0) @binding(4) var rows: texture_2d<f32>;
@group(0) @binding(5) var paper: texture_2d<f32>;
@group(0) @binding(6) var paper_sampler: sampler;

// Thresholds of the feature count near a feature, weighted by nearness (formulas 5.2). The count is 2/3 to 1 along a
// line and half of that at its end. Below SPECK, the feature is a speck; from LINE on, it is a line.
const SPECK: f32 = 0.22;
const LINE: f32 = 0.45;
// Share of a line's half width that the brush fills, for a weak and for a strong line.
const BRUSH: vec2<f32> = vec2(0.2, 0.55);
// Minimum half width of the brush, pixels.
const LEAST_BRUSH_PX: f32 = 0.6;
// Feature strength below which lines fade.
const FADES: f32 = 0.35;
// Range of feature strengths over which the sphere map begins to swell lines.
const SWELLS: vec2<f32> = vec2(0.5, 0.75);
// Half width of the edge of a dry brush (formulas 5.6).
const DRY_EDGE: f32 = 0.12;
// Weight of the paper's threshold for a dry brush (formulas 5.6).
const DRY_PAPER: f32 = 0.88;
// Loss of a brush's dryness under pressure (formulas 5.6).
const DRY_PRESS: f32 = 0.7;
// Increase of grey at the lowest pressure.
const LIGHT_PRESS: f32 = 0.3;

// Returns three values: opacity of the line; opacity times the darkness of its ink; offset to the feature, stored as
// (x + 128) / 255.
@fragment
fn fs_stroke(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = vec2<i32>(position.xy);
    let first = max(p.y - ink.reach, 0);
    let last = min(p.y + ink.reach, i32(ink.size.y) - 1);
    var best = 1e9;
    var offset = vec2(0);
    var reach = 0.0;
    var features_near = 0.0;
    for (var y = first; y <= last; y++) {
        let row = textureLoad(rows, vec2(p.x, y), 0);
        let w = row.g * WIDEST_HALF;
        let d = vec2(round(row.r * 255.0) - 128.0, f32(y - p.y));
        features_near += row.b * nearness(d.y);
        let cost = line_cost(d, w);
        if w > 0.0 && cost < best {
            best = cost;
            offset = vec2<i32>(d);
            reach = w;
        }
    }
    let here = textureLoad(normals, p, 0);
    let stroke = textureLoad(surfaces, p, 0).g;
    let in_reach = reach > 0.0;
    if !in_reach && (TEMPLATE || here.w <= 0.0) {
        return vec4(0.0, 0.0, 128.0 / 255.0, 128.0 / 255.0);
    }
    let q = p + offset;
    let feature = textureLoad(features, q, 0);
    let half_width = select(0.0, feature.r * WIDEST_HALF, in_reach);
    let strength = select(1.0, feature.g, in_reach);
    let source = textureLoad(normals, q, 0);
    let surface = textureLoad(surfaces, q, 0);
    let sheet = textureSampleLevel(paper, paper_sampler, position.xy / ink.paper_period, 0.0);

    let far = vec2<f32>(offset);
    let distance = line_distance(far);
    // Brush pressure.
    let most = ink.half_width + ink.half_width_scaled * source.w;
    let press = clamp(half_width / max(most, 1e-6), 0.0, 1.0);
    // The brush is thinner where the line is weak, and its edge follows the paper.
    let moved = (sheet.r - 0.5) * ink.roughness;
    let thin = max(half_width * mix(BRUSH.x, BRUSH.y, strength), LEAST_BRUSH_PX);
    var core = select(0.0, clamp(thin - distance + 0.5 + moved, 0.0, 1.0), in_reach);
    var band = select(0.0, clamp(half_width * sqrt(strength) - distance + 0.5 + moved, 0.0, 1.0), in_reach);
    // Lines fade towards their ends, where the brush lifts.
    core *= smoothstep(0.0, FADES, strength);
    // Remove specks: features that do not continue as a line.
    core *= smoothstep(SPECK, LINE, features_near / (nearness(far.x) * nearness(far.y)));
    // Outlines swell with the sphere map; folds do not.
    let dark = select(0.0, 1.0 - stroke, here.w > 0.0) * smoothstep(SWELLS.x, SWELLS.y, strength);
    if !TEMPLATE {
        band = 1.0;
    }
    var opacity = max(core, band * dark);
    // A dry brush leaves ink only on the raised parts of the paper.
    let dry = surface.a * ink.dryness * (1.0 - DRY_PRESS * press);
    opacity *= smoothstep(-DRY_EDGE, DRY_EDGE, 1.0 - dry - DRY_PAPER * sheet.a);
    let even = ink_line_grey(select(here.z, source.z, in_reach), ink.tone, ink.lightness, strength);
    // Low pressure leaves less ink on the paper.
    let brushed = vec2(opacity, mix(even, 1.0, LIGHT_PRESS * (1.0 - press)));
    let line = form_of_line(brushed, even, in_reach, distance, half_width, here.w > 0.0, stroke);
    opacity = line.x;
    let grey = line.y;
    return vec4(opacity, opacity * (1.0 - grey), (far + 128.0) / 255.0);
}
