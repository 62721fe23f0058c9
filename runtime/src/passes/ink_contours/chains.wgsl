//! uses contours/block
// Passes along contour lines: smoothing, gaps, corners, and the brush of each node.
//
// Most passes walk along the line from each node. Distances from the ends of strokes are found by pointer jumping: in
// round k, each node reads the node 2^k away.

@group(0) @binding(0) var<uniform> contours: Contours;
@group(0) @binding(1) var<storage, read> counts: array<u32>;
@group(0) @binding(2) var<storage, read> nodes: array<ContourNode>;
@group(0) @binding(3) var<storage, read> before: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> after: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> line_nodes: array<LineNode>;
@group(0) @binding(6) var washed: texture_2d<f32>;
@group(0) @binding(7) var washed_sampler: sampler;

// Maximum number of nodes of a walk.
const STEPS: u32 = 48u;
// Number of samples on each side of a node in a walk.
const SAMPLES: u32 = 6u;
// Standard deviation of the smoothing of positions, units.
const SMOOTHING: f32 = 4.0;
// Half length of the gaps that are closed, units.
const GAP: f32 = 5.0;
// Distance at which the turn of a line is measured, units.
const TURN_AT: f32 = 8.0;
// Turn at which a corner begins to divide a line, and at which it does, radians: 45 and 68 degrees. Smoothing has
// rounded the corners before.
const CORNER: vec2<f32> = vec2(0.785, 1.187);
// Direction towards the light on the screen.
const LIT_FROM: vec2<f32> = vec2(-0.57, -0.82);
// Half width of lines as a share of the model's diagonal.
const HALF_WIDTH: f32 = 0.0036;
// Lengths at which strokes begin to appear and are complete, as shares of the model's diagonal.
const SCRAP: vec2<f32> = vec2(0.03, 0.055);

fn chain_thread(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * 64u + id.x;
}

// Position of a walk along a line.
struct Walk {
    // Node before the position, and the node after it; NO_NODE beyond the end.
    here: u32,
    there: u32,
    // Pixel positions of both, distance along the line of the first, and of the second.
    from_px: vec2<f32>,
    to_px: vec2<f32>,
    low: f32,
    high: f32,
    steps: u32,
}

fn neighbor(node: u32, forward: bool) -> u32 {
    return select(nodes[node].previous, nodes[node].next, forward);
}

fn begin_walk(node: u32, forward: bool) -> Walk {
    var walk: Walk;
    walk.here = node;
    walk.there = neighbor(node, forward);
    walk.from_px = before[2u * node].xy;
    walk.to_px = walk.from_px;
    walk.low = 0.0;
    walk.high = 0.0;
    walk.steps = 0u;
    if walk.there != NO_NODE {
        walk.to_px = before[2u * walk.there].xy;
        walk.high = distance(walk.from_px, walk.to_px);
    }
    return walk;
}

// Moves a walk to the segment that contains the distance `s`.
fn walk_to(start: Walk, s: f32, forward: bool) -> Walk {
    var walk = start;
    while walk.there != NO_NODE && walk.high < s && walk.steps < STEPS {
        let next = neighbor(walk.there, forward);
        walk.here = walk.there;
        walk.from_px = walk.to_px;
        walk.low = walk.high;
        walk.there = next;
        if next != NO_NODE {
            walk.to_px = before[2u * next].xy;
            walk.high += distance(walk.from_px, walk.to_px);
        }
        walk.steps += 1u;
    }
    return walk;
}

// Returns the share of the second node at the distance `s`.
fn share_at(walk: Walk, s: f32) -> f32 {
    return clamp((s - walk.low) / max(walk.high - walk.low, 1e-6), 0.0, 1.0);
}

// Returns the pixel position at the distance `s`; that of the end beyond it.
fn px_at(walk: Walk, s: f32) -> vec2<f32> {
    if walk.there == NO_NODE {
        return walk.from_px;
    }
    return mix(walk.from_px, walk.to_px, share_at(walk, s));
}

