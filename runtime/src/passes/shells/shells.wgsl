// The shells: layers 1.. of the hair volume, inside to outside, one per instance index, each lit per pixel.
//
// What is linear over a triangle is computed per vertex: the directions to the light and H, turned into the tile's frame, where
// the direction texture lives. A fragment then needs no matrix and no frame.

struct ShellVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tile_uv: vec2<f32>,
    @location(1) light_ts: vec3<f32>,
    @location(2) half_ts: vec3<f32>,
    @location(3) tint: vec4<f32>,
    @location(4) base_uv: vec2<f32>,
    @location(5) @interpolate(flat, either) layer: u32,
    @location(6) @interpolate(flat, either) ambient_share: f32,
    // Share of the opacity that is left beside fins.
    @location(7) share: f32,
    @location(8) groom: vec2<f32>,
    // Slope that the lean of the vertex adds to hair at this height.
    @location(9) slope: f32,
    @location(10) place: vec4<f32>,
    // Layer of the layer-wise maps.
    @location(11) @interpolate(flat, either) map_layer: f32,
    @location(12) position_ws: vec3<f32>,
    @location(13) normal_ws: vec3<f32>,
    @location(14) tangent: vec4<f32>,
}

// Height of a drawn layer: 0 on the skin, 1 the outermost.
fn height_of(layer: u32) -> f32 {
    return f32(layer) / f32(instance.drawn_layers - 1u);
}

@vertex
fn vs_shells(v: Vertex, @builtin(instance_index) layer: u32) -> ShellVarying {
    let height = height_of(layer);
    let tile = tile_frame_of(v, normal_ws(v));
    let position = hair_position(v, tile, height);
    let light = direction_to(frame.light_ws, position);
    let eye = direction_to(frame.eye_ws, position);
    let half = half_vector(light, eye);
    var out: ShellVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.tile_uv = v.tile_uv;
    out.light_ts = to_tile(tile, light);
    out.half_ts = to_tile(tile, half);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.layer = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    out.share = shell_share(dot(tile.normal_ws, eye));
    out.ambient_share = ambient_attenuation(height, instance.ambient_floor);
    out.groom = v.groom.xy;
    out.slope = lean_slope(v.lean, height);
    out.place = map_place(position);
    out.map_layer = height * frame.last_map_layer;
    let spot = spot_of(v, position, tile);
    out.position_ws = spot.position_ws;
    out.normal_ws = spot.normal_ws;
    out.tangent = spot.tangent;
    return out;
}

// Premultiplied colour and opacity.
@fragment
fn fs_shells(in: ShellVarying) -> @location(0) vec4<f32> {
    let groom = groom_at(in.groom, in.base_uv);
    let hair = hair_at(in.tile_uv, in.layer, groom.y);
    var texel = hair.color;
    var direction = hair.direction;
    let base = base_color(in.tint, in.base_uv);
    if BESIDE_FINS {
        // Fins are of dry hair: where it is wet there are none to leave room for.
        texel *= select(in.share, mix(in.share, 1.0, groom.y), WET);
    }
    if texel.a * groom.x < LEAST_ALPHA || is_cut(base.a) {
        discard;
    }
    if LEAN {
        direction = leaned_direction(direction, in.slope);
    }
    if RESAMPLED {
        // Colour is premultiplied: it follows its opacity.
        texel *= resampled_opacity(texel.a, instance.opacity_exponent) / texel.a;
    }
    texel *= groom.x;
    var reach = light_through_hair(in.place, in.map_layer, MAPS_BETWEEN) * light_past_things(in.place, in.light_ts.z);
    if SELF_SHADOW && SLANTED {
        // The layer is as thick as the hair between it and the next: on average half of it is above its hair.
        reach *= layer_transmittance(hair.color.a * groom.x, 0.5 * slanted_path(in.light_ts.z));
    }
    let tint = texel.rgb * base.rgb;
    var color = shade_hair(tint, texel.a, direction, in.light_ts, in.half_ts, in.ambient_share, groom.y, reach);
    color += fill_hair(tint, texel.a, direction, Spot(in.position_ws, in.normal_ws, in.tangent), groom.y);
    return vec4(color, texel.a);
}

// The yardstick that shells are measured by: the same layers and fragments with one texture read and no lighting.
struct YardstickVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tile_uv: vec2<f32>,
    @location(1) @interpolate(flat, either) layer: u32,
}

@vertex
fn vs_yardstick(v: Vertex, @builtin(instance_index) layer: u32) -> YardstickVarying {
    let position = hair_position(v, tile_frame_of(v, normal_ws(v)), height_of(layer));
    let baked = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    return YardstickVarying(frame.clip_from_world * vec4(position, 1.0), v.tile_uv, baked);
}

@fragment
fn fs_yardstick(in: YardstickVarying) -> @location(0) vec4<f32> {
    return textureSample(shell_colors, shell_sampler, in.tile_uv, in.layer);
}
