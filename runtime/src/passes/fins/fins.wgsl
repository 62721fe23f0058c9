// The fins: a quad on every edge of the skin, shown where it is seen face on, which is along the outline (Lengyel 2001).
//
// There is no vertex buffer: a fin needs both ends of its edge at every corner, and reads them from the posed vertices. Fins that are
// faded out collapse into a point and have no fragments.

struct GeometryVertex {
    position: vec3<f32>,
    fur_height: f32,
    normal: vec3<f32>,
    lean: f32,
    tangent: vec4<f32>,
}

// Its colour is packed.
struct AttributeVertex {
    tile_uv: vec2<f32>,
    base_uv: vec2<f32>,
    color: u32,
    groom: u32,
}

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

struct FinVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Along the slab, and height: 0 on the skin, 1 at the outermost layer.
    @location(0) slab_uv: vec2<f32>,
    @location(1) light_ts: vec3<f32>,
    @location(2) half_ts: vec3<f32>,
    @location(3) tint: vec4<f32>,
    @location(4) base_uv: vec2<f32>,
    @location(5) @interpolate(flat, either) slab: u32,
    @location(6) @interpolate(flat, either) opacity: f32,
    @location(7) groom: vec2<f32>,
    // Slope that the lean of the vertex adds to hair at this height.
    @location(8) slope: f32,
    @location(9) place: vec4<f32>,
    @location(10) position_ws: vec3<f32>,
    @location(11) normal_ws: vec3<f32>,
    @location(12) tangent: vec4<f32>,
}

// Vertices of a quad: two triangles.
const CORNERS: u32 = 6u;
// Quads above each other where hair leans, which bends it.
const LEANING_ROWS: u32 = 3u;

fn vertex_of(index: u32) -> Vertex {
    let g = vertices[index];
    let a = attributes[index];
    let color = unpack4x8unorm(a.color);
    return Vertex(
        g.position, g.fur_height, g.normal, g.tangent, a.tile_uv, a.base_uv, color, g.lean, unpack4x8unorm(a.groom),
    );
}

@vertex
fn vs_fins(@builtin(vertex_index) index: u32) -> FinVarying {
    let rows = select(1u, LEANING_ROWS, LEAN);
    let quad = index / CORNERS;
    let corner = index % CORNERS;
    let fin = fins[quad / rows];
    // a, b, b above, a, b above, a above.
    let at_b = corner == 1u || corner == 2u || corner == 4u;
    let above = corner == 2u || corner > 3u;

    let a = vertex_of(fin.a);
    let b = vertex_of(fin.b);
    let normal_a = normal_ws(a);
    let normal_b = normal_ws(b);
    let skin_a = position_ws(a);
    let skin_b = position_ws(b);
    // The fin's own plane: by the edge and the mean of the normals, the same at all corners.
    let face = normalize_or(cross(skin_b - skin_a, normal_a + normal_b), vec3(0.0));
    let eye = direction_to(frame.eye_ws, 0.5 * (skin_a + skin_b));
    let opacity = fin.opacity * fin_opacity(dot(face, eye)) * instance.fin_share;

    var v = a;
    var normal = normal_a;
    if at_b {
        v = b;
        normal = normal_b;
    }
    let height = f32(quad % rows + select(0u, 1u, above)) / f32(rows);
    let tile = tile_frame_of(v, normal);
    let position = hair_position(v, tile, height);
    let light = direction_to(frame.light_ws, position);
    let half = half_vector(light, direction_to(frame.eye_ws, position));
    var out: FinVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    if opacity < LEAST_ALPHA {
        out.position = vec4(0.0, 0.0, 0.0, 1.0);
    }
    out.slab_uv = vec2(fin.start + select(0.0, fin.length, at_b), height);
    out.light_ts = to_tile(tile, light);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.slab = fin.slab;
    out.opacity = opacity;
    out.groom = v.groom.xy;
    out.slope = lean_slope(v.lean, height);
    out.half_ts = half_or_factors(fin.slab, out.slope, out.light_ts, to_tile(tile, half), 0.0);
    out.place = map_place(position);
    let spot = spot_of(v, position, tile);
    out.position_ws = spot.position_ws;
    out.normal_ws = spot.normal_ws;
    out.tangent = spot.tangent;
    return out;
}

// Premultiplied colour and opacity.
@fragment
fn fs_fins(in: FinVarying) -> @location(0) vec4<f32> {
    let groom = groom_at(in.groom, in.base_uv);
    var texel = textureSample(shell_colors, shell_sampler, in.slab_uv, in.slab);
    var direction = decode_direction(textureSample(shell_directions, shell_sampler, in.slab_uv, in.slab), PLANAR_DIRECTIONS);
    let base = base_color(in.tint, in.base_uv);
    // Hair that grows, and that does not lie in the wet locks of which there are no fins.
    texel *= in.opacity * groom.x * select(1.0, 1.0 - groom.y, WET);
    if texel.a < LEAST_ALPHA || is_cut(base.a) {
        discard;
    }
    if LEAN {
        direction = leaned_direction(direction, in.slope);
    }
    let ambient_share = ambient_attenuation(in.slab_uv.y, instance.ambient_floor);
    let height = clamp(in.slab_uv.y, 0.0, 1.0);
    let reach = light_through_hair(in.place, height * frame.last_map_layer, true)
        * light_past_things(in.place, in.light_ts.z);
    let tint = texel.rgb * base.rgb;
    var color = shade_hair(tint, texel.a, direction, in.light_ts, in.half_ts, ambient_share, 0.0, reach);
    color += fill_hair(tint, texel.a, direction, Spot(in.position_ws, in.normal_ws, in.tangent), 0.0);
    return vec4(color, texel.a);
}
