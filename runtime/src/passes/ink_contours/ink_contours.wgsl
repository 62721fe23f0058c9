//! uses contours/block, ink/distance, surface/geometry
// Extraction of contour lines: the zero set of the cosine between normal and view direction over the mesh, as nodes on
// the edges that it crosses. Each face links two of its edges, so that lines have an order without any search.

@group(0) @binding(0) var<uniform> contours: Contours;
@group(0) @binding(1) var<storage, read> posed: array<GeometryVertex>;
@group(0) @binding(2) var<storage, read> rest: array<GeometryVertex>;
// Edges, faces, crease points, their predecessors and marks.
@group(0) @binding(3) var<storage, read> contour_mesh: array<u32>;
// Bit mask of the edges that contours cross.
@group(0) @binding(4) var<storage, read_write> crossed: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
// For each edge, the next and the previous crossed edge along the contour, plus 1; 0 for none.
@group(0) @binding(6) var<storage, read_write> links: array<u32>;
@group(0) @binding(7) var<storage, read_write> nodes: array<ContourNode>;
// State of the passes along lines: two vectors per node.
@group(0) @binding(8) var<storage, read_write> state: array<vec4<f32>>;
@group(0) @binding(9) var depths: texture_depth_2d;

// Vertices of the quads of a segment, a strip.
const STRIP_VERTICES: u32 = 10u;

fn thread_of(id: vec3<u32>, groups: vec3<u32>) -> u32 {
    return id.y * groups.x * 64u + id.x;
}

fn edge_of(number: u32) -> vec2<u32> {
    return vec2(contour_mesh[2u * number], contour_mesh[2u * number + 1u]);
}

// Returns a value whose sign tells whether a vertex faces the eye.
fn facing_of(vertex: u32) -> f32 {
    let v = posed[vertex];
    return dot(v.normal, contours.eye_ms.xyz - contours.eye_ms.w * v.position);
}

// Links the two edges through which the contour crosses a face. The side that faces the eye is always the same side of
// the line. A thread per face.
@compute @workgroup_size(64)
fn cross_faces(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = thread_of(id, groups);
    if number >= contours.faces {
        return;
    }
    let at = contours.faces_at + 4u * number;
    let flags = contour_mesh[at + 3u];
    var faces_eye = vec3(false);
    for (var k = 0u; k < 3u; k++) {
        let edge = edge_of(contour_mesh[at + k]);
        let corner = select(edge.x, edge.y, ((flags >> k) & 1u) == 1u);
        faces_eye[k] = facing_of(corner) > 0.0;
    }
    if all(faces_eye) || !any(faces_eye) {
        return;
    }
    // Along the border of the face, one edge goes out of sight and one comes into sight.
    var sinking = 0u;
    var rising = 0u;
    for (var k = 0u; k < 3u; k++) {
        let to_next = faces_eye[(k + 1u) % 3u];
        if faces_eye[k] && !to_next {
            sinking = contour_mesh[at + k];
        }
        if !faces_eye[k] && to_next {
            rising = contour_mesh[at + k];
        }
    }
    links[2u * rising] = sinking + 1u;
    links[2u * sinking + 1u] = rising + 1u;
    atomicOr(&crossed[rising / 32u], 1u << (rising % 32u));
    atomicOr(&crossed[sinking / 32u], 1u << (sinking % 32u));
}

const COUNTERS: u32 = 256u;

var<workgroup> contour_sums: array<u32, 256>;

// Counts, for each 32 edges, the crossed edges before them, and writes the draw arguments. One workgroup.
@compute @workgroup_size(256)
fn count_crossed(@builtin(local_invocation_index) local: u32) {
    let of_all = (contours.edges + 31u) / 32u;
    let each = (of_all + COUNTERS - 1u) / COUNTERS;
    let low = min(local * each, of_all);
    let high = min(low + each, of_all);
    var sum = 0u;
    for (var i = low; i < high; i++) {
        sum += countOneBits(atomicLoad(&crossed[i]));
    }
    contour_sums[local] = sum;
    workgroupBarrier();
    var before = 0u;
    for (var i = 0u; i < local; i++) {
        before += contour_sums[i];
    }
    for (var i = low; i < high; i++) {
        counts[COUNTS_HEAD + i] = before;
        before += countOneBits(atomicLoad(&crossed[i]));
    }
    if local == COUNTERS - 1u {
        let all = contours.creases + min(before, contours.most_nodes);
        counts[0] = STRIP_VERTICES;
        counts[1] = all;
        counts[2] = 0u;
        counts[3] = 0u;
        counts[4] = all;
        counts[5] = before;
    }
}

