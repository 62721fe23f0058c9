//! uses hair/vertex, light/baked, light/environment, light/fills, light/key, light/point, light/tones,
//! shared/kajiya_kay, surface/place
// Packed interpolants between the vertex and fragment shaders of shells. There are four variants, each with no more
// slots than its fur needs. Software rasterisers pay for a slot at every vertex, triangle and block of pixels, and for
// each uniform value at every block. Therefore, light times base colour is computed per vertex, and uniforms are passed
// as flat values.

// Values computed per vertex.
struct Shell {
    tile_uv: vec2<f32>,
    // Arriving ambient light times the base colour.
    ambient: vec3<f32>,
    // Diffuse light times the base colour.
    diffuse: vec3<f32>,
    // Length of the hair relative to the tile's.
    length: f32,
    // Layer of the shell in the layer-wise maps.
    map_layer: f32,
    // Slope that the vertex lean adds to the hair at this height.
    slope: f32,
    // Index of the baked layer.
    layer: u32,
    // Number of baked layers that the shell represents.
    stands_for: f32,
    // Sideways offset of hair from its root.
    aside: vec3<f32>,
    at: HairVertex,
}

// Variant for fur whose colour comes from vertices only.
struct PlainVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // Tile coordinates, n_dot_e, hair length.
    @location(0) uv_cosine_length: vec4<f32>,
    // Three vectors: direction to the light, half vector, ambient light. Their w components hold red, green and blue of
    // the diffuse colour.
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    // Highlight, as bits of three f32, and packed_layer.
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
}

// Variant for material textures and maps, or for a layer count that differs from the baked one.
struct MappedVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_length: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    @location(2) half_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    // Slope, opacity of the base colour, layer in the maps, `along`.
    @location(7) slope_alpha_map: vec4<f32>,
}

// Variant with the inputs for lights that are evaluated per fragment.
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

// Variant for scattering by fibres under an environment: vertices evaluate the light.
struct SkyVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) uv_cosine_length: vec4<f32>,
    @location(1) light_red: vec4<f32>,
    // Direction to the eye in place of the half vector.
    @location(2) eye_green: vec4<f32>,
    @location(3) ambient_blue: vec4<f32>,
    @location(4) place: vec4<f32>,
    @location(5) @interpolate(flat, either) specular_layer: vec4<u32>,
    @location(6) base_uv_groom: vec4<f32>,
    @location(7) slope_alpha_map: vec4<f32>,
    // Members of Toned: sky_once for each tone; in the w components `open` and the first two of key_often.
    @location(8) dark_open: vec4<f32>,
    @location(9) middle_key: vec4<f32>,
    @location(10) bright_key: vec4<f32>,
    // sky_often for each tone, and key_once; in the w components the last of key_often, and `around` of sky_varying.
    @location(11) often_dark_key: vec4<f32>,
    @location(12) often_middle_around: vec4<f32>,
    @location(13) often_bright_around: vec4<f32>,
    @location(14) key_once_around: vec4<f32>,
}

// Bits of packed_layer that hold the index of the layer.
const LAYER_BITS: u32 = 1023u;

// Packs the index of a baked layer and the number of layers that the shell represents. The number loses its lowest
// bits; its error is below 0.0002. Computing it again at each fragment would take seven divisions of integers.
fn packed_layer(layer: u32, stands_for: f32) -> u32 {
    return (bitcast<u32>(stands_for) & ~LAYER_BITS) | layer;
}

// Packs the interpolants for fur whose colour comes from vertices only.
fn plain_varying(s: Shell) -> PlainVarying {
    var out: PlainVarying;
    out.position = s.at.position;
    out.uv_cosine_length = vec4(s.tile_uv, s.at.n_dot_e, s.length);
    out.light_red = vec4(s.at.light_ts, s.diffuse.r);
    out.half_green = vec4(s.at.half_ts, s.diffuse.g);
    out.ambient_blue = vec4(s.ambient, s.diffuse.b);
    out.place = s.at.place;
    out.specular_layer = vec4(bitcast<vec3<u32>>(instance.specular), packed_layer(s.layer, s.stands_for));
    return out;
}

