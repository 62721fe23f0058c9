//! uses debug/false_color, hair/coat, hair/hair, hair/vertex, light/baked, light/environment, light/fills, light/forms,
//! light/gloss, light/key, light/point, light/visibility, shared/frame, shared/kajiya_kay, shared/tile_frame,
//! surface/place
// Opaque base mesh. Furred parts show the innermost hair layer; bare parts (eyes, hooves) are diffuse or glossy.

// Whether light is compressed so that no channel exceeds white, as in the bare style.
override ROLL_OFF: bool = false;
// Bare surface has normals of its own.
override BARE_NORMALS: bool = false;

struct SkinVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tint: vec4<f32>,
    @location(1) base_uv: vec2<f32>,
    @location(2) tile_uv: vec2<f32>,
    // Direction towards the light, in the tile frame.
    @location(3) light_ts: vec3<f32>,
    // Half vector H in the tile frame, or the factors of half_or_factors.
    @location(4) half_ts: vec3<f32>,
    // x: 1 where fur grows, 0 where its height is 0. y: hair length relative to the tile's. z: slope that the vertex
    // lean adds to the far fur layer.
    @location(5) grows_length_slope: vec3<f32>,
    @location(6) groom: vec2<f32>,
    @location(7) place: vec4<f32>,
    @location(8) position_ws: vec3<f32>,
    @location(9) normal_ws: vec3<f32>,
    @location(10) tangent: vec4<f32>,
    @location(11) open: vec3<f32>,
    // Normal of bare surface, if BARE_NORMALS.
    @location(12) bare_normal_ws: vec3<f32>,
}

// Returns the inputs of the fragment shader. `height`: height of the vertex above the surface, relative to the fur
// height.
fn skin_varying(v: Vertex, height: f32) -> SkinVarying {
    let tile = tile_frame_of(v, normal_ws(v));
    var position = position_ws(v);
    if COAT {
        position = hair_position(v, tile, height);
    }
    let at = hair_vertex(v, tile, position);
    var slope = 0.0;
    if COAT && LEAN {
        slope = lean_slope(v.lean, instance.coat_ambient_height);
    }
    var out: SkinVarying;
    out.position = at.position;
    out.tint = at.tint;
    out.base_uv = at.base_uv;
    out.tile_uv = v.tile_uv;
    out.light_ts = at.light_ts;
    out.half_ts = at.half_ts;
    out.grows_length_slope = vec3(select(0.0, 1.0, v.fur_height > 0.0), length_share(v), slope);
    out.groom = at.groom;
    out.place = at.place;
    out.position_ws = at.spot.position_ws;
    out.normal_ws = at.spot.normal_ws;
    out.tangent = at.spot.tangent;
    out.open = at.spot.open;
    out.bare_normal_ws = at.spot.normal_ws;
    return out;
}

// Does not read hair textures, which bare parts lack.
@vertex
fn vs_bare(v: Vertex) -> SkinVarying {
    return skin_varying(v, 0.0);
}

// The same for a model with bare normals.
@vertex
fn vs_bare_with_normals(v: Vertex, @location(13) bare: vec2<f32>) -> SkinVarying {
    return skin_varying(with_bare_normal(v, bare), 0.0);
}

fn furred_varying(v: Vertex) -> SkinVarying {
    // The far fur layer rises to its final height while the layers above it fade.
    let height = instance.detail_next * instance.coat_height;
    var out = skin_varying(v, height);
    let layer = select(0u, instance.baked_layers, COAT);
    let length = out.grows_length_slope.y;
    let slope = out.grows_length_slope.z;
    out.half_ts = half_or_factors(layer, length, slope, out.light_ts, out.half_ts, v.groom.y);
    return out;
}

@vertex
fn vs_furred(v: Vertex) -> SkinVarying {
    return furred_varying(v);
}

// The same for a model with bare normals.
@vertex
fn vs_furred_with_normals(v: Vertex, @location(13) bare: vec2<f32>) -> SkinVarying {
    var out = furred_varying(v);
    out.bare_normal_ws = normal_ws(with_bare_normal(v, bare));
    return out;
}

// Returns -1 for back faces, otherwise 1: the back of a double-sided part is lit from its own side.
fn side_of(front: bool) -> f32 {
    return select(-1.0, 1.0, front);
}

// Returns the light that a bare surface scatters to the eye, summed over all lights.
fn bare_color(base: vec3<f32>, n_dot_l: f32, visible: f32, spot: Spot, side: f32, gloss: GlossPoint) -> vec3<f32> {
    return key_light_on_bare(base, n_dot_l, visible, spot, gloss) + fill_lights_on_bare(base, spot, side, gloss)
        + environment_on_bare(base, spot, side, gloss);
}

@fragment
fn fs_bare(in: SkinVarying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let side = side_of(front);
    let n_dot_l = in.light_ts.z * side;
    let visible = visible_on_bare(Receiver(in.place, 0.0, false, n_dot_l));
    let spot = Spot(in.position_ws, in.normal_ws, in.tangent, in.open);
    let gloss = gloss_point(base.rgb, spot, side);
    let mirrored = gloss_color(gloss, visible, spot, side);
    if ROLL_OFF {
        let light = rolled_off(bare_color(vec3(1.0), n_dot_l, visible, spot, side, gloss), brightest_light());
        let scattered = base.rgb * light;
        // Highlights fill the range that the scattered light leaves.
        let share = mirrored / (1.0 + max(mirrored.r, max(mirrored.g, mirrored.b)));
        return false_color(vec4(scattered + share * max(1.0 - scattered, vec3(0.0)), 1.0), 0u, 0.0);
    }
    let color = bare_color(base.rgb, n_dot_l, visible, spot, side, gloss) + mirrored;
    return false_color(vec4(color, 1.0), 0u, 0.0);
}

