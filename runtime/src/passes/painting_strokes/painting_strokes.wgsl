//! uses hair/triangle_frame, painting/frame, painting/strokes, shared/frame, shared/skinning, surface/geometry
// Strokes of a model in a frame: their positions on the picture, and the pressure, density and dryness of the brush.

struct PoolPoint {
    // Vertices of a triangle, then the weights of the second and third, unorm 16 bits each.
    one: vec4<u32>,
    // Point opposite to it, or the same point; in hair, the bits of an offset from the first point.
    other: vec4<u32>,
    // Half width, metres; darkness of the surface; 1 on an axis or in hair; 1 in hair.
    brush: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> instance: Instance;
@group(1) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
@group(1) @binding(1) var<storage, read> pool: array<PoolStroke>;
@group(1) @binding(2) var<storage, read> pool_points: array<PoolPoint>;
@group(1) @binding(3) var<storage, read_write> brush_points: array<BrushPoint>;
@group(1) @binding(4) var<uniform> painting: PaintingFrame;
@group(1) @binding(5) var<uniform> painted: PaintedModel;
@group(1) @binding(6) var depths: texture_depth_2d;

// Direction to the light in the frame of the view: from above, left and the eye.
const LIGHT: vec3<f32> = vec3(-0.5, 0.72, 0.48);
// Range of the cosine to the light from shadow to light.
const LIT: vec2<f32> = vec2(0.3, 0.93);
// Share of the model's size within which a point counts as visible.
const VISIBLE: f32 = 0.012;
// Number of smoothing rounds of an axis, and of a dab.
const AXIS_ROUNDS: u32 = 4u;
const DAB_ROUNDS: u32 = 20u;
// Minimum width of a stroke that is seen at a grazing angle.
const LEAST_WIDTH: f32 = 0.42;

// Number of strokes with which all washes are painted where the tone asks for them, and the maximum.
const ALL_WASHES: f32 = 60.0;
const MOST_STROKES: f32 = 200.0;
// Number of tufts from which locks of hair are complete.
const FULL_HAIR: f32 = 10.0;

struct PosedPoint {
    position: vec3<f32>,
    normal: vec3<f32>,
    radius: f32,
}

// Returns the weighted mean of a triangle's vertices: position and normal in model space.
fn anchor_at(at: vec4<u32>) -> PosedPoint {
    let w = unpack2x16unorm(at.w);
    let u = 1.0 - w.x - w.y;
    let a = vertices[at.x];
    let b = vertices[at.y];
    let c = vertices[at.z];
    let position = a.position * u + b.position * w.x + c.position * w.y;
    return PosedPoint(position, a.normal * u + b.normal * w.x + c.normal * w.y, 0.0);
}

fn posed_point(stored: PoolPoint) -> PosedPoint {
    let one = anchor_at(stored.one);
    if stored.brush.w > 0.5 {
        let at = stored.one.xyz;
        let in_triangle = triangle_frame(vertices[at.x].position, vertices[at.y].position, vertices[at.z].position);
        let hair = one.position + in_triangle * bitcast<vec3<f32>>(stored.other.xyz);
        return PosedPoint((instance.world_from_model * vec4(hair, 1.0)).xyz, painting.back_ws, 0.0);
    }
    let other = anchor_at(stored.other);
    let p = (instance.world_from_model * vec4(0.5 * (one.position + other.position), 1.0)).xyz;
    let n = mat3x3(instance.normal_x.xyz, instance.normal_y.xyz, instance.normal_z.xyz) * one.normal;
    let radius = 0.5 * distance(one.position, other.position) * instance.scale;
    return PosedPoint(p, normalize_or(n, painting.back_ws), radius);
}

// Returns pixel position, distance from the eye plane and clip w of a point.
fn on_picture(p: vec3<f32>) -> vec4<f32> {
    let clip = frame.clip_from_world * vec4(p, 1.0);
    let w = max(clip.w, 1e-6);
    let px = (clip.xy / w * vec2(0.5, -0.5) + 0.5) * painting.size;
    return vec4(px, eye_distance(painting, clip.z / w), clip.w);
}

// Returns how visible a point is, 0..=1, by the depth of the picture. `tolerance`: distance behind the surface.
fn visible_at(at: vec4<f32>, tolerance: f32) -> f32 {
    if at.w <= 0.0 {
        return 0.0;
    }
    let p = vec2<i32>(floor(at.xy));
    if any(p < vec2(0)) || any(p >= vec2<i32>(painting.size)) {
        return 1.0;
    }
    let behind = at.z - eye_distance(painting, textureLoad(depths, p, 0));
    return 1.0 - smoothstep(tolerance, 2.0 * tolerance, behind);
}

// Returns smooth noise along a stroke, -1..1.
fn along_noise(u: f32, periods: f32, seed: u32) -> f32 {
    return 2.0 * plane_noise(vec2(u * periods, 0.5), seed) - 1.0;
}

// Returns the tone that a painter wants, 0..=1: dark coats are dark, lit places stay paper.
fn tone_at(darkness: f32, normal: vec3<f32>, toward_eye: vec3<f32>) -> f32 {
    let light = normalize(painting.right_ws * LIGHT.x + painting.up_ws * LIGHT.y + painting.back_ws * LIGHT.z);
    let shade = 1.0 - smoothstep(LIT.x, LIT.y, dot(normal, light));
    let turned = 1.0 - clamp(dot(normal, toward_eye), 0.0, 1.0);
    let least = 0.2 + 0.34 * smoothstep(0.5, 0.85, darkness);
    let tone = darkness * (least + (1.0 - least) * shade) + 0.22 * darkness * turned * turned;
    return max(tone, 0.145 * pow(shade, 1.5) * (0.35 + 0.65 * turned));
}

// Width of a stroke under even pressure, over that under varying pressure at its widest.
const EVEN_WIDTH: f32 = 0.8;

// Returns the share of a stroke that is painted already. Kinds follow each other, and overlap in time.
fn done_share(kind: u32, rank: f32) -> f32 {
    var interval = vec2(0.0, 0.06);
    if kind == PALE {
        interval = vec2(0.04, 0.3);
    } else if kind == MIDDLE {
        interval = vec2(0.25, 0.45);
    } else if kind == DARK {
        interval = vec2(0.42, 0.58);
    } else if kind == BONE {
        interval = vec2(0.52, 0.64);
    } else if kind == SPOT {
        interval = vec2(0.62, 0.68);
    } else if kind == EYE {
        interval = vec2(0.66, 0.71);
    } else if kind == TUFT {
        interval = vec2(0.9, 1.0);
    } else if kind == LOCK {
        interval = vec2(0.86, 0.96);
    }
    // Each stroke takes a fifth of the time of its kind.
    let start = mix(interval.x, interval.y, 0.8 * rank);
    return clamp((painting.progress - start) / (0.2 * (interval.y - interval.x)), 0.0, 1.0);
}

// Returns 1 on the part of a stroke that is painted already, and 0 after it. `u`: share of the stroke before the point.
fn is_drawn(done: f32, u: f32) -> f32 {
    return 1.0 - smoothstep(1.04 * done - 0.04, 1.04 * done, u - 1e-3);
}

// Places a pale, dry wash on the ground below the model, along the picture.
fn paint_ground(number: u32, seed: u32) {
    let second = f32(number);
    let last = f32(STROKE_POINTS - 1u);
    let size = painted.size;
    let done = done_share(GROUND, second);
    // Scenery, which is wider than the picture, has no wash below it.
    let middle = painted.ground_ws;
    let wide_px = 2.0 * distance(on_picture(middle + painting.right_ws * painted.reach).xy, on_picture(middle).xy);
    let scenery = smoothstep(0.9, 1.4, wide_px / painting.size.x);
    var run = 0.0;
    var before = vec2(0.0);
    for (var i = 0u; i < STROKE_POINTS; i++) {
        let u = f32(i) / last;
        let along = (u - 0.42 + 0.08 * second) * painted.reach * (1.8 - 0.7 * second);
        let p = painted.ground_ws + painting.right_ws * along;
        let center = on_picture(p);
        let metre = distance(on_picture(p + painting.right_ws * 0.01 * size).xy, center.xy) / (0.01 * size);
        let at = center.xy + vec2(0.0, metre * size * (0.008 + 0.02 * second + 0.006 * along_noise(u, 3.0, seed)));
        if i > 0u {
            run += distance(at, before);
        }
        before = at;
        let half = (0.016 - 0.006 * second) * size * metre * (0.2 + sin(3.14159 * pow(u, 0.8)))
            * (1.0 + 0.25 * along_noise(u, 5.0, seed + 1u));
        let shown = select(1.0 - scenery, 0.0, center.w <= 0.0) * painting.ground * is_drawn(done, u);
        let brush = vec4((0.28 - 0.08 * second) * (1.1 - 0.7 * u) * shown, clamp(0.05 + 0.6 * u, 0.0, 0.7), run, 0.6);
        brush_points[number * STROKE_POINTS + i] = BrushPoint(vec4(at, center.z, max(half, 0.0) * sign(shown)), brush);
    }
}

@compute @workgroup_size(64)
fn pose_painting(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = id.y * groups.x * 64u + id.x;
    if number >= painted.count {
        return;
    }
    let stroke = pool[number];
    if stroke.kind == GROUND {
        paint_ground(number, stroke.seed);
        return;
    }
    let first = number * STROKE_POINTS;
    let last = f32(STROKE_POINTS - 1u);
    var at: array<vec4<f32>, 24>;
    var world: array<vec3<f32>, 24>;
    // Half width in pixels, tone, visibility, load of the sides.
    var brush: array<vec4<f32>, 24>;
    for (var i = 0u; i < STROKE_POINTS; i++) {
        let stored = pool_points[first + i];
        let posed = posed_point(stored);
        var p = posed.position;
        if stroke.kind == TUFT {
            let u = f32(i) / last;
            p += posed.normal * stored.brush.x * instance.scale * 2.2 * u * u;
        }
        world[i] = p;
        at[i] = on_picture(p);
    }
    // Points of an axis are middles of chords, which are rarely through the centre of the limb. Those of a dab are on
    // the faces of a small part, such as a nose, and jump where it is coarse.
    let is_dab = stroke.kind == SPOT || stroke.kind == EYE;
    if pool_points[first].brush.z > 0.5 || is_dab {
        let rounds = select(AXIS_ROUNDS, DAB_ROUNDS, is_dab);
        for (var round = 0u; round < rounds; round++) {
            var before = world[0];
            for (var i = 1u; i + 1u < STROKE_POINTS; i++) {
                let here = world[i];
                world[i] = 0.25 * before + 0.5 * here + 0.25 * world[i + 1u];
                before = here;
            }
        }
        for (var i = 0u; i < STROKE_POINTS; i++) {
            at[i] = on_picture(world[i]);
        }
    }
    var tone_sum = 0.0;
    var seen_sum = 0.0;
    for (var i = 0u; i < STROKE_POINTS; i++) {
        let stored = pool_points[first + i];
        let posed = posed_point(stored);
        let before = select(i - 1u, 0u, i == 0u);
        let after = min(i + 1u, STROKE_POINTS - 1u);
        let tangent = world[after] - world[before];
        let on_axis = stored.brush.z > 0.5;
        let toward_eye = normalize_or(frame.eye_ws.xyz - posed.position * frame.eye_ws.w, painting.back_ws);
        var normal = posed.normal;
        if on_axis {
            normal = toward_eye;
        }
        let half = stored.brush.x * instance.scale;
        let even = distance(on_picture(world[i] + painting.right_ws * half).xy, at[i].xy);
        let across = normalize_or(cross(normal, tangent), painting.right_ws);
        let seen_half = distance(on_picture(world[i] + across * half).xy, at[i].xy);
        let half_px = select(max(seen_half, LEAST_WIDTH * even), even, on_axis);
        let facing = dot(normal, toward_eye);
        // Lids must not hide eyes.
        let hidden_by = select(VISIBLE, 2.0 * VISIBLE, stroke.kind == EYE);
        // Depth varies by about the size of a pixel within it.
        let pixel_m = half / max(even, 1e-3);
        let tolerance = max(hidden_by * painted.size, pixel_m) + select(0.0, 1.3 * posed.radius, on_axis);
        let seen = visible_at(at[i], tolerance) * smoothstep(-0.05, 0.2, facing);
        let tone = tone_at(stored.brush.y, normal, toward_eye);
        brush[i] = vec4(half_px, tone, seen, facing);
        tone_sum += tone * seen;
        seen_sum += seen;
    }
    let mean_tone = tone_sum / max(seen_sum, 1e-3);
    var visible_share = seen_sum / (last + 1.0);
    // Lids must not cut an eye: it is seen as a whole, or not.
    if stroke.kind == EYE {
        let whole = smoothstep(0.1, 0.4, visible_share);
        visible_share = 1.0;
        for (var i = 0u; i < STROKE_POINTS; i++) {
            brush[i].z = whole;
        }
    }
    var weight = 1.0;
    // More strokes than the washes have also lie on paler parts.
    let finer = mix(1.0, 0.4, clamp((painting.strokes - ALL_WASHES) / (MOST_STROKES - ALL_WASHES), 0.0, 1.0));
    if stroke.kind == PALE {
        weight = smoothstep(0.05, 0.11, mean_tone);
    } else if stroke.kind == MIDDLE {
        weight = smoothstep(0.36, 0.5, mean_tone / finer);
    } else if stroke.kind == DARK {
        weight = smoothstep(0.54, 0.7, mean_tone / finer);
    } else if stroke.kind == TUFT {
        let rim = 1.0 - smoothstep(0.12, 0.5, brush[0].w);
        weight = max(rim, smoothstep(0.25, 0.6, mean_tone) * 0.8);
    }
    weight *= smoothstep(0.1, 0.3, visible_share);
    // Ranks up to this number are painted; they end at 1.
    var shown = 2.0;
    if stroke.kind == PALE {
        shown = painting.strokes / 40.0;
    } else if stroke.kind == MIDDLE {
        shown = painting.strokes / 48.0;
    } else if stroke.kind == DARK {
        shown = 0.5 * painting.strokes / max(painted.darks, 1.0);
    } else if stroke.kind == TUFT {
        shown = 2.2 * painting.tufts / max(painted.tufts, 1.0);
    } else if stroke.kind == LOCK {
        weight *= smoothstep(0.0, FULL_HAIR, painting.tufts);
    }
    weight *= 1.0 - smoothstep(shown * 0.9, shown * 1.1 + 1e-4, stroke.rank);
    let chance = hashed(i32(stroke.seed & 0xffffu), 7, stroke.seed >> 16u);
    let seed = stroke.seed & 0xffffu;

    // A tuft grows as a whole.
    if stroke.kind == TUFT {
        for (var i = 0u; i < STROKE_POINTS; i++) {
            at[i] = vec4(mix(at[0].xy, at[i].xy, sqrt(clamp(weight, 0.0, 1.0))), at[i].zw);
        }
    }
    // A stroke whose visible part is short is narrower, so that it does not read as a bead.
    var long_px = 0.0;
    var wide_px = 0.0;
    var whole_px = 0.0;
    for (var i = 1u; i < STROKE_POINTS; i++) {
        whole_px += distance(at[i].xy, at[i - 1u].xy);
        long_px += distance(at[i].xy, at[i - 1u].xy) * 0.5 * (brush[i].z + brush[i - 1u].z);
        wide_px = max(wide_px, brush[i].x * brush[i].z);
    }
    long_px *= clamp(weight, 0.0, 1.0);
    var slender = 1.0;
    if stroke.kind <= DARK {
        slender = clamp(long_px / max(4.4 * wide_px, 1e-3), 0.25, 1.0);
        if stroke.kind == DARK {
            slender *= smoothstep(6.0, 11.0, long_px / max(wide_px, 1e-3));
        }
    }
    // A spot seen along its stroke is as flat as its part of the surface.
    var flat = 1.0;
    if stroke.kind == SPOT {
        var long_m = 0.0;
        for (var i = 1u; i < STROKE_POINTS; i++) {
            long_m += distance(world[i], world[i - 1u]);
        }
        let aside = on_picture(world[0] + painting.right_ws * max(long_m, 1e-6)).xy;
        flat = sqrt(clamp(whole_px / max(distance(aside, at[0].xy), 1e-3), 0.2, 1.0));
    }
    var run = 0.0;
    let done = done_share(stroke.kind, stroke.rank);
    for (var i = 0u; i < STROKE_POINTS; i++) {
        let u = f32(i) / last;
        let before = select(i - 1u, 0u, i == 0u);
        let after = min(i + 1u, STROKE_POINTS - 1u);
        if i > 0u {
            run += distance(at[i].xy, at[before].xy);
        }
        // Visibility is smoothed along the stroke.
        let seen = 0.25 * brush[before].z + 0.5 * brush[i].z + 0.25 * brush[after].z;
        let tone = brush[i].y;
        // A stroke grows in length with its weight.
        var grown = 1.0 - smoothstep(weight * 1.2 - 0.2, weight * 1.2, u);
        var half = brush[i].x;
        var density = 0.0;
        var dryness = 0.0;
        var side = 0.0;
        let direction = normalize_or2(at[after].xy - at[before].xy, vec2(1.0, 0.0));
        let right = vec2(-direction.y, direction.x);
        let loaded = clamp(dot(right, vec2(0.57, 0.82)) * 1.6, -0.85, 0.85);
        if stroke.kind <= DARK {
            let tier = stroke.kind;
            let start = select(select(0.12, 0.14, tier == MIDDLE), 0.16, tier == PALE);
            half *= (0.3 + 0.7 * pow(smoothstep(-0.02, start * 1.2, u), 0.8))
                * (1.0 - 0.8 * pow(clamp((u - 0.62) / 0.38, 0.0, 1.0), 1.5)) * (1.0 + 0.12 * along_noise(u, 3.0, seed));
            var base = 0.0;
            if tier == PALE {
                base = 0.06 + 0.8 * pow(tone, 1.1);
            } else if tier == MIDDLE {
                base = 0.3 + 1.3 * pow(clamp((tone - 0.34) / 0.6, 0.0, 1.0), 1.1);
            } else {
                base = 0.75 + 1.4 * clamp((tone - 0.5) / 0.4, 0.0, 1.0);
            }
            let onset = select(select(0.85, 0.6, tier == MIDDLE), 0.55, tier == PALE);
            density = base * (1.25 - 0.62 * u) * (onset + (1.0 - onset) * smoothstep(-0.02, 0.12, u))
                * (1.0 + 0.12 * along_noise(u, 2.5, seed + 3u)) * select(1.0, painting.wash, tier != DARK);
            dryness = clamp(-0.06 + 0.62 * pow(clamp((u - 0.4) / 0.6, 0.0, 1.0), 1.3) * (0.3 + 0.9 * chance),
                0.0, 0.68);
            if tier == DARK {
                dryness = clamp(0.06 + 0.64 * pow(clamp((u - 0.12) / 0.88, 0.0, 1.0), 1.1), 0.0, 0.7)
                    * select(0.3, 1.0, chance < 0.7);
            }
            side = loaded;
        } else if stroke.kind == BONE {
            half = max(half, 1.1 * painting.unit_px) * (1.0 + 0.1 * along_noise(u, 4.0, seed))
                * (1.0 - 0.7 * pow(clamp((u - 0.7) / 0.3, 0.0, 1.0), 2.0)) * (0.55 + 0.45 * smoothstep(-0.02, 0.12, u));
            density = clamp((0.35 + 1.75 * pool_points[first + i].brush.y)
                * (1.12 - 0.45 * u + 0.12 * along_noise(u, 3.0, seed + 5u))
                * (0.62 + 0.38 * smoothstep(-0.02, 0.1, u)), 0.2, 2.3);
            dryness = clamp(0.02 + 0.42 * u + 0.08 * along_noise(u, 5.0, seed + 9u), 0.0, 0.6);
            side = 0.25 * select(-1.0, 1.0, chance > 0.5);
        } else if stroke.kind == SPOT || stroke.kind == EYE {
            let ink = pool_points[first + i].brush.y;
            half = max(half * flat, 0.8 * ink * painting.unit_px) * select(0.98, 1.08, stroke.kind == EYE);
            density = ink * select(mix(2.1, 1.3, u), 2.5, stroke.kind == EYE);
            dryness = select(0.3 * u, 0.0, stroke.kind == EYE);
            side = select(0.3, 0.0, stroke.kind == EYE);
        } else if stroke.kind == LOCK {
            half *= (0.45 + 0.75 * smoothstep(0.0, 0.35, u)) * (1.0 - 0.65 * pow(u, 3.0));
            density = clamp(0.45 + 1.1 * pool_points[first + i].brush.y + 0.3 * (chance - 0.5), 0.35, 1.9);
            dryness = 0.04 + 0.45 * u;
        } else {
            half *= 0.35 + 0.9 * u;
            density = clamp(0.6 + 0.95 * pool_points[first].brush.y + 0.3 * (chance - 0.5), 0.35, 1.9);
            dryness = 0.02 + 0.5 * u;
            grown = smoothstep(0.05, 0.5, weight);
        }
        grown *= is_drawn(done, u);
        half = mix(brush[i].x * EVEN_WIDTH, half, select(painting.pressure, 1.0, stroke.kind >= SPOT));
        half *= (0.3 + 0.7 * seen) * smoothstep(0.0, 0.5, grown) * slender;
        density *= seen * grown * smoothstep(0.0, 0.2, slender);
        dryness *= 2.0 * painting.dryness;
        brush_points[first + i] = BrushPoint(vec4(at[i].xy, at[i].z, half), vec4(density, dryness, run, side));
    }
}

fn normalize_or2(v: vec2<f32>, fallback: vec2<f32>) -> vec2<f32> {
    let square = dot(v, v);
    return select(fallback, v * inverseSqrt(max(square, 1e-20)), square > 1e-12);
}
