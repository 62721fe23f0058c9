//! uses hair/constants, hair/triangle_frame, shared/skinning, shared/tile_frame, surface/geometry
// Pose of guided hair: rotates the guides with the triangles at their roots, then places the points of a part's hairs.
// Counterpart of `pelage_formats::meaning::hair_groups`.

// Size: 48 bytes.
struct HairRoot {
    a: u32,
    b: u32,
    c: u32,
    // Barycentric weights of the corners b and c, unorm.
    weights: u32,
    // Guide indices, 16 bits each.
    guides_01: u32,
    guides_23: u32,
    // Weights of the guides, unorm.
    shares: u32,
    // Length relative to that of the guides, above 0 and at most 1.
    length: f32,
    // Offset of the tip in the frame of the hair's triangle.
    aside: vec3<f32>,
    reserved: u32,
}

@group(0) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
// Triangle corners of each guide.
@group(0) @binding(1) var<storage, read> triangles: array<vec4<u32>>;
// Points of each guide, in the frame of its triangle.
@group(0) @binding(2) var<storage, read> guides: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> posed_guides: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> hairs: array<HairRoot>;
@group(0) @binding(5) var<storage, read_write> posed: array<vec4<f32>>;
@group(0) @binding(6) var<uniform> constants: StrandConstants;

// Poses the guides, with one thread per guide point.
@compute @workgroup_size(64)
fn pose_guides(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&guides) {
        return;
    }
    let t = triangles[index / constants.points];
    let frame = triangle_frame(vertices[t.x].position, vertices[t.y].position, vertices[t.z].position);
    posed_guides[index] = vec4(frame * guides[index].xyz, 0.0);
}

// Returns a position between two points of a guide, relative to the guide's root.
fn guide_at(guide: u32, low: u32, high: u32, share: f32) -> vec3<f32> {
    let first = guide * constants.points;
    return mix(posed_guides[first + low].xyz, posed_guides[first + high].xyz, share);
}

// Places the points of the hairs, with one thread per point.
@compute @workgroup_size(64)
fn pose_hairs(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let points = constants.points;
    let index = constants.first * points + id.y * groups.x * 64u + id.x;
    if index >= constants.end * points {
        return;
    }
    let number = index / points;
    let k = index % points;
    let hair = hairs[number];
    let a = vertices[hair.a];
    let b = vertices[hair.b];
    let c = vertices[hair.c];
    let w = unpack2x16unorm(hair.weights);
    let at = vec3(1.0 - w.x - w.y, w);

    let share = f32(k) / f32(points - 1u);
    let along = hair.length * f32(k);
    let low = min(u32(along), points - 1u);
    let high = min(low + 1u, points - 1u);
    let between = along - f32(low);
    let shares = unpack4x8unorm(hair.shares);
    let followed = guide_at(hair.guides_01 & 0xffffu, low, high, between) * shares.x
        + guide_at(hair.guides_01 >> 16u, low, high, between) * shares.y
        + guide_at(hair.guides_23 & 0xffffu, low, high, between) * shares.z
        + guide_at(hair.guides_23 >> 16u, low, high, between) * shares.w;
    // Weights stored as bytes do not always add up to 1.
    let sum = max(dot(shares, vec4(1.0)), 1.0 / 255.0);
    let frame = triangle_frame(a.position, b.position, c.position);
    let shown = any(frame[0] != vec3(0.0));
    let aside = frame * hair.aside;
    let root = a.position * at.x + b.position * at.y + c.position * at.z;

    let first = number * (points + POSED_BEFORE);
    let offset = select(vec3(0.0), followed / sum, shown);
    posed[first + POSED_BEFORE + k] = vec4(root + offset + aside * (share * share), share);
    if k == 0u {
        let normal = normalize_or(a.normal * at.x + b.normal * at.y + c.normal * at.z, vec3(0.0, 1.0, 0.0));
        posed[first] = vec4(normal, 0.0);
        posed[first + 1u] = vec4(orthonormal_tangent(a.tangent.xyz, normal), select(0.0, 1.0, shown));
    }
}