// Returns the weight at the distance `s`; that of the end beyond it.
fn weight_at(walk: Walk, s: f32) -> f32 {
    if walk.there == NO_NODE {
        return before[2u * walk.here].z;
    }
    return mix(before[2u * walk.here].z, before[2u * walk.there].z, share_at(walk, s));
}

// Smooths positions along lines with a Gaussian by distance, so that coarse and dense meshes get the same lines. Near
// an end, both sides shrink, so that the end stays.
@compute @workgroup_size(64)
fn smooth_lines(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    let here = before[2u * i];
    let step = 2.0 * SMOOTHING * contours.unit / f32(SAMPLES);
    var ahead = begin_walk(i, true);
    var behind = begin_walk(i, false);
    var sum = here.xy;
    var total = 1.0;
    for (var k = 1u; k <= SAMPLES; k++) {
        let s = f32(k) * step;
        ahead = walk_to(ahead, s, true);
        behind = walk_to(behind, s, false);
        let ends_ahead = ahead.there == NO_NODE && s > ahead.low + 1e-3;
        let ends_behind = behind.there == NO_NODE && s > behind.low + 1e-3;
        if ends_ahead || ends_behind {
            break;
        }
        let off = s / (SMOOTHING * contours.unit);
        let weight = exp(-0.5 * off * off);
        sum += weight * (px_at(ahead, s) + px_at(behind, s));
        total += 2.0 * weight;
    }
    after[2u * i] = vec4(sum / total, here.zw);
    after[2u * i + 1u] = before[2u * i + 1u];
}

// Returns the largest weight near a node if `sign` is 1, or the negated smallest if it is -1.
fn widest_weight(i: u32, sign: f32) -> f32 {
    let step = GAP * contours.unit / f32(SAMPLES);
    var ahead = begin_walk(i, true);
    var behind = begin_walk(i, false);
    var most = sign * before[2u * i].z;
    for (var k = 1u; k <= SAMPLES; k++) {
        let s = f32(k) * step;
        ahead = walk_to(ahead, s, true);
        behind = walk_to(behind, s, false);
        let w = sign * vec2(weight_at(ahead, s), weight_at(behind, s));
        most = max(most, max(w.x, w.y));
    }
    return most;
}

// First half of the closing of gaps: each node takes the largest weight nearby.
@compute @workgroup_size(64)
fn widen_lines(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    let here = before[2u * i];
    after[2u * i] = vec4(here.xy, widest_weight(i, 1.0), here.w);
    after[2u * i + 1u] = before[2u * i + 1u];
}

// Second half: each node takes the smallest weight nearby.
@compute @workgroup_size(64)
fn narrow_lines(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    let here = before[2u * i];
    after[2u * i] = vec4(here.xy, -widest_weight(i, -1.0), here.w);
    after[2u * i + 1u] = before[2u * i + 1u];
}

// Returns how much a line is needed, 0..=1: where the wash does not show the edge already, in shadow, and on the head.
//
// `inside`, `outside`: density of the wash on both sides; `lit`: 1 towards the light, -1 away from it; `noise`: smooth
// noise of the surface, -1..=1.
fn line_need(inside: f32, outside: f32, lit: f32, emphasis: f32, noise: f32) -> f32 {
    // Lit edges of bodies without a wash have nothing else.
    let left_out = 0.38 * smoothstep(0.1, 0.9, lit) * mix(0.8, 1.0, smoothstep(0.03, 0.15, inside));
    let need = 0.94 - 1.15 * smoothstep(0.15, 0.6, abs(inside - outside)) - left_out
        + 0.22 * smoothstep(0.0, 0.8, -lit) + 0.4 * emphasis + 0.18 * smoothstep(0.05, 0.2, outside) + 0.42 * noise;
    return smoothstep(0.47, 0.67, need);
}

// Distance from a line at which the wash beside it is compared, 1/424 of the picture's height.
const BESIDE: f32 = 5.0;