// Returns the node of an edge; NO_NODE if no contour crosses the edge, or the budget is exceeded.
fn node_of(edge: u32) -> u32 {
    let word = atomicLoad(&crossed[edge / 32u]);
    let bit = 1u << (edge % 32u);
    let rank = counts[COUNTS_HEAD + edge / 32u] + countOneBits(word & (bit - 1u));
    return select(NO_NODE, contours.creases + rank, (word & bit) != 0u && rank < contours.most_nodes);
}

// Returns the node of a link: the number of an edge plus 1, or 0.
fn linked_node(link: u32) -> u32 {
    if link == 0u {
        return NO_NODE;
    }
    return node_of(link - 1u);
}

// Returns whether the surface at a pixel is not in front of a distance from the eye: 0 or 1, and between them within
// the tolerance.
fn open_at(pixel: vec2<i32>, depth: f32, tolerance: f32) -> f32 {
    let at = clamp(pixel, vec2(0), vec2<i32>(contours.size) - 1);
    let surface = distance_of_depth(contours.depth_rows, textureLoad(depths, at, 0));
    return smoothstep(-1.0, -0.5, (surface - depth) / tolerance);
}

// Returns how visible a point is: the share of the surface nearby that is not in front of it. For a contour it is
// sampled on the outer side, because the surface itself hides the contour of a coarse mesh on its inner side. Samples
// are interpolated between pixels, so that the result has no steps while the point moves.
fn seen_share(px: vec2<f32>, outward: vec2<f32>, depth: f32, is_crease: bool) -> f32 {
    // Surfaces at a crease may be seen at a grazing angle.
    let tolerance = contours.tolerance * select(1.0, 2.0, is_crease);
    let along = vec2(-outward.y, outward.x);
    var sum = 0.0;
    for (var k = 0u; k < 15u; k++) {
        let row = k / 3u;
        var off = f32(row);
        if is_crease {
            off = 0.5 * f32(row) * select(1.0, -1.0, (row & 1u) == 1u);
        }
        let aside = 1.3 * (f32(k % 3u) - 1.0);
        let at = px + (outward * off + along * aside) * contours.unit - 0.5;
        let corner = vec2<i32>(floor(at));
        let share = at - floor(at);
        let upper = mix(open_at(corner, depth, tolerance), open_at(corner + vec2(1, 0), depth, tolerance), share.x);
        let lower = mix(
            open_at(corner + vec2(0, 1), depth, tolerance),
            open_at(corner + vec2(1, 1), depth, tolerance),
            share.x,
        );
        sum += mix(upper, lower, share.y);
    }
    return smoothstep(0.15, 0.65, sum / 15.0);
}

// Rows of pixels, one unit apart, in which the outline of a coarse mesh is looked for.
const OUTLINE_ROWS: u32 = 8u;

// Returns whether the surface at a pixel is the one at a distance from the eye: 0 or 1, and between them within the
// tolerance.
fn same_surface(pixel: vec2<i32>, depth: f32) -> f32 {
    let at = clamp(pixel, vec2(0), vec2<i32>(contours.size) - 1);
    let surface = distance_of_depth(contours.depth_rows, textureLoad(depths, at, 0));
    return 1.0 - smoothstep(1.0, 2.0, abs(surface - depth) / contours.tolerance);
}

