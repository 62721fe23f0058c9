// Contour lines: uniform block of an instance, nodes of its lines, and smooth noise.

// Uniform block, one per drawn instance and frame.
struct Contours {
    clip_from_model: mat4x4<f32>,
    // Eye position with w = 1; for a parallel projection, the direction towards the eye with w = 0. Model space.
    eye_ms: vec4<f32>,
    // Elements of the projection: depth and w in clip space are linear in the z coordinate of the view.
    depth_rows: vec4<f32>,
    // Size of the picture, pixels.
    size: vec2<f32>,
    // Diagonal of the model's bounds, pixels.
    diagonal: f32,
    // Pixels per 1/424 of the picture's height.
    unit: f32,
    // Distance along the view within which a surface does not hide a line, metres.
    tolerance: f32,
    // Factor on stored positions: they become shares of the model's diagonal.
    rest_scale: f32,
    // Factor on the width of lines.
    width: f32,
    // Factor on the dryness of lines.
    dryness: f32,
    // Numbers of edges, faces and crease points, and maximum number of crossed edges.
    edges: u32,
    faces: u32,
    creases: u32,
    most_nodes: u32,
    // Positions in the contour mesh, words: faces, crease points, their predecessors, and marks.
    faces_at: u32,
    creases_at: u32,
    previous_at: u32,
    marks_at: u32,
    // Variation of the width, 0..=1.
    pressure: f32,
    // Share of the contour that is left out, where washes already show it.
    omission: f32,
    // Share of the painting that is done.
    progress: f32,
    // Row in which the model begins, pixels.
    top: f32,
    reserved: vec3<f32>,
    // Period of the paper, pixels.
    paper_period: f32,
}

// Point of a line, as extracted from the mesh. Size: 64 bytes.
struct ContourNode {
    px: vec2<f32>,
    // Distance along the view direction, metres.
    depth: f32,
    // Visibility, 0..=1.
    weight: f32,
    // Unit vector on the screen away from the body.
    outward: vec2<f32>,
    // Amount of lines, emphasis and darkness, unorm 4x8; the fourth is 1 for creases.
    marks: u32,
    // Neighbours in the line; NO_NODE at its ends.
    next: u32,
    // Stored position as a share of the model's diagonal.
    rest: vec3<f32>,
    previous: u32,
    reserved: vec4<f32>,
}

// Point of a line, as it is drawn. Size: 64 bytes.
struct LineNode {
    px: vec2<f32>,
    // Unit tangent.
    tangent: vec2<f32>,
    // Half width in pixels before the pressure of the brush, density, dryness, and weight.
    brush: vec4<f32>,
    rest: vec3<f32>,
    next: u32,
    // Distances from both ends of the stroke along the line, at most END_REACH of the diagonal; turn in radians;
    // half width under the pressure of the brush, pixels.
    ends: vec4<f32>,
}

const NO_NODE: u32 = 0xffffffffu;
// Words of the counts before those of the edges: arguments of the draw, number of nodes, number of crossed edges.
const COUNTS_HEAD: u32 = 8u;
// Limit of distances from the ends of strokes, as a share of the model's diagonal.
const END_REACH: f32 = 0.3;

// Returns a hash of three whole numbers and a seed, 0..1.
fn lattice_hash(p: vec3<i32>, seed: u32) -> f32 {
    var x = (u32(p.x) * 73856093u) ^ (u32(p.y) * 19349663u) ^ (u32(p.z) * 83492791u) ^ (seed * 2654435761u);
    x = (x ^ (x >> 13u)) * 1274126177u;
    x = x ^ (x >> 16u);
    return f32(x & 0xffffu) / 65535.0;
}

// Returns smooth noise in space, 0..1, with one random value per unit.
fn space_noise(p: vec3<f32>, seed: u32) -> f32 {
    let cell = floor(p);
    let f = p - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let c = vec3<i32>(cell);
    let y0z0 = mix(lattice_hash(c, seed), lattice_hash(c + vec3(1, 0, 0), seed), s.x);
    let y1z0 = mix(lattice_hash(c + vec3(0, 1, 0), seed), lattice_hash(c + vec3(1, 1, 0), seed), s.x);
    let y0z1 = mix(lattice_hash(c + vec3(0, 0, 1), seed), lattice_hash(c + vec3(1, 0, 1), seed), s.x);
    let y1z1 = mix(lattice_hash(c + vec3(0, 1, 1), seed), lattice_hash(c + vec3(1, 1, 1), seed), s.x);
    return mix(mix(y0z0, y1z0, s.y), mix(y0z1, y1z1, s.y), s.z);
}

// Length over which a stroke reaches its width, and over which it lifts, as shares of the model's diagonal.
const LINE_ONSET: f32 = 0.022;
const LINE_LIFT: f32 = 0.07;
// Lengths of onset and lift as shares of the stroke.
const LINE_ONSET_SHARE: f32 = 0.16;
const LINE_LIFT_SHARE: f32 = 0.35;

// Returns the pressure of the brush at distances from both ends of a stroke: a blunt onset, a press, and a long lift.
// The upper end is the start. `diagonal`: of the model, pixels;
// `tangent_y`: downward component of the tangent.
fn line_pressure(diagonal: f32, from_start: f32, to_end: f32, tangent_y: f32) -> vec2<f32> {
    let down = smoothstep(-0.5, 0.5, tangent_y);
    let long = max(from_start + to_end, 1e-3);
    let onset = min(LINE_ONSET * diagonal, LINE_ONSET_SHARE * long);
    let lift = min(LINE_LIFT * diagonal, LINE_LIFT_SHARE * long);
    let begun = vec2(from_start, to_end) / vec2(mix(lift, onset, down), mix(onset, lift, down));
    let t = clamp(begun, vec2(0.0), vec2(1.0));
    // A blunt end is round, a lifted one tapers.
    let blunt = pow(1.0 - (1.0 - t) * (1.0 - t), vec2(0.6));
    let tapered = pow(t, vec2(0.75));
    let shape = mix(vec2(tapered.x, blunt.y), vec2(blunt.x, tapered.y), down);
    let start = mix(to_end, from_start, down) / onset;
    let press = 1.0 + 0.25 * exp(-(start - 1.3) * (start - 1.3));
    let lifted = 1.0 - mix(t.x, t.y, down);
    return vec2(shape.x * shape.y * press, lifted);
}
