// The shells: layers 1.. of the hair volume, inside to outside, one per instance index, each lit per pixel.
//
// What is linear over a triangle is computed per vertex: the directions to the light and H, turned into the tile's frame, where
// the direction texture lives, and the light times the base colour. A fragment then needs no matrix, no frame and few uniforms.

// What is computed per vertex.
struct Shell {
    position: vec4<f32>,
    tile_uv: vec2<f32>,
    light_ts: vec3<f32>,
    // As half_or_factors says.
    half_ts: vec3<f32>,
    // Base colour without its texture; and it times what arrives of the ambient light, and times the diffuse light.
    tint: vec4<f32>,
    ambient: vec3<f32>,
    diffuse: vec3<f32>,
    // Attenu_Back before its clamp.
    back: f32,
    // Cosine between the skin's normal and the direction to the eye.
    n_dot_e: f32,
    // Place in the shadow maps.
    place: vec4<f32>,
    // Layer of the layer-wise maps.
    map_layer: f32,
    base_uv: vec2<f32>,
    groom: vec2<f32>,
    // Slope that the lean of the vertex adds to hair at this height.
    slope: f32,
    // Among the baked layers.
    layer: u32,
    spot: Spot,
}

// Vertex and fragment meet in three forms, each with no more slots than its coats need: a software rasteriser pays for a slot at
// every vertex, triangle and block of pixels, and for each uniform value at every block.

// Coats coloured at vertices.
struct PlainVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Tile coordinates, n_dot_e, back.
    @location(0) uv_cosine_back: vec4<f32>,
    // Directions with the diffuse colour.
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    // Highlight; baked layer. The bits of three numbers f32 and one u32.
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
}

// With all that textures and maps of the material, or another number of layers, need besides.
struct MappedVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_back: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    // Slope, opacity of the base colour, layer of the maps.
    @location(7) slope_alpha_map: vec3<f32>,
}

// With what lights need that are not known per vertex.
struct FilledVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_back: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    @location(7) slope_alpha_map: vec3<f32>,
    @location(8) position_ws_red: vec4<f32>,
    @location(9) normal_ws_green: vec4<f32>,
    @location(10) tangent: vec4<f32>,
    @location(11) blue: f32,
}

fn shell_of(v: Vertex, index: u32) -> Shell {
    let layer = drawn_layer(index);
    let height = height_of(layer);
    let tile = tile_frame_of(v, normal_ws(v));
    let position = hair_position(v, tile, height);
    let light = direction_to(frame.light_ws, position);
    let eye = direction_to(frame.eye_ws, position);
    let half = half_vector(light, eye);
    var out: Shell;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.tile_uv = v.tile_uv;
    out.light_ts = to_tile(tile, light);
    out.tint = v.color * material.base_color;
    var hair_height = height;
    if DETAIL {
        hair_height = seen_height(height, stands_for(layer), instance.drawn_layers);
    }
    out.ambient = out.tint.rgb * instance.ambient * ambient_attenuation(hair_height, instance.ambient_floor);
    out.diffuse = out.tint.rgb * instance.diffuse;
    out.back = back_slope(out.light_ts.z, instance.back_light_range);
    out.n_dot_e = dot(tile.normal_ws, eye);
    out.place = map_place(position);
    out.map_layer = hair_height * frame.last_map_layer;
    out.base_uv = v.base_uv;
    out.groom = v.groom.xy;
    out.slope = lean_slope(v.lean, height);
    out.layer = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    out.half_ts = half_or_factors(out.layer, out.slope, out.light_ts, to_tile(tile, half), v.groom.y);
    out.spot = spot_of(v, position, tile);
    return out;
}

fn plain_varying(s: Shell) -> PlainVarying {
    let specular = bitcast<vec3<u32>>(instance.specular);
    return PlainVarying(
        s.position, vec4(s.tile_uv, s.n_dot_e, s.back), vec4(s.light_ts, s.diffuse.r), vec4(s.half_ts, s.diffuse.g),
        vec4(s.ambient, s.diffuse.b), s.place, vec4(specular, s.layer),
    );
}

@vertex
fn vs_shells(v: Vertex, @builtin(instance_index) index: u32) -> PlainVarying {
    return plain_varying(shell_of(v, index));
}

@vertex
fn vs_shells_mapped(v: Vertex, @builtin(instance_index) index: u32) -> MappedVarying {
    let s = shell_of(v, index);
    let p = plain_varying(s);
    return MappedVarying(
        p.position, p.uv_cosine_back, p.light_red, p.half_green, p.ambient_blue, p.place, p.specular_layer,
        vec4(s.base_uv, s.groom), vec3(s.slope, s.tint.a, s.map_layer),
    );
}

