// The fins: a quad on every edge of the skin, shown where it is seen face on, which is along the outline (Lengyel 2001).
// Fins that are faded out collapse into a point and have no fragments.

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

@vertex
fn vs_fins(@builtin(vertex_index) index: u32) -> FinVarying {
    let corner = fin_corner(index);
    let opacity = corner.opacity * instance.fin_share;
    let v = corner.vertex;
    let height = corner.height;
    let tile = corner.tile;
    let position = hair_position(v, tile, height);
    let light = direction_to(frame.light_ws, position);
    let half = half_vector(light, direction_to(frame.eye_ws, position));
    var out: FinVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    if opacity < LEAST_ALPHA {
        out.position = vec4(0.0, 0.0, 0.0, 1.0);
    }
    out.slab_uv = vec2(corner.along, height);
    out.light_ts = to_tile(tile, light);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.slab = corner.slab;
    out.opacity = opacity;
    out.groom = v.groom.xy;
    out.slope = lean_slope(v.lean, height);
    out.half_ts = half_or_factors(corner.slab, out.slope, out.light_ts, to_tile(tile, half), 0.0);
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