// Returns the maximum light on a bare surface, with all lights along its normal: F of formulas 4.1.
fn brightest_light() -> vec3<f32> {
    var full = instance.ambient + instance.diffuse;
    if FILL_LIGHTS {
        for (var i = 0u; i < frame.fill_lights; i++) {
            full += instance.diffuse_constant * fill_lights[i].color.rgb;
        }
    }
    full += instance.diffuse_constant * frame.environment_most;
    return full;
}

// Compresses light in the range 0..=full so that its strongest channel is at most 1 (formulas 4.1). If F is above 1,
// the result is L / (1 + L (F - 1) / F), with L and F of that channel. Dim light and hue are preserved, and full light
// becomes 1.
fn rolled_off(light: vec3<f32>, full: vec3<f32>) -> vec3<f32> {
    let most = max(full.r, max(full.g, full.b));
    let here = max(light.r, max(light.g, light.b));
    return light / (1.0 + here * max(most - 1.0, 0.0) / max(most, 1.0));
}

@fragment
fn fs_furred(in: SkinVarying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let base = base_color(in.tint, in.base_uv);
    let groom = groom_at(in.groom, in.base_uv);
    let hair = hair_at(in.tile_uv, 0u, groom.y);
    var far: Hair;
    if COAT {
        far = hair_at(in.tile_uv, instance.baked_layers, groom.y);
    }
    if is_cut(base.a) {
        discard;
    }
    let side = side_of(front);
    let light = vec3(in.light_ts.xy, in.light_ts.z * side);
    let receiver = Receiver(in.place, 0.0, false, light.z);
    let past = visible_past_things(receiver);
    var through = visible_through_hair(receiver);
    if COAT && !BAKED_SHADOW {
        // The shadow maps do not include the far fur layer.
        let below = visible_below_coat(far, groom.x, light.z, in.grows_length_slope.y);
        through = mix(through, below, instance.detail_next);
    }
    let visible = through * past;
    let spot = Spot(in.position_ws, in.normal_ws, in.tangent, in.open);
    let color = hair.color;
    let kept = in.grows_length_slope.x * groom.x;
    let baked = baked_at(in.tile_uv, 0u, groom.y, kept, in.grows_length_slope.y, 0.0);
    var point: HairPoint;
    point.spot = spot;
    point.direction = grown(hair.direction, in.grows_length_slope.y, 0.0);
    let hair_color = hair_base(base);
    point.color = color.rgb * hair_color.rgb;
    point.opacity = color.a;
    point.tint = vec3(1.0);
    point.deeper = color.rgb * hair_color.rgb;
    point.wetness = groom.y;
    point.arriving = arriving_at(0.0, light, in.half_ts, through, past);
    point.baked = baked;
    point.sky = sky_at(spot, tile_of(spot));
    let here = KeptAt(groom.x, in.groom, in.base_uv, in.tile_uv);
    point.baked.kept = in.grows_length_slope.x * kept_towards(here, light, 0.0, in.grows_length_slope.y);
    var bare_spot = spot;
    var n_dot_l = light.z;
    if BARE_NORMALS {
        bare_spot.normal_ws = in.bare_normal_ws;
        n_dot_l = dot(in.bare_normal_ws, direction_to(frame.light_ws, in.position_ws)) * side;
    }
    let reached = visible * visible_past_strands(baked, light);
    let gloss = gloss_point(base.rgb, bare_spot, side);
    let bare = bare_color(base.rgb, n_dot_l, reached, bare_spot, side, gloss)
        + gloss_color(gloss, reached, bare_spot, side);
    // The bake writes an opaque innermost layer. If a package's layer is not opaque, the bare surface shows between the
    // hairs.
    let ambient = ambient_attenuation(0.0, instance.ambient_floor);
    let undercoat = light_undercoat(point) + (1.0 - color.a) * ambient * bare;
    let skin = mix(bare, undercoat, in.grows_length_slope.x * groom.x);
    if COAT {
        let length = in.grows_length_slope.y;
        let slope = in.grows_length_slope.z;
        var far_fur: FarFur;
        far_fur.hair = far;
        far_fur.baked = baked_at(in.tile_uv, instance.baked_layers, groom.y, kept, length, slope);
        far_fur.undercoat = skin;
        far_fur.base_color = hair_color.rgb;
        if AT_ROOT {
            let root = in.base_uv - root_aside(aside_at(instance.coat_ambient_height), far.direction);
            far_fur.base_color = hair_base(base_color_at_root(in.tint, in.base_uv, root)).rgb;
        }
        far_fur.spot = spot;
        far_fur.sky = point.sky;
        far_fur.light_ts = light;
        far_fur.half_ts = in.half_ts;
        far_fur.length = length;
        far_fur.slope = slope;
        far_fur.share = instance.detail_next * in.grows_length_slope.x * groom.x;
        far_fur.wetness = groom.y;
        far_fur.past = past;
        return false_color(vec4(with_coat(far_fur), 1.0), 0u, far_fur.share);
    }
    return false_color(vec4(skin, 1.0), 0u, 0.0);
}