// Packs the interpolants for material textures and maps.
fn mapped_varying(s: Shell) -> MappedVarying {
    let p = plain_varying(s);
    var out: MappedVarying;
    out.position = p.position;
    out.uv_cosine_length = p.uv_cosine_length;
    out.light_red = p.light_red;
    out.half_green = p.half_green;
    out.ambient_blue = p.ambient_blue;
    out.place = p.place;
    out.specular_layer = p.specular_layer;
    out.base_uv_groom = vec4(s.at.base_uv, s.at.groom);
    out.slope_alpha_map = vec4(s.slope, s.at.tint.a, s.map_layer, s.aside.z);
    return out;
}

// Packs the interpolants for lights that are evaluated per fragment.
fn filled_varying(s: Shell) -> FilledVarying {
    let m = mapped_varying(s);
    var out: FilledVarying;
    out.position = m.position;
    out.uv_cosine_length = m.uv_cosine_length;
    out.light_red = m.light_red;
    out.half_green = m.half_green;
    out.ambient_blue = m.ambient_blue;
    out.place = m.place;
    out.specular_layer = m.specular_layer;
    out.base_uv_groom = m.base_uv_groom;
    out.slope_alpha_map = m.slope_alpha_map;
    out.position_ws_red = vec4(s.at.spot.position_ws, s.at.tint.r);
    out.normal_ws_green = vec4(s.at.spot.normal_ws, s.at.tint.g);
    out.tangent = s.at.spot.tangent;
    out.blue_open = vec4(s.at.tint.b, s.at.spot.open);
    return out;
}

// Packs the interpolants for scattering by fibres under an environment. `direction`, `b`: mean direction and visibility
// of the layer; `deeper`: brightness of the hair below, relative to that of the layer; `around`: colour of the hair
// below, divided by `deeper`, without the colour of the surface.
fn sky_varying(s: Shell, direction: vec3<f32>, b: Baked, deeper: f32, around: vec3<f32>) -> SkyVarying {
    let m = mapped_varying(s);
    let sky = sky_at(s.at.spot, tile_of(s.at.spot));
    let light = toned(sky, direction, b, s.at.light_ts, deeper);
    var out: SkyVarying;
    out.position = m.position;
    out.uv_cosine_length = m.uv_cosine_length;
    out.light_red = m.light_red;
    out.eye_green = vec4(sky.eye, m.half_green.w);
    out.ambient_blue = m.ambient_blue;
    out.place = m.place;
    out.specular_layer = m.specular_layer;
    out.base_uv_groom = m.base_uv_groom;
    out.slope_alpha_map = m.slope_alpha_map;
    out.dark_open = vec4(light.sky_once[0], light.open);
    out.middle_key = vec4(light.sky_once[1], light.key_often.x);
    out.bright_key = vec4(light.sky_once[2], light.key_often.y);
    out.often_dark_key = vec4(light.sky_often[0], light.key_often.z);
    out.often_middle_around = vec4(light.sky_often[1], around.r);
    out.often_bright_around = vec4(light.sky_often[2], around.g);
    out.key_once_around = vec4(light.key_once, around.b);
    return out;
}

// Inputs of a fragment.
struct ShellFragment {
    tile_uv: vec2<f32>,
    layer: u32,
    // Number of baked layers that the shell represents.
    stands_for: f32,
    n_dot_e: f32,
    length: f32,
    base_uv: vec2<f32>,
    groom: vec2<f32>,
    slope: f32,
    base_alpha: f32,
    place: vec4<f32>,
    map_layer: f32,
    // Offset of hair from its root in addition to `aside`, per unit of the hair's sideways direction.
    along: f32,
    // Tint for scattering by fibres and for lights that are evaluated per fragment.
    tint: vec3<f32>,
    spot: Spot,
    // Light of the environment.
    sky: Sky,
    // Arriving light, without the visibility of the key light.
    arriving: Arriving,
}