// Returns the distance from a node to the outline of its surface, outwards, pixels. The zero set of smooth normals lies
// inside the outline of a coarse mesh. 0 if the surface continues farther than the rows reach.
fn distance_to_outline(px: vec2<f32>, outward: vec2<f32>, depth: f32) -> f32 {
    var covered = 1.0;
    var sum = 0.0;
    for (var row = 0u; row < OUTLINE_ROWS; row++) {
        let at = px + outward * (f32(row) + 0.5) * contours.unit - 0.5;
        let corner = vec2<i32>(floor(at));
        let share = at - floor(at);
        let upper = mix(same_surface(corner, depth), same_surface(corner + vec2(1, 0), depth), share.x);
        let lower = mix(same_surface(corner + vec2(0, 1), depth), same_surface(corner + vec2(1, 1), depth), share.x);
        covered = min(covered, mix(upper, lower, share.y));
        sum += covered;
    }
    return sum * contours.unit * (1.0 - covered);
}

// Writes a node between two vertices. `share`: that of the second vertex.
fn place_node(number: u32, ends: vec2<u32>, share: f32, neighbors: vec2<u32>, is_crease: bool) {
    let a = posed[ends.x];
    let b = posed[ends.y];
    let position = mix(a.position, b.position, share);
    let normal = mix(a.normal, b.normal, share);
    let clip = contours.clip_from_model * vec4(position, 1.0);
    let w = select(clip.w, 1e-6, clip.w < 1e-6);
    let ndc = clip.xyz / w;
    let to_px = vec2(0.5, -0.5) * contours.size;
    let turned = contours.clip_from_model * vec4(normal, 0.0);
    let aside = (turned.xy - ndc.xy * turned.w) * to_px;
    let long = length(aside);
    var node: ContourNode;
    node.px = ndc.xy * to_px + 0.5 * contours.size;
    node.depth = distance_of_depth(contours.depth_rows, ndc.z);
    node.outward = select(vec2(0.0, -1.0), aside / max(long, 1e-20), long > 1e-20);
    let marks = mix(
        unpack4x8unorm(contour_mesh[contours.marks_at + ends.x]),
        unpack4x8unorm(contour_mesh[contours.marks_at + ends.y]),
        share,
    );
    node.marks = pack4x8unorm(vec4(marks.xyz, select(0.0, 1.0, is_crease)));
    node.rest = mix(rest[ends.x].position, rest[ends.y].position, share) * contours.rest_scale;
    node.next = neighbors.x;
    node.previous = neighbors.y;
    node.weight = 0.0;
    if clip.w > 1e-6 {
        node.weight = seen_share(node.px, node.outward, node.depth, is_crease);
        if !is_crease {
            node.px += node.outward * distance_to_outline(node.px, node.outward, node.depth);
        }
    }
    nodes[number] = node;
    state[2u * number] = vec4(node.px, node.weight * marks.x, 0.0);
    state[2u * number + 1u] = vec4(0.0);
}

// Places the nodes of contours. A thread per edge.
@compute @workgroup_size(64)
fn place_contours(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let edge = thread_of(id, groups);
    if edge >= contours.edges {
        return;
    }
    let number = node_of(edge);
    if number == NO_NODE {
        return;
    }
    let ends = edge_of(edge);
    let a = facing_of(ends.x);
    let b = facing_of(ends.y);
    let between = a - b;
    let share = select(clamp(a / between, 0.0, 1.0), 0.5, between == 0.0);
    let neighbors = vec2(linked_node(links[2u * edge]), linked_node(links[2u * edge + 1u]));
    place_node(number, ends, share, neighbors, false);
}

// Places the nodes of creases. A thread per crease point.
@compute @workgroup_size(64)
fn place_creases(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let number = thread_of(id, groups);
    if number >= contours.creases {
        return;
    }
    let at = contours.creases_at + 4u * number;
    let ends = vec2(contour_mesh[at], contour_mesh[at + 1u]);
    let share = f32(contour_mesh[at + 2u] & 0xffffu) / 65535.0;
    let neighbors = vec2(contour_mesh[at + 3u], contour_mesh[contours.previous_at + number]);
    place_node(number, ends, share, neighbors, true);
}