// Returns the density of the washes at a pixel.
fn washed_at(px: vec2<f32>) -> f32 {
    return textureSampleLevel(washed, washed_sampler, px / contours.size, 0.0).z;
}

fn angle_between(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return abs(atan2(a.x * b.y - a.y * b.x, dot(a, b)));
}

// Returns the length of a short closed line through a node; a large number if the line is open or long.
fn loop_length(i: u32, most: f32) -> f32 {
    var walk = begin_walk(i, true);
    for (var k = 0u; k < STEPS; k++) {
        if walk.there == NO_NODE || walk.high > most {
            break;
        }
        if walk.there == i {
            return walk.high;
        }
        let next = neighbor(walk.there, true);
        if next != NO_NODE {
            walk.high += distance(before[2u * walk.there].xy, before[2u * next].xy);
        }
        walk.there = next;
    }
    return 1e9;
}

// Begins the search for the ends of strokes, and writes all of a drawn node that does not depend on them.
@compute @workgroup_size(64)
fn begin_strokes(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    let node = nodes[i];
    let here = before[2u * i];
    let near = 2.0 * contours.unit;
    let far = TURN_AT * contours.unit;
    let ahead_near = walk_to(begin_walk(i, true), near, true);
    let behind_near = walk_to(begin_walk(i, false), near, false);
    let ahead_far = walk_to(ahead_near, far, true);
    let behind_far = walk_to(behind_near, far, false);
    let along = px_at(ahead_near, near) - px_at(behind_near, near);
    let tangent = along * inverseSqrt(max(dot(along, along), 1e-12));
    let to_far = px_at(ahead_far, far) - here.xy;
    let from_far = here.xy - px_at(behind_far, far);
    let whole = min(length(to_far), length(from_far)) > 0.5 * far;
    let turn = select(0.0, angle_between(from_far, to_far), whole);

    let marks = unpack4x8unorm(node.marks);
    let lit = dot(node.outward, LIT_FROM);
    let noise = (space_noise(7.0 * node.rest, 1u) - 0.5) * 1.6;
    let beside = BESIDE * contours.unit * node.outward;
    let need = mix(1.0, line_need(washed_at(here.xy - beside), washed_at(here.xy + beside), lit, marks.y, noise),
        contours.omission);
    let shown = here.z * (1.0 - smoothstep(CORNER.x, CORNER.y, turn)) * need;
    // Squared, so that strokes grow over a wide range of visibility.
    let weight = shown * shown;

    let most = END_REACH * contours.diagonal;
    // A closed line has no ends, so a short one is recognised by its length.
    let own = min(most * weight, 0.5 * loop_length(i, 0.08 * contours.diagonal));
    var previous_px = 0.0;
    var next_px = 0.0;
    if node.previous != NO_NODE {
        previous_px = distance(here.xy, before[2u * node.previous].xy);
    }
    if node.next != NO_NODE {
        next_px = distance(here.xy, before[2u * node.next].xy);
    }
    let from_start = select(own, 0.0, node.previous == NO_NODE);
    let to_end = select(own, 0.0, node.next == NO_NODE);
    after[2u * i] = vec4(from_start, previous_px, bitcast<f32>(node.previous), 0.0);
    after[2u * i + 1u] = vec4(to_end, next_px, bitcast<f32>(node.next), 0.0);

    var drawn: LineNode;
    drawn.px = here.xy;
    drawn.tangent = tangent;
    drawn.brush = vec4(0.0, marks.z, lit, weight);
    drawn.rest = node.rest;
    drawn.next = node.next;
    drawn.ends = vec4(0.0, 0.0, turn, node.depth);
    line_nodes[i] = drawn;
}

// Returns the distance to an end, the distance to the node of the link, and the link, after another round.
fn jumped(own: vec4<f32>, half: u32) -> vec4<f32> {
    let link = bitcast<u32>(own.z);
    if link == NO_NODE {
        return own;
    }
    let other = before[2u * link + half];
    return vec4(min(own.x, other.x + own.y), own.y + other.y, other.z, 0.0);
}

