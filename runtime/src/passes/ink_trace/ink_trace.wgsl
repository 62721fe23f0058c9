//! uses ink/line_forms, ink/screen
// Selection of the features that form lines (formulas 5.2). Each feature is followed to both sides. A feature is a
// speck, caused by the faces of a dense mesh, if its line ends soon or its surroundings have no order. Strength and
// width are averaged along the line; otherwise lines would look like rows of beads. Outlines are never specks.

@group(0) @binding(1) var normals: texture_2d<f32>;
@group(0) @binding(2) var features: texture_2d<f32>;

// Number of samples along the line to each side (formulas 5.2). Together they span more than two and a half widths of
// the widest line.
const LOOKS: i32 = 12;
// Number of consecutive samples without a feature that a line may skip (formulas 5.2).
const HOLE: i32 = 2;
// Strength at or below which tracing ignores a feature.
const FAINT: f32 = 0.02;
// Thresholds of the share of samples that find the line: below the first, the feature is a speck, above the second a
// line (formulas 5.2).
const ENDS: vec2<f32> = vec2(0.2, 0.55);
// Thresholds of two more tests for specks (formulas 5.2). ORDER: elongation of the features around the pixel, low for
// specks. CROWD: share of samples that also find features beside the line, high for specks.
const ORDER: vec2<f32> = vec2(0.1, 0.3);
const CROWD: vec2<f32> = vec2(0.25, 0.5);
// Rotation of the line towards a neighbouring sample, as a fraction of the angle to it.
const TURN: f32 = 0.35;
// Half the side of the square in which the direction of a line is estimated, pixels (formulas 5.2).
const ABOUT: i32 = 3;
// Distance between samples, relative to half the width of the widest line (formulas 5.2).
const STRIDE: f32 = 0.25;
// Distance of samples beside the line, relative to half the width of the widest line (formulas 5.2).
const BESIDE: f32 = 0.5;
// Minimum distance of samples beside the line, pixels (formulas 5.2).
const LEAST_BESIDE_PX: f32 = 3.0;

// Returns the strength of the feature at a pixel.
fn strength_at(p: vec2<i32>) -> f32 {
    return textureLoad(features, clamp_to_target(p), 0).g;
}

// Returns the half width and strength of the feature at the pixel nearest to a position.
fn feature_at(p: vec2<f32>) -> vec2<f32> {
    return textureLoad(features, clamp_to_target(vec2<i32>(round(p))), 0).rg;
}

// Returns the direction of the line through `p`, and the elongation of the features around it. The direction is their
// major axis. The elongation is 0 for equal axes, 1 if the minor axis vanishes.
fn direction_at(p: vec2<i32>) -> vec3<f32> {
    var moments = vec3(0.0);
    for (var y = -ABOUT; y <= ABOUT; y++) {
        for (var x = -ABOUT; x <= ABOUT; x++) {
            moments += strength_at(p + vec2(x, y)) * vec3(f32(x * x), f32(x * y), f32(y * y));
        }
    }
    let bent = vec2(moments.x - moments.z, 2.0 * moments.y);
    let turn = 0.5 * atan2(bent.y, bent.x);
    let along = length(bent) / max(moments.x + moments.z, 1e-6);
    return select(vec3(cos(turn), sin(turn), along), vec3(1.0, 0.0, 0.0), along <= 0.0);
}

// Follows the line from `p` in a direction. Returns the sums over the samples that find the line:
// * x: number of samples
// * y: strengths
// * z: half widths
// * w: number of samples that also find a feature beside the line, where each side counts one half
fn follow(p: vec2<i32>, towards: vec2<f32>, stride: f32, beside: f32) -> vec4<f32> {
    var at = vec2<f32>(p);
    var way = towards;
    var found = vec4(0.0);
    var holes = 0;
    for (var i = 0; i < LOOKS && holes <= HOLE; i++) {
        let side = vec2(-way.y, way.x);
        at += way * stride;
        // Lines bend, so of three adjacent samples, the one with the strongest feature is followed; the middle one if
        // they are equal.
        let ahead = feature_at(at);
        let left = feature_at(at + side);
        let right = feature_at(at - side);
        var best = ahead;
        if max(left.y, right.y) > ahead.y {
            let bend = select(-1.0, 1.0, left.y >= right.y);
            best = select(right, left, left.y >= right.y);
            at += side * bend;
            way = normalize(way + side * (TURN * bend / stride));
        }
        if best.y <= FAINT {
            holes++;
            continue;
        }
        holes = 0;
        let others = vec2(feature_at(at + side * beside).y, feature_at(at - side * beside).y) > vec2(FAINT);
        found += vec4(1.0, best.y, best.x, dot(vec2(0.5), vec2<f32>(others)));
    }
    return found;
}

// Returns the feature in the format of ink_features, or zero if it is not on a line.
@fragment
fn fs_trace(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let p = vec2<i32>(position.xy);
    let feature = textureLoad(features, p, 0);
    if feature.r <= 0.0 || !FOLLOWED {
        return feature;
    }
    let most = ink.half_width + ink.half_width_scaled * textureLoad(normals, p, 0).w;
    let stride = clamp(STRIDE * most, 1.0, STRIDE * WIDEST_HALF);
    let beside = max(BESIDE * most, LEAST_BESIDE_PX);
    let towards = direction_at(p);
    let found = follow(p, towards.xy, stride, beside) + follow(p, -towards.xy, stride, beside)
        + vec4(0.0, feature.g, feature.r, 0.0);
    let half_width = found.z / (found.x + 1.0);
    if feature.b >= feature.g {
        return vec4(half_width, feature.gba);
    }
    let goes_on = smoothstep(ENDS.x, ENDS.y, found.x / f32(2 * LOOKS)) * smoothstep(ORDER.x, ORDER.y, towards.z);
    // A depth step is a line even without support from the folds around it.
    let crowded = smoothstep(CROWD.x, CROWD.y, found.w / max(found.x, 1.0));
    let alone = 1.0 - crowded * clamp((1.0 - feature.g) / (1.0 - FOLD), 0.0, 1.0);
    // Where a fold ends at an outline, it must not gain the outline's strength.
    let even = min(found.y / (found.x + 1.0), max(feature.g, FOLD));
    let strength = max(feature.b, even * goes_on * alone);
    if strength <= 0.5 / 255.0 {
        return vec4(0.0);
    }
    return vec4(half_width, strength, feature.b, 1.0);
}
