//! uses debug/false_color, hair/hair, hair/vertex, light/baked, light/forms, light/point, light/tones,
//! light/visibility, passes/shells/varying, shared/detail, shared/kajiya_kay, shared/layer_shadow, shared/opacity,
//! shared/tile_frame, surface/place
// Shells: layers 1 and up of the hair volume, from the inside out, one per instance index.

// Whether the maps of layer-wise shadows have other layers than are drawn, so that values between two layers are read.
override MAPS_BETWEEN: bool = false;

// Divisor from the index of a layer to that of the deeper layer whose mean colour tints the layer's multiply scattered
// light (formulas 4.13).
const LAYERS_TO_DEEPER: u32 = 4u;

// Returns the values of a vertex for the shell with the index `index` of the draw call.
fn shell_of(v: Vertex, index: u32) -> Shell {
    let layer = drawn_layer(index);
    let height = height_of(layer);
    let tile = tile_frame_of(v, normal_ws(v));
    let position = hair_position(v, tile, height);
    var at = hair_vertex(v, tile, position);
    at.tint = hair_base(at.tint);
    let times = stands_for(layer);
    var hair_height = height;
    if DETAIL {
        hair_height = visible_height(height, times, instance.drawn_layers);
    }
    let slope = lean_slope(v.lean, height);
    let baked = baked_layer(layer, instance.baked_layers, instance.drawn_layers);
    at.half_ts = half_or_factors(baked, length_share(v), slope, at.light_ts, at.half_ts, v.groom.y);
    var aside = vec3(0.0);
    if AT_ROOT {
        aside = aside_at(height);
        at.base_uv -= aside.xy;
    }
    var out: Shell;
    out.tile_uv = v.tile_uv;
    out.ambient = at.tint.rgb * instance.ambient * ambient_attenuation(hair_height, instance.ambient_floor);
    out.diffuse = at.tint.rgb * instance.diffuse;
    out.length = length_share(v);
    out.map_layer = hair_height * frame.last_map_layer;
    out.slope = slope;
    out.layer = baked;
    out.stands_for = times;
    out.aside = aside;
    out.at = at;
    return out;
}

@vertex
fn vs_shells(v: Vertex, @builtin(instance_index) index: u32) -> PlainVarying {
    return plain_varying(shell_of(v, index));
}

@vertex
fn vs_shells_mapped(v: Vertex, @builtin(instance_index) index: u32) -> MappedVarying {
    return mapped_varying(shell_of(v, index));
}

@vertex
fn vs_shells_filled(v: Vertex, @builtin(instance_index) index: u32) -> FilledVarying {
    return filled_varying(shell_of(v, index));
}

// Hair of a shell at a fragment.
struct ShellHair {
    // Sample of the hair volume.
    hair: Hair,
    // Colour as drawn, with the opacity of all layers that the shell represents.
    texel: vec4<f32>,
    base: vec3<f32>,
    // Share of the hair that grows, and wetness.
    groom: vec2<f32>,
}

// Returns the hair of a shell at a fragment, or discards the fragment. `eye`: direction to the eye in the tile frame.
fn shell_hair(in: ShellFragment, eye: vec3<f32>) -> ShellHair {
    var groom = groom_at(in.groom, in.base_uv);
    let hair = hair_at(in.tile_uv, in.layer, groom.y);
    var texel = hair.color;
    var root = in.base_uv;
    if AT_ROOT {
        // Subtract only the rest of the offset: the vertex shader has already subtracted the offset that is common to
        // all hair of this layer.
        root -= root_aside(vec3(0.0, 0.0, in.along), hair.direction);
        groom = groom_at_root(in.groom, in.base_uv, root);
    }
    var base = base_color_at_root(vec4(1.0, 1.0, 1.0, in.base_alpha), in.base_uv, root);
    if HAIR_COLOR {
        // The vertex shader has applied the colour of hair.
        base = vec4(1.0, 1.0, 1.0, base.a);
    }
    if texel.a * groom.x < LEAST_ALPHA || is_cut(base.a) {
        discard;
    }
    if RESAMPLED || DETAIL || LOOK_SLANTED {
        var times = 1.0;
        if RESAMPLED || DETAIL {
            times = in.stands_for;
        }
        if LOOK_SLANTED {
            let tangent = grown_tangent(hair.direction, select(1.0, in.length, SHORT), select(0.0, in.slope, LEAN));
            times *= view_depth_factor(tangent, length(hair.direction), eye, in.n_dot_e);
        }
        // The premultiplied colour scales with the opacity.
        texel *= resampled_opacity(texel.a, times) / texel.a;
    }
    texel *= groom.x * select(1.0, instance.layer_share, DETAIL);
    return ShellHair(hair, texel, base.rgb, groom);
}

