//! uses hair/vertex, light/key, light/point, shared/kajiya_kay, surface/place
// Packed interpolants between vertex and fragment shaders of shells. There are three variants, each with no more slots
// than its fur needs. Software rasterisers pay for a slot at every vertex, triangle and block of pixels, and for each
// uniform value at every block. Therefore light times base colour is computed at vertices, and uniforms are passed as
// flat values.

// Values computed per vertex.
struct Shell {
    tile_uv: vec2<f32>,
    // Ambient light that arrives, and diffuse light, both times the base colour.
    ambient: vec3<f32>,
    diffuse: vec3<f32>,
    // Length of the hair relative to the tile's.
    length: f32,
    // Layer in the layer-wise maps.
    map_layer: f32,
    // Slope that the vertex lean adds to hair at this height.
    slope: f32,
    // Index of the baked layer.
    layer: u32,
    // Sideways offset of hair from its root.
    aside: vec3<f32>,
    at: HairVertex,
}

// Variant for fur coloured at vertices.
struct PlainVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Tile coordinates, n_dot_e, length.
    @location(0) uv_cosine_length: vec4<f32>,
    // Directions, then ambient light; w: red, green and blue of the diffuse colour.
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    // Highlight and baked layer, as the bits of three f32 and one u32.
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
}

// Variant with material textures and maps, or with a different number of layers.
struct MappedVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_length: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    // Slope, opacity of the base colour, layer of the maps, `along`.
    @location(7) slope_alpha_map: vec4<f32>,
}

// Variant with the inputs of lights that are evaluated per fragment.
struct FilledVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_length: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    @location(7) slope_alpha_map: vec4<f32>,
    @location(8) position_ws_red: vec4<f32>,
    @location(9) normal_ws_green: vec4<f32>,
    @location(10) tangent: vec4<f32>,
    // Blue of the tint; openness of the body.
    @location(11) blue_open: vec4<f32>,
}

fn plain_varying(s: Shell) -> PlainVarying {
    let specular = bitcast<vec3<u32>>(instance.specular);
    return PlainVarying(
        s.at.position, vec4(s.tile_uv, s.at.n_dot_e, s.length), vec4(s.at.light_ts, s.diffuse.r),
        vec4(s.at.half_ts, s.diffuse.g), vec4(s.ambient, s.diffuse.b), s.at.place, vec4(specular, s.layer),
    );
}

fn mapped_varying(s: Shell) -> MappedVarying {
    let p = plain_varying(s);
    return MappedVarying(
        p.position, p.uv_cosine_length, p.light_red, p.half_green, p.ambient_blue, p.place, p.specular_layer,
        vec4(s.at.base_uv, s.at.groom), vec4(s.slope, s.at.tint.a, s.map_layer, s.aside.z),
    );
}

fn filled_varying(s: Shell) -> FilledVarying {
    let m = mapped_varying(s);
    return FilledVarying(
        m.position, m.uv_cosine_length, m.light_red, m.half_green, m.ambient_blue, m.place, m.specular_layer,
        m.base_uv_groom, m.slope_alpha_map, vec4(s.at.spot.position_ws, s.at.tint.r),
        vec4(s.at.spot.normal_ws, s.at.tint.g), s.at.spot.tangent, vec4(s.at.tint.b, s.at.spot.open),
    );
}

// Inputs of a fragment.
struct ShellFragment {
    tile_uv: vec2<f32>,
    layer: u32,
    n_dot_e: f32,
    length: f32,
    base_uv: vec2<f32>,
    groom: vec2<f32>,
    slope: f32,
    base_alpha: f32,
    place: vec4<f32>,
    map_layer: f32,
    // Additional sideways offset of hair from its root, per unit of its sideways direction.
    along: f32,
    // Tint for lights evaluated per fragment.
    tint: vec3<f32>,
    spot: Spot,
    // Light that arrives, without the visibility of the key light.
    arriving: Arriving,
}

fn plain_fragment(in: PlainVarying) -> ShellFragment {
    let arriving = Arriving(
        in.ambient_blue.rgb, vec3(in.light_red.w, in.half_green.w, in.ambient_blue.w),
        bitcast<vec3<f32>>(in.specular_layer.xyz), in.light_red.xyz, in.half_green.xyz,
        back_attenuation(in.light_red.z, instance.back_light_range), 1.0, 1.0,
    );
    // In this variant, drawn, baked and map layers are equal; other variants override the map layer.
    let layer = in.specular_layer.w;
    return ShellFragment(
        in.uv_cosine_length.xy, layer, in.uv_cosine_length.z, in.uv_cosine_length.w, vec2(0.0), vec2(0.0), 0.0, 1.0, in.place, f32(layer), 0.0,
        vec3(0.0), Spot(), arriving,
    );
}

fn mapped_fragment(in: MappedVarying) -> ShellFragment {
    var out = plain_fragment(PlainVarying(
        in.position, in.uv_cosine_length, in.light_red, in.half_green, in.ambient_blue, in.place, in.specular_layer,
    ));
    out.base_uv = in.base_uv_groom.xy;
    out.groom = in.base_uv_groom.zw;
    out.slope = in.slope_alpha_map.x;
    out.base_alpha = in.slope_alpha_map.y;
    out.map_layer = in.slope_alpha_map.z;
    out.along = in.slope_alpha_map.w;
    return out;
}

fn filled_fragment(in: FilledVarying) -> ShellFragment {
    var out = mapped_fragment(MappedVarying(
        in.position, in.uv_cosine_length, in.light_red, in.half_green, in.ambient_blue, in.place, in.specular_layer,
        in.base_uv_groom, in.slope_alpha_map,
    ));
    out.tint = vec3(in.position_ws_red.w, in.normal_ws_green.w, in.blue_open.x);
    out.spot = Spot(in.position_ws_red.xyz, in.normal_ws_green.xyz, in.tangent, in.blue_open.yzw);
    return out;
}