// Round of pointer jumping: the distance from the start of a stroke is the least, over all nodes before it, of the
// distance to that node plus the weight there. Distances are continuous in time because weights are, so that strokes
// appear and disappear by growing from a point.
@compute @workgroup_size(64)
fn jump_lines(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    after[2u * i] = jumped(before[2u * i], 0u);
    after[2u * i + 1u] = jumped(before[2u * i + 1u], 1u);
}

// Share of the painting during which lines are drawn: from the first number to the second.
const LINES_DRAWN: vec2<f32> = vec2(0.7, 0.92);

// Returns 1 on lines that are drawn already, from the top of the model to the bottom; otherwise 0.
//
// `down`: share of the model above the node; `along`: share of the stroke before it.
fn painted_share(down: f32, along: f32) -> f32 {
    let done = clamp((contours.progress - LINES_DRAWN.x) / (LINES_DRAWN.y - LINES_DRAWN.x), 0.0, 1.0);
    return smoothstep(-0.02, 0.0, 1.35 * done - clamp(down, 0.0, 1.0) - 0.35 * clamp(along, 0.0, 1.0));
}

// Computes the brush of each node. Noise belongs to the surface.
@compute @workgroup_size(64)
fn load_brush(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let i = chain_thread(id, groups);
    if i >= counts[4] {
        return;
    }
    let drawn = line_nodes[i];
    let diagonal = contours.diagonal;
    let from_start = before[2u * i].x;
    let to_end = before[2u * i + 1u].x;
    let long = from_start + to_end;
    let darkness = drawn.brush.y;
    let lit = drawn.brush.z;
    let rest = drawn.rest;
    let slow = smoothstep(0.004, 0.05, 0.11 * drawn.ends.z);
    let pressed = 1.0 + 0.9 * (space_noise(22.0 * rest, 2u) - 0.5);
    let swell = (0.5 + 0.75 * smoothstep(-0.5, 0.8, -lit)) * (0.75 + 0.6 * min(1.0, long / (0.22 * diagonal)))
        * pressed * (1.0 + 0.55 * (slow - 0.35));
    var half = HALF_WIDTH * diagonal * contours.width * mix(0.8, swell, contours.pressure);
    // Short strokes vanish, shorter ones on the head.
    let scrap = SCRAP * mix(1.0, 0.5, unpack4x8unorm(nodes[i].marks).y);
    half *= smoothstep(scrap.x, scrap.y, long / diagonal);
    // Share of the stroke that is drawn, from its upper end.
    let down = smoothstep(-0.5, 0.5, drawn.tangent.y);
    let drawn_share = mix(to_end, from_start, down) / max(long, 1e-3);
    var tone = 0.7 + 1.1 * smoothstep(-0.6, 0.8, -lit) + 0.45 * darkness;
    tone *= (1.1 - 0.35 * drawn_share) * (1.0 + 0.45 * (space_noise(16.0 * rest, 3u) - 0.5));
    let pressure = line_pressure(diagonal, from_start, to_end, drawn.tangent.y).x;
    let fast = (1.0 - slow) * min(1.0, long / (0.18 * diagonal));
    let dry = (0.66 * pow(drawn_share, 1.1) + 0.5 * (space_noise(20.0 * rest, 4u) - 0.5)) * fast - 0.02;
    let painted = painted_share((drawn.px.y - contours.top) / diagonal, drawn_share);
    half *= painted;
    tone *= painted;
    let dryness = clamp(dry * contours.dryness, 0.0, 0.7);
    line_nodes[i].brush = vec4(half, clamp(tone, 0.35 * painted, 2.3), dryness, drawn.brush.w);
    line_nodes[i].ends = vec4(from_start, to_end, drawn.ends.z, half * pressure);
}
