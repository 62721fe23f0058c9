//! uses hair/constants, hair/strand, shared/skinning, shared/tile_frame, surface/geometry
// Placement of a part's strand points on the posed mesh, with the surface frame at their roots.

struct Stand {
    a: u32,
    b: u32,
    c: u32,
    // Barycentric weights of the corners b and c: a quarter of the value, snorm.
    weights: u32,
}

@group(0) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
@group(0) @binding(1) var<storage, read> stands: array<Stand>;
@group(0) @binding(2) var<storage, read> strands: array<Strand>;
// Points of the tile's strands. The height and radius of a point are in .y, 16 bits each.
@group(0) @binding(3) var<storage, read> tile: array<vec4<u32>>;
@group(0) @binding(4) var<uniform> constants: StrandConstants;
@group(0) @binding(5) var<storage, read_write> posed: array<vec4<f32>>;
@group(1) @binding(2) var base_color_sampler: sampler;
@group(1) @binding(3) var groom_texture: texture_2d<f32>;

// Same override constants as in hair.wgsl.
override GROOM_VERTICES: bool = false;
override GROOM_TEXTURE: bool = false;
override WET: bool = false;

// Places the strand points of a part, with one thread per point.
@compute @workgroup_size(64)
fn pose_strands(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let points = constants.points;
    let index = constants.first * points + id.y * groups.x * 64u + id.x;
    if index >= constants.end * points {
        return;
    }
    let number = index / points;
    let i = index % points;
    let strand = strands[number];
    let of_tile = strand.of_tile * points + i;
    var at = planted_position(stands[index], height_of_point(of_tile));
    let wetness = strand_groom(strand).y;
    if WET {
        // Wet hair is stored after all dry hair of the tile.
        let height = height_of_point(constants.dry_points + of_tile);
        let wet = planted_position(stands[constants.count * points + index], height);
        at = mix(at, wet, wetness);
    }
    let first = number * (points + POSED_BEFORE);
    posed[first + POSED_BEFORE + i] = at;
    if i == 0u {
        let stand = stands[index];
        let a = vertices[stand.a];
        let w = clamped_weights(stand);
        let mean_normal = a.normal * w.x + vertices[stand.b].normal * w.y + vertices[stand.c].normal * w.z;
        let normal = normalize_or(mean_normal, a.normal);
        let along_u = a.tangent.xyz * w.x + vertices[stand.b].tangent.xyz * w.y + vertices[stand.c].tangent.xyz * w.z;
        posed[first] = vec4(normal, wetness);
        let shown = a.fur_height + vertices[stand.b].fur_height + vertices[stand.c].fur_height > 0.0;
        posed[first + 1u] = vec4(orthonormal_tangent(along_u, normal), select(0.0, a.tangent.w, shown));
    }
}

// Returns the height of a point of the tile, relative to the fur height.
fn height_of_point(index: u32) -> f32 {
    return f32(tile[index].y & 0xffffu) / 65535.0;
}

// Factor from stored to actual weights.
const WEIGHT_SCALE: f32 = 4.0;

// Returns the barycentric weights of a surface point. Outside the triangle, some of them are negative.
fn weights_of(stand: Stand) -> vec3<f32> {
    let weights = WEIGHT_SCALE * unpack2x16snorm(stand.weights);
    return vec3(1.0 - weights.x - weights.y, weights);
}

// Returns the barycentric weights clamped to the triangle. Hair beside the surface takes its orientation from the edge.
fn clamped_weights(stand: Stand) -> vec3<f32> {
    let inside = clamp(weights_of(stand), vec3(0.0), vec3(1.0));
    return inside / (inside.x + inside.y + inside.z);
}

// Returns the model-space position of a point at a relative height in the fur; w holds that height.
fn planted_position(stand: Stand, share: f32) -> vec4<f32> {
    let a = vertices[stand.a];
    let b = vertices[stand.b];
    let c = vertices[stand.c];
    let at = weights_of(stand);
    let w = clamped_weights(stand);
    let place = a.position * at.x + b.position * at.y + c.position * at.z;
    let offset = hair_offset_of(a, share) * w.x + hair_offset_of(b, share) * w.y + hair_offset_of(c, share) * w.z;
    return vec4(place + offset, share);
}

// Returns the offset from the surface to the hair of a vertex, at a relative height (formulas 2.5).
fn hair_offset_of(v: GeometryVertex, share: f32) -> vec3<f32> {
    let tile = tile_frame(normalize_or(v.normal, vec3(0.0, 1.0, 0.0)), v.tangent.xyz, v.tangent.w);
    return (tile.normal_ws * share + tile.bitangent_ws * lean_offset(v.lean, share)) * v.fur_height;
}
