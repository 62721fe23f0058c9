//! uses hair/nearest, hair/packed_light
// Gathering of the nearest hair segments in each pixel (formulas 4.11), in two rounds over all segments. The first
// round sorts keys; the second stores the light of the nearest segments. The result does not depend on the order of
// threads.

struct Frame {
    clip_from_world: mat4x4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
// Indirect draw arguments. `ribbons`: corners with world-space position and light.
@group(1) @binding(0) var<storage, read> counts: array<u32>;
@group(1) @binding(1) var<storage, read> ribbons: array<vec4<u32>>;
@group(1) @binding(2) var<storage, read_write> keys: array<atomic<u32>>;
@group(1) @binding(3) var<storage, read_write> lights: array<atomic<u32>>;
// Indirect draw arguments of the gathered layers, then the tile and layer of each instance.
@group(1) @binding(4) var<storage, read_write> layers: array<atomic<u32>>;
@group(1) @binding(5) var<uniform> nearest: NearestHair;

// Screen-space end of a segment.
struct End {
    // Position on screen, pixels.
    at: vec2<f32>,
    // Depth, 1 at the near plane and 0 at the far plane.
    depth: f32,
    // Half width, pixels.
    half: f32,
    // Unit vector along the strand, perpendicular to the line that separates this segment from the next.
    along: vec2<f32>,
    light: vec3<f32>,
}

// Both clip-space corners of a segment's end, and its light.
struct Corners {
    left: vec4<f32>,
    right: vec4<f32>,
    light: vec3<f32>,
}

// Returns both corners of the segment end whose first corner is `first`.
fn corners_at(first: u32) -> Corners {
    let left = ribbons[first];
    let a = frame.clip_from_world * vec4(bitcast<vec3<f32>>(left.xyz), 1.0);
    let b = frame.clip_from_world * vec4(bitcast<vec3<f32>>(ribbons[first + 1u].xyz), 1.0);
    return Corners(a, b, unpacked_light(left.w));
}

// Returns the distance behind the near plane, in clip space; negative in front of it.
fn behind_near(corners: Corners) -> f32 {
    let middle = 0.5 * (corners.left + corners.right);
    return select(middle.z, middle.w - middle.z, REVERSED_DEPTH);
}

// Returns the end at the share `share` of the way from one end to the other.
fn between(a: Corners, b: Corners, share: f32) -> Corners {
    return Corners(mix(a.left, b.left, share), mix(a.right, b.right, share), mix(a.light, b.light, share));
}

// Returns the screen position of a clip-space position, pixels, and its depth.
fn on_screen(clip: vec4<f32>) -> vec3<f32> {
    let ndc = clip.xyz / clip.w;
    return vec3((vec2(0.5, -0.5) * ndc.xy + 0.5) * nearest.size, ndc.z);
}

// Returns the screen-space end of a segment.
fn end(corners: Corners) -> End {
    let a = on_screen(corners.left);
    let b = on_screen(corners.right);
    let aside = 0.5 * (b.xy - a.xy);
    let half = length(aside);
    var out: End;
    out.at = a.xy + aside;
    out.depth = 0.5 * (a.z + b.z);
    out.half = half;
    out.along = vec2(aside.y, -aside.x) / half;
    out.light = corners.light;
    return out;
}

// Returns the z component of the cross product of two vectors in the plane.
fn cross_2(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// Inserts a key into the sorted list of a pixel; nearer keys shift others back. A key that no longer fits adds to the
// optical depth behind the list.
fn insert(pixel: u32, found: u32) {
    let first = OF_A_PIXEL * pixel;
    var key = found;
    for (var k = 0u; k < NEAREST; k++) {
        let there = atomicMax(&keys[first + k], key);
        key = min(there, key);
        if key == 0u {
            return;
        }
    }
    atomicAdd(&keys[first + NEAREST], u32(-OPTICAL_DEPTH * log(max(1.0 - covered_by(key), 1e-3)) + 0.5));
}

// Stores the light of a key. If two segments have equal keys, the larger value is kept, so that the order of threads
// has no effect.
fn store_light(pixel: u32, key: u32, light: u32) {
    for (var k = 0u; k < NEAREST; k++) {
        let there = atomicLoad(&keys[OF_A_PIXEL * pixel + k]);
        if there == key {
            atomicMax(&lights[NEAREST * pixel + k], light);
        } else if there < key {
            return;
        }
    }
}

// Maximum size of a segment on screen, pixels. Larger ones fill the picture or are NaN.
const MOST_PX: f32 = 1e6;

// Gathers the nearest segments, with one thread per segment.
@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let piece = id.y * groups.x * 64u + id.x;
    // A segment has six indices.
    if piece >= counts[0] / 6u {
        return;
    }
    let first = 2u * (piece + piece / nearest.pieces);
    var root = corners_at(first);
    var tip = corners_at(first + 2u);
    // Clip to the near plane; only the part behind it is visible.
    let root_behind = behind_near(root);
    let tip_behind = behind_near(tip);
    if root_behind <= 0.0 && tip_behind <= 0.0 {
        return;
    }
    if root_behind <= 0.0 {
        root = between(root, tip, root_behind / (root_behind - tip_behind));
    } else if tip_behind <= 0.0 {
        tip = between(root, tip, root_behind / (root_behind - tip_behind));
    }
    var a = end(root);
    var b = end(tip);
    let way = b.at - a.at;
    let long = length(way);
    // Reject sizes that are too large or NaN.
    if !(long + a.half + b.half < MOST_PX) {
        return;
    }
    let axis = way / max(long, 1e-6);
    // A tip has no width from which to derive a direction.
    a.along = select(axis, a.along, a.half > 1e-4);
    b.along = select(axis, b.along, b.half > 1e-4);
    a.along *= select(1.0, -1.0, dot(a.along, axis) < 0.0);
    b.along *= select(1.0, -1.0, dot(b.along, axis) < 0.0);

    // Iterate over rows along the longer axis; each row covers the width plus half a pixel on either side.
    let by_columns = abs(way.x) > abs(way.y);
    let from_1 = select(a.at.y, a.at.x, by_columns);
    let to_1 = select(b.at.y, b.at.x, by_columns);
    let from_2 = select(a.at.x, a.at.y, by_columns);
    let area_from = vec2<f32>(nearest.area.xy);
    let area_to = area_from + vec2<f32>(nearest.area.zw);
    let low_1 = select(area_from.y, area_from.x, by_columns);
    let low_2 = select(area_from.x, area_from.y, by_columns);
    let high_1 = select(area_to.y, area_to.x, by_columns);
    let high_2 = select(area_to.x, area_to.y, by_columns);
    let reach = max(a.half, b.half) + 0.5;
    let run = select(axis.y, axis.x, by_columns);
    let slope = select(axis.x, axis.y, by_columns) / select(run, 1.0, abs(run) < 1e-6);
    let reach_2 = reach * sqrt(1.0 + slope * slope);
    let begin_1 = floor(max(min(from_1, to_1) - reach, low_1));
    let end_1 = min(max(from_1, to_1) + reach, high_1);
    for (var row = begin_1 + 0.5; row < end_1; row += 1.0) {
        let middle = from_2 + (row - from_1) * slope;
        let begin_2 = floor(max(middle - reach_2, low_2));
        let end_2 = min(middle + reach_2, high_2);
        for (var column = begin_2 + 0.5; column < end_2; column += 1.0) {
            let pixel = select(vec2(column, row), vec2(row, column), by_columns);
            // Assign every pixel to exactly one of the segments that meet at a point.
            let since = dot(pixel - a.at, a.along);
            let until = dot(b.at - pixel, b.along);
            if since < 0.0 || until <= 0.0 {
                continue;
            }
            let share = since / (since + until);
            let half = mix(a.half, b.half, share);
            let off = abs(cross_2(axis, pixel - a.at));
            let covered = min(min(off + 0.5, half) - max(off - 0.5, -half), 1.0);
            let depth = mix(a.depth, b.depth, share);
            if covered * 255.0 < 0.5 || depth <= 0.0 || depth >= 1.0 {
                continue;
            }
            let key = nearest_key(depth, covered);
            let number = pixel_number(vec2<u32>(pixel) - nearest.area.xy);
            if nearest.round == 1u {
                store_light(number, key, packed_light(mix(a.light, b.light, share)));
            } else {
                insert(number, key);
            }
        }
    }
}

const DRAW_ARGUMENTS: u32 = 4u;

var<workgroup> most: atomic<u32>;

// Lists the layers of a tile, the farthest first: as many as its fullest pixel has segments. One workgroup per tile.
@compute @workgroup_size(64)
fn list_layers(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tile = group.y * groups.x + group.x;
    let across = nearest.area.z / TILE;
    let tiles = across * (nearest.area.w / TILE);
    if tile < tiles {
        let at = TILE * vec2(tile % across, tile / across) + vec2(local % TILE, local / TILE);
        let place = OF_A_PIXEL * pixel_number(at);
        var found = 0u;
        while found < NEAREST && atomicLoad(&keys[place + found]) != 0u {
            found += 1u;
        }
        atomicMax(&most, found);
    }
    workgroupBarrier();
    if tile < tiles && local == 0u {
        let count = atomicLoad(&most);
        // Each layer of a tile is one instance with six vertices, two triangles.
        atomicMax(&layers[0], 6u);
        let next = DRAW_ARGUMENTS + atomicAdd(&layers[1], count);
        for (var k = 0u; k < count; k++) {
            atomicStore(&layers[next + k], NEAREST * tile + count - 1u - k);
        }
    }
}