@vertex
fn vs_shells_filled(v: Vertex, @builtin(instance_index) index: u32) -> FilledVarying {
    let s = shell_of(v, index);
    let p = plain_varying(s);
    return FilledVarying(
        p.position, p.uv_cosine_back, p.light_red, p.half_green, p.ambient_blue, p.place, p.specular_layer,
        vec4(s.base_uv, s.groom), vec3(s.slope, s.tint.a, s.map_layer),
        vec4(s.spot.position_ws, s.tint.r), vec4(s.spot.normal_ws, s.tint.g), s.spot.tangent, s.tint.b,
    );
}

// Premultiplied colour and opacity. base_uv_groom, slope_alpha_map: as in MappedVarying; tint and spot: for the fill lights.
fn shade_shell(
    in: PlainVarying,
    base_uv_groom: vec4<f32>,
    slope_alpha_map: vec3<f32>,
    tint: vec3<f32>,
    spot: Spot,
) -> vec4<f32> {
    let base_uv = base_uv_groom.xy;
    let groom = groom_at(base_uv_groom.zw, base_uv);
    let hair = hair_at(in.uv_cosine_back.xy, in.specular_layer.w, groom.y);
    var texel = hair.color;
    var direction = hair.direction;
    let base = base_color(vec4(1.0, 1.0, 1.0, slope_alpha_map.y), base_uv);
    if texel.a * groom.x < LEAST_ALPHA || is_cut(base.a) {
        discard;
    }
    if LEAN {
        direction = leaned_direction(direction, slope_alpha_map.x);
    }
    if RESAMPLED || DETAIL || VIEW_SLANTED {
        var times = 1.0;
        if RESAMPLED || DETAIL {
            times = stands_for(in.specular_layer.w);
        }
        if VIEW_SLANTED {
            times *= view_path(in.uv_cosine_back.z);
        }
        // Colour is premultiplied: it follows its opacity.
        texel *= resampled_opacity(texel.a, times) / texel.a;
    }
    texel *= groom.x;
    let light = in.light_red.xyz;
    var reach = light_through_hair(in.place, slope_alpha_map.z, MAPS_BETWEEN) * light_past_things(in.place, light.z);
    if SELF_SHADOW && SLANTED {
        // The layer is as thick as the hair between it and the next: on average half of it is above its hair.
        reach *= layer_transmittance(hair.color.a * groom.x, 0.5 * frame.hair_density * slanted_path(light.z));
    }
    let color = texel.rgb * base.rgb;
    // Yang 2006, eq. (3), with all that does not vary within a triangle or only linearly from the vertices.
    let factors = key_factors(direction, light, in.half_green.xyz, groom.y) * (clamp(in.uv_cosine_back.w, 0.0, 1.0) * reach);
    let diffuse = vec3(in.light_red.w, in.half_green.w, in.ambient_blue.w);
    var lit = color * (in.ambient_blue.rgb + diffuse * factors.x);
    if SPECULAR {
        lit += bitcast<vec3<f32>>(in.specular_layer.xyz) * (factors.y * texel.a);
    }
    lit += fill_hair(color * tint, texel.a, direction, spot, groom.y);
    return vec4(lit, texel.a);
}

@fragment
fn fs_shells(in: PlainVarying) -> @location(0) vec4<f32> {
    // Drawn, baked and map layers are the same, or of them.
    let map_layer = f32(in.specular_layer.w);
    return shade_shell(in, vec4(0.0), vec3(0.0, 1.0, map_layer), vec3(0.0), Spot());
}

@fragment
fn fs_shells_mapped(in: MappedVarying) -> @location(0) vec4<f32> {
    let plain = PlainVarying(
        in.position, in.uv_cosine_back, in.light_red, in.half_green, in.ambient_blue, in.place, in.specular_layer,
    );
    return shade_shell(plain, in.base_uv_groom, in.slope_alpha_map, vec3(0.0), Spot());
}

@fragment
fn fs_shells_filled(in: FilledVarying) -> @location(0) vec4<f32> {
    let plain = PlainVarying(
        in.position, in.uv_cosine_back, in.light_red, in.half_green, in.ambient_blue, in.place, in.specular_layer,
    );
    let tint = vec3(in.position_ws_red.w, in.normal_ws_green.w, in.blue);
    let spot = Spot(in.position_ws_red.xyz, in.normal_ws_green.xyz, in.tangent);
    return shade_shell(plain, in.base_uv_groom, in.slope_alpha_map, tint, spot);
}

// The yardstick that shells are measured by: the same layers and fragments with one texture read and no lighting.
struct YardstickVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tile_uv: vec2<f32>,
    @location(1) @interpolate(flat, either) layer: u32,
}

@vertex
fn vs_yardstick(v: Vertex, @builtin(instance_index) index: u32) -> YardstickVarying {
    let layer = drawn_layer(index);
    let position = hair_position(v, tile_frame_of(v, normal_ws(v)), height_of(layer));
    let baked = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    return YardstickVarying(frame.clip_from_world * vec4(position, 1.0), v.tile_uv, baked);
}

@fragment
fn fs_yardstick(in: YardstickVarying) -> @location(0) vec4<f32> {
    return textureSample(shell_colors, shell_sampler, in.tile_uv, in.layer);
}
