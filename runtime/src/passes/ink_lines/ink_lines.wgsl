//! uses contours/block
// Contour lines as ribbons: one strip per segment, a cubic curve between two nodes.

@group(0) @binding(0) var<uniform> contours: Contours;
@group(0) @binding(1) var<storage, read> line_nodes: array<LineNode>;
@group(0) @binding(2) var paper: texture_2d<f32>;
@group(0) @binding(3) var paper_sampler: sampler;

struct LineVarying {
    @builtin(position) position: vec4<f32>,
    // Offset across the line in half widths; half width, pixels; density; dryness.
    @location(0) brush: vec4<f32>,
    // Stored position as a share of the model's diagonal; share of the lift at the end of the stroke.
    @location(1) rest_lift: vec4<f32>,
}

// Parts of a segment.
const PARTS: f32 = 4.0;
// Width of the ribbon over that of the line: rough edges extend beyond it.
const BEYOND: f32 = 1.3;

@vertex
fn vs_line(@builtin(vertex_index) vertex: u32, @builtin(instance_index) number: u32) -> LineVarying {
    var out: LineVarying;
    out.position = vec4(2.0, 2.0, 0.0, 1.0);
    let a = line_nodes[number];
    if a.next == NO_NODE {
        return out;
    }
    let b = line_nodes[a.next];
    if max(min(a.ends.x, a.ends.y), min(b.ends.x, b.ends.y)) <= 0.0 {
        return out;
    }
    let t = f32(vertex / 2u) / PARTS;
    let side = select(-BEYOND, BEYOND, (vertex & 1u) == 1u);
    // Cubic Hermite curve.
    let long = distance(a.px, b.px);
    let t2 = t * t;
    let t3 = t2 * t;
    let px = a.px * (2.0 * t3 - 3.0 * t2 + 1.0) + b.px * (3.0 * t2 - 2.0 * t3)
        + long * (a.tangent * (t3 - 2.0 * t2 + t) + b.tangent * (t3 - t2));
    let way = (b.px - a.px) * (6.0 * t - 6.0 * t2)
        + long * (a.tangent * (3.0 * t2 - 4.0 * t + 1.0) + b.tangent * (3.0 * t2 - 2.0 * t));
    let tangent = way * inverseSqrt(max(dot(way, way), 1e-12));
    let ends = mix(a.ends, b.ends, t);
    let brush = mix(a.brush, b.brush, t);
    let pressure = line_pressure(contours.diagonal, ends.x, ends.y, tangent.y);
    let half = brush.x * pressure.x;
    // A thin line is pale instead of thinner than a pixel.
    let drawn = max(half, 0.5);
    let place = px + vec2(-tangent.y, tangent.x) * (side * drawn + sign(side));
    let ndc = (place / contours.size - 0.5) * vec2(2.0, -2.0);
    out.position = vec4(ndc, 0.5, 1.0);
    out.brush = vec4((side * drawn + sign(side)) / drawn, drawn, brush.y * min(half / 0.5, 1.0), brush.z);
    out.rest_lift = vec4(mix(a.rest, b.rest, t), pressure.y);
    return out;
}

// Densities of wet and of dry lines.
@fragment
fn fs_line(in: LineVarying) -> @location(0) vec4<f32> {
    let unit = contours.unit;
    let relief = textureSampleLevel(paper, paper_sampler, in.position.xy / contours.paper_period, 0.0).a;
    let v = in.brush.x;
    let half = in.brush.y;
    let width = half / unit;
    let rest = in.rest_lift.xyz;
    let rough = 0.26;
    let uneven = space_noise(110.0 * rest + vec3(1.5 * v), 5u) - 0.5;
    let edge = abs(v) * (1.0 + rough * uneven + 0.6 * rough * (relief - 0.5));
    let soft = min(0.75 / half, 1.0);
    let coverage = 1.0 - smoothstep(1.0 - soft, 1.0 + 0.4 * soft + 0.02, edge);
    // Bristles leave streaks along the line, in lanes across it.
    let lane = v * width / 0.8;
    let bristle = 0.6 * space_noise(14.0 * rest + vec3(lane, 0.7 * lane, 50.0), 6u)
        + 0.4 * space_noise(32.0 * rest + vec3(2.2 * lane, 90.0, 1.5 * lane), 7u);
    let threshold = in.brush.w * 0.85 - 0.1 + 0.35 * in.rest_lift.w * in.rest_lift.w;
    let grain = smoothstep(0.12, 0.88, 0.68 * bristle + 0.32 * relief);
    let touching = smoothstep(threshold - 0.1, threshold + 0.14, grain);
    let k = (1.0 - edge) * width / 1.5;
    let rim = 1.0 + 0.15 * exp(-k * k);
    let density = in.brush.z * coverage * touching * (0.86 + 0.28 * bristle) * rim;
    let dry = smoothstep(0.15, 0.45, in.brush.w);
    return vec4(density * (1.0 - dry), density * dry, 0.0, 0.0);
}