// Returns premultiplied colour and opacity.
fn shell_color(in: ShellFragment) -> vec4<f32> {
    var arriving = in.arriving;
    let h = shell_hair(in, eye_of(arriving.light_ts, arriving.half_ts, in.n_dot_e));
    let texel = h.texel;
    let n_dot_l = arriving.light_ts.z;
    let receiver = Receiver(in.place, in.map_layer, MAPS_BETWEEN, n_dot_l);
    arriving.visible = visible_through_hair(receiver);
    arriving.past = visible_past_things(receiver);
    if SELF_SHADOW && LIGHT_SLANTED {
        // Shadow within the layer (formulas 4.2): the layer represents the hair up to the next one, half of which is
        // above its hair on average.
        let path = path_through(slanted_path(n_dot_l), in.length);
        arriving.visible *= layer_transmittance(h.hair.color.a * h.groom.x, 0.5 * frame.hair_density * path);
    }
    let height = f32(in.layer) / f32(instance.baked_layers - 1u);
    let at = KeptAt(h.groom.x, in.groom, in.base_uv, in.tile_uv);
    let kept = kept_towards(at, arriving.light_ts, height, in.length);
    var baked = baked_at(in.tile_uv, in.layer, h.groom.y, kept, in.length, in.slope);
    if DETAIL && BAKED_SHADOW {
        baked.within = light_within(h.hair.color.a, in.stands_for);
    }
    var point: HairPoint;
    point.spot = in.spot;
    point.direction = grown(h.hair.direction, in.length, in.slope);
    point.color = texel.rgb * h.base;
    point.opacity = texel.a;
    point.tint = in.tint;
    point.deeper = mean_of_layer(in.layer / LAYERS_TO_DEEPER, texel.rgb / texel.a) * h.base;
    point.wetness = h.groom.y;
    point.arriving = arriving;
    point.baked = baked;
    point.sky = in.sky;
    return false_color(vec4(light_hair(point), texel.a), 2u, 0.0);
}

// Returns the same, if the vertices have evaluated the light. `eye`: direction to the eye in the tile frame; `below`:
// colour of the hair below, as sky_varying expects it.
fn toned_color(in: ShellFragment, eye: vec3<f32>, light: Toned, below: vec3<f32>) -> vec4<f32> {
    var arriving = in.arriving;
    let h = shell_hair(in, eye);
    arriving.past = visible_past_things(Receiver(in.place, in.map_layer, MAPS_BETWEEN, arriving.light_ts.z));
    let color = h.texel.rgb * h.base;
    let full = color * in.tint / max(h.texel.a, 1e-6);
    let open = open_share(baked_at(in.tile_uv, in.layer, h.groom.y, h.groom.x, in.length, in.slope));
    let around = below * h.base * in.tint;
    let lit = color * arriving.ambient + h.texel.a * toned_light(light, full, around, open, arriving);
    return false_color(vec4(lit, h.texel.a), 2u, 0.0);
}

@vertex
fn vs_shells_sky(v: Vertex, @builtin(instance_index) index: u32) -> SkyVarying {
    let s = shell_of(v, index);
    let groom = groom_of_vertex(v.groom.xy);
    let mean = mean_hair_of_layer(s.layer, groom.y);
    let below = mean_hair_of_layer(s.layer / LAYERS_TO_DEEPER, groom.y);
    let white = vec3(1.0);
    let deeper = dot(below.color.rgb, white) * mean.color.a / max(dot(mean.color.rgb, white) * below.color.a, 1e-6);
    var baked = mean_baked_of_layer(s.layer, groom.y);
    baked.kept = groom.x;
    baked.length = s.length;
    baked.slope = s.slope;
    if DETAIL && BAKED_SHADOW {
        baked.within = light_within(SHOWN_ALPHA, s.stands_for);
    }
    let around = below.color.rgb / max(below.color.a * deeper, 1e-3);
    return sky_varying(s, grown(mean.direction, s.length, s.slope), baked, deeper, around);
}

@fragment
fn fs_shells(in: PlainVarying) -> @location(0) vec4<f32> {
    return shell_color(plain_fragment(in));
}

@fragment
fn fs_shells_mapped(in: MappedVarying) -> @location(0) vec4<f32> {
    return shell_color(mapped_fragment(in));
}

@fragment
fn fs_shells_filled(in: FilledVarying) -> @location(0) vec4<f32> {
    return shell_color(filled_fragment(in));
}

@fragment
fn fs_shells_sky(in: SkyVarying) -> @location(0) vec4<f32> {
    return toned_color(sky_fragment(in), eye_of_sky(in), toned_of(in), hair_below_sky(in));
}