// Inputs that this variant lacks are zero here; other variants set them.
fn plain_fragment(in: PlainVarying) -> ShellFragment {
    let layer = in.specular_layer.w & LAYER_BITS;
    var out: ShellFragment;
    out.tile_uv = in.uv_cosine_length.xy;
    out.layer = layer;
    out.stands_for = bitcast<f32>(in.specular_layer.w & ~LAYER_BITS);
    out.n_dot_e = in.uv_cosine_length.z;
    out.length = in.uv_cosine_length.w;
    out.base_alpha = 1.0;
    out.place = in.place;
    // In this variant, drawn, baked and map layers are the same; other variants override the map layer.
    out.map_layer = f32(layer);
    out.arriving.ambient = in.ambient_blue.rgb;
    out.arriving.diffuse = vec3(in.light_red.w, in.half_green.w, in.ambient_blue.w);
    out.arriving.specular = bitcast<vec3<f32>>(in.specular_layer.xyz);
    out.arriving.light_ts = in.light_red.xyz;
    out.arriving.half_ts = in.half_green.xyz;
    out.arriving.facing = back_attenuation(in.light_red.z, instance.back_light_range);
    out.arriving.visible = 1.0;
    out.arriving.past = 1.0;
    // In this variant, only scattering by fibres uses the tint, and its diffuse constant is 1.
    out.tint = out.arriving.diffuse;
    return out;
}

// Unpacks the interpolants for material textures and maps.
fn mapped_fragment(in: MappedVarying) -> ShellFragment {
    var plain: PlainVarying;
    plain.position = in.position;
    plain.uv_cosine_length = in.uv_cosine_length;
    plain.light_red = in.light_red;
    plain.half_green = in.half_green;
    plain.ambient_blue = in.ambient_blue;
    plain.place = in.place;
    plain.specular_layer = in.specular_layer;
    var out = plain_fragment(plain);
    out.base_uv = in.base_uv_groom.xy;
    out.groom = in.base_uv_groom.zw;
    out.slope = in.slope_alpha_map.x;
    out.base_alpha = in.slope_alpha_map.y;
    out.map_layer = in.slope_alpha_map.z;
    out.along = in.slope_alpha_map.w;
    return out;
}

// Unpacks the interpolants for lights that are evaluated per fragment.
fn filled_fragment(in: FilledVarying) -> ShellFragment {
    var mapped: MappedVarying;
    mapped.position = in.position;
    mapped.uv_cosine_length = in.uv_cosine_length;
    mapped.light_red = in.light_red;
    mapped.half_green = in.half_green;
    mapped.ambient_blue = in.ambient_blue;
    mapped.place = in.place;
    mapped.specular_layer = in.specular_layer;
    mapped.base_uv_groom = in.base_uv_groom;
    mapped.slope_alpha_map = in.slope_alpha_map;
    var out = mapped_fragment(mapped);
    out.tint = vec3(in.position_ws_red.w, in.normal_ws_green.w, in.blue_open.x);
    out.spot = Spot(in.position_ws_red.xyz, in.normal_ws_green.xyz, in.tangent, in.blue_open.yzw);
    out.sky = sky_at(out.spot, tile_of(out.spot));
    return out;
}

// Unpacks the interpolants for scattering by fibres under an environment, except the light.
fn sky_fragment(in: SkyVarying) -> ShellFragment {
    var mapped: MappedVarying;
    mapped.position = in.position;
    mapped.uv_cosine_length = in.uv_cosine_length;
    mapped.light_red = in.light_red;
    // Only green is used: eye_of_sky returns the direction to the eye.
    mapped.half_green = in.eye_green;
    mapped.ambient_blue = in.ambient_blue;
    mapped.place = in.place;
    mapped.specular_layer = in.specular_layer;
    mapped.base_uv_groom = in.base_uv_groom;
    mapped.slope_alpha_map = in.slope_alpha_map;
    return mapped_fragment(mapped);
}

// Returns the direction to the eye in the tile frame.
fn eye_of_sky(in: SkyVarying) -> vec3<f32> {
    return in.eye_green.xyz * inverseSqrt(max(dot(in.eye_green.xyz, in.eye_green.xyz), 1e-12));
}

// Returns the colour of the hair below, as sky_varying expects it.
fn hair_below_sky(in: SkyVarying) -> vec3<f32> {
    return vec3(in.often_middle_around.w, in.often_bright_around.w, in.key_once_around.w);
}

// Unpacks the light.
fn toned_of(in: SkyVarying) -> Toned {
    return Toned(
        array(in.dark_open.xyz, in.middle_key.xyz, in.bright_key.xyz),
        array(in.often_dark_key.xyz, in.often_middle_around.xyz, in.often_bright_around.xyz),
        in.key_once_around.xyz,
        vec3(in.middle_key.w, in.bright_key.w, in.often_dark_key.w),
        in.dark_open.w,
    );
}
