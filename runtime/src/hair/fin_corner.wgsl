//! uses shared/fins, shared/frame, shared/skinning, shared/tile_frame, surface/geometry, surface/place
// Corners of fins. Fins have no vertex buffer: each corner needs both ends of its edge, so the shader reads them from
// the posed vertices.

// The colour is packed into 32 bits.
struct AttributeVertex {
    tile_uv: vec2<f32>,
    base_uv: vec2<f32>,
    color: u32,
    groom: u32,
}

// Fin on the mesh edge from vertex `a` to vertex `b`. `start` and `length`: its range in the fin texture.
struct Fin {
    a: u32,
    b: u32,
    start: f32,
    length: f32,
    slab: u32,
    opacity: f32,
}

@group(3) @binding(0) var<storage, read> vertices: array<GeometryVertex>;
@group(3) @binding(1) var<storage, read> attributes: array<AttributeVertex>;
@group(3) @binding(2) var<storage, read> fins: array<Fin>;

// Vertices of a quad: two triangles.
const CORNERS: u32 = 6u;
// Number of quads stacked on each leaning fin, so that it can bend.
const LEANING_ROWS: u32 = 3u;

// Returns a vertex from the storage buffers, in the form that vertex buffers give it.
fn vertex_of(index: u32) -> Vertex {
    let g = vertices[index];
    let a = attributes[index];
    var v: Vertex;
    v.position = g.position;
    v.fur_height = g.fur_height;
    v.normal = g.normal;
    v.tangent = g.tangent;
    v.tile_uv = a.tile_uv;
    v.base_uv = a.base_uv;
    v.color = unpack4x8unorm(a.color);
    v.lean = g.lean;
    v.groom = unpack4x8unorm(a.groom);
    return v;
}

// A corner of a fin.
struct FinCorner {
    // Base vertex, with its normal and tile frame.
    vertex: Vertex,
    tile: TileFrame,
    // Height: 0 on the skin, 1 at the outermost layer.
    height: f32,
    // Horizontal texture coordinate in the array layer `slab` of the fin texture.
    along: f32,
    // Position along the edge: 0 at its first end, 1 at its second.
    across: f32,
    slab: u32,
    // Opacity of the whole fin. Depends on the view angle, and is lower where fins are dense (formulas 4.6).
    opacity: f32,
    // 1 minus the smaller |N·E| at the two ends of the fin: 0 if the surface faces the eye, 1 at the silhouette.
    turned: f32,
}

// Returns a corner of a fin from its index in the draw call, CORNERS for each quad.
fn fin_corner(index: u32) -> FinCorner {
    let rows = select(1u, LEANING_ROWS, LEAN);
    let quad = index / CORNERS;
    let corner = index % CORNERS;
    let fin = fins[quad / rows];
    // Order of the corners, with the ends a and b of the edge: a, b, above b, a, above b, above a.
    let at_b = corner == 1u || corner == 2u || corner == 4u;
    let above = corner == 2u || corner > 3u;

    let a = vertex_of(fin.a);
    let b = vertex_of(fin.b);
    let normal_a = normal_ws(a);
    let normal_b = normal_ws(b);
    let skin_a = position_ws(a);
    let skin_b = position_ws(b);
    // Normal of the fin's plane, from the edge and the mean normal; the same at all corners.
    let face = normalize_or(cross(skin_b - skin_a, normal_a + normal_b), vec3(0.0));
    let eye = direction_to(frame.eye_ws, 0.5 * (skin_a + skin_b));

    var v = a;
    var normal = normal_a;
    if at_b {
        v = b;
        normal = normal_b;
    }
    var out: FinCorner;
    out.vertex = v;
    out.tile = tile_frame_of(v, normal);
    out.height = f32(quad % rows + select(0u, 1u, above)) / f32(rows);
    out.along = fin.start + select(0.0, fin.length, at_b);
    out.across = select(0.0, 1.0, at_b);
    out.slab = fin.slab;
    out.opacity = fin.opacity * fin_opacity(dot(face, eye));
    out.turned = 1.0 - min(abs(dot(normal_a, eye)), abs(dot(normal_b, eye)));
    return out;
}
