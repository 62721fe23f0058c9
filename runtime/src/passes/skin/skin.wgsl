// The skin: the opaque base mesh. Furred parts carry the innermost layer of hair, bare parts (eyes, hooves) plain diffuse light.

struct SkinVarying {
    @invariant @builtin(position) position: vec4<f32>,
    @location(0) tint: vec4<f32>,
    @location(1) base_uv: vec2<f32>,
    @location(2) tile_uv: vec2<f32>,
    // Towards the light, in the tile frame.
    @location(3) light_ts: vec3<f32>,
    // H, in the tile frame, or as half_or_factors says.
    @location(4) half_ts: vec3<f32>,
    // 1 where fur grows, 0 where its height is 0; slope that the lean of the vertex adds to the hair of the coat.
    @location(5) coat_slope: vec2<f32>,
    @location(6) groom: vec2<f32>,
    @location(7) place: vec4<f32>,
    @location(8) position_ws: vec3<f32>,
    @location(9) normal_ws: vec3<f32>,
    @location(10) tangent: vec4<f32>,
}

// height: share of the fur's height.
fn skin_varying(v: Vertex, height: f32) -> SkinVarying {
    let tile = tile_frame_of(v, normal_ws(v));
    var position = position_ws(v);
    if COAT {
        position = hair_position(v, tile, height);
    }
    let light = direction_to(frame.light_ws, position);
    let half = half_vector(light, direction_to(frame.eye_ws, position));
    var out: SkinVarying;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.tile_uv = v.tile_uv;
    out.light_ts = to_tile(tile, light);
    out.half_ts = to_tile(tile, half);
    out.coat_slope = vec2(select(0.0, 1.0, v.fur_height > 0.0), 0.0);
    if COAT && LEAN {
        out.coat_slope.y = lean_slope(v.lean, instance.coat_ambient_height);
    }
    out.groom = v.groom.xy;
    out.place = map_place(position);
    let spot = spot_of(v, position, tile);
    out.position_ws = spot.position_ws;
    out.normal_ws = spot.normal_ws;
    out.tangent = spot.tangent;
    return out;
}

// Bare skin has no hair textures to look at.
@vertex
fn vs_bare(v: Vertex) -> SkinVarying {
    return skin_varying(v, 0.0);
}

@vertex
fn vs_furred(v: Vertex) -> SkinVarying {
    // The coat rises to its place while the layers above it fade.
    let height = instance.detail_next * instance.coat_height;
    var out = skin_varying(v, height);
    let layer = select(0u, instance.baked_layers, COAT);
    out.half_ts = half_or_factors(layer, out.coat_slope.y, out.light_ts, out.half_ts, v.groom.y);
    return out;
}

// Lambert's law with the package's constants, so that bare parts are as bright as the fur beside them.
fn shade_bare(color: vec3<f32>, n_dot_l: f32, reach: f32) -> vec3<f32> {
    return color * (instance.ambient + instance.diffuse * (max(n_dot_l, 0.0) * reach));
}

// The surface seen in front or from behind: the back of a double-sided part is lit by what shines on the back.
fn side_of(front: bool) -> f32 {
    return select(-1.0, 1.0, front);
}

@fragment
fn fs_bare(in: SkinVarying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let base = base_color(in.tint, in.base_uv);
    if is_cut(base.a) {
        discard;
    }
    let side = side_of(front);
    let n_dot_l = in.light_ts.z * side;
    let reach = light_on_bare(in.place, n_dot_l);
    let spot = Spot(in.position_ws, in.normal_ws, in.tangent);
    return vec4(shade_bare(base.rgb, n_dot_l, reach) + fill_bare(base.rgb, spot, side), 1.0);
}

// The far coat over the undercoat, as far as it has taken over. past: share of the key light that comes past other things.
fn with_coat(far: Hair, undercoat: vec3<f32>, base: vec3<f32>, in: SkinVarying, groom: vec2<f32>, light: vec3<f32>, past: f32) -> vec3<f32> {
    if far.color.a < LEAST_ALPHA {
        return undercoat;
    }
    var direction = far.direction;
    if LEAN {
        direction = leaned_direction(direction, in.coat_slope.y);
    }
    // As the layers that it stands for: where half of the hair grows, half of the optical depth is left.
    let alpha = resampled_opacity(far.color.a, instance.detail_next * in.coat_slope.x * groom.x);
    let tint = far.color.rgb * (alpha / far.color.a) * base;
    let share = ambient_attenuation(instance.coat_ambient_height, instance.ambient_floor);
    let reach = past * coat_light(slanted_path(light.z), instance.coat_light_base, instance.coat_light_slope);
    let spot = Spot(in.position_ws, in.normal_ws, in.tangent);
    let hair = shade_hair(tint, alpha, direction, light, in.half_ts, share, groom.y, reach)
        + fill_hair(tint, alpha, direction, spot, groom.y);
    return hair + (1.0 - alpha) * undercoat;
}

@fragment
fn fs_furred(in: SkinVarying, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let base = base_color(in.tint, in.base_uv);
    let groom = groom_at(in.groom, in.base_uv);
    let texel = hair_at(in.tile_uv, 0u, groom.y);
    var far: Hair;
    if COAT {
        far = hair_at(in.tile_uv, instance.baked_layers, groom.y);
    }
    if is_cut(base.a) {
        discard;
    }
    let side = side_of(front);
    let light = vec3(in.light_ts.xy, in.light_ts.z * side);
    let past = light_past_things(in.place, light.z);
    var through = light_through_hair(in.place, 0.0, false);
    if COAT {
        // No map knows what the coat stands for.
        let path = frame.hair_density * slanted_path(light.z);
        through = mix(through, layer_transmittance(far.color.a * groom.x, path), instance.detail_next);
    }
    let reach = through * past;
    let spot = Spot(in.position_ws, in.normal_ws, in.tangent);
    let share = ambient_attenuation(0.0, instance.ambient_floor);
    let color = texel.color;
    let tint = color.rgb * base.rgb;
    let hair = shade_hair(tint, color.a, texel.direction, light, in.half_ts, share, groom.y, reach)
        + fill_hair(tint, color.a, texel.direction, spot, groom.y);
    let bare = shade_bare(base.rgb, light.z, reach) + fill_bare(base.rgb, spot, side);
    // The innermost layer is opaque in a package as bake writes it; where it is not, the bare skin shows between the hairs.
    let undercoat = hair + (1.0 - color.a) * share * bare;
    let skin = mix(bare, undercoat, in.coat_slope.x * groom.x);
    if COAT {
        return vec4(with_coat(far, skin, base.rgb, in, groom, light, past), 1.0);
    }
    return vec4(skin, 1.0);
}
