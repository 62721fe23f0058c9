//! uses debug/false_color, hair/fin_corner, hair/hair, hair/vertex, light/baked, light/environment, light/fills,
//! light/forms, light/key, light/point, light/visibility, shared/tile_frame, surface/place
// Fins: a quad on every mesh edge, visible when it faces the eye, which is along the outline (Lengyel 2001). Faded fins
// collapse into a point and produce no fragments.

struct FinVarying {
    @invariant @builtin(position) position: vec4<f32>,
    // x: horizontal coordinate in the fin texture. y: height, 0 on the mesh surface, 1 at the outermost layer.
    @location(0) slab_uv: vec2<f32>,
    @location(1) light_ts: vec3<f32>,
    @location(2) half_ts: vec3<f32>,
    @location(3) tint: vec4<f32>,
    @location(4) base_uv: vec2<f32>,
    @location(5) @interpolate(flat, either) slab: u32,
    @location(6) @interpolate(flat, either) opacity: f32,
    @location(7) groom: vec2<f32>,
    // Hair length relative to that of the hair tile, and the slope that the lean of the vertex adds at this height.
    @location(8) length_slope: vec2<f32>,
    @location(9) place: vec4<f32>,
    @location(10) position_ws: vec3<f32>,
    @location(11) normal_ws: vec3<f32>,
    @location(12) tangent: vec4<f32>,
    @location(13) open: vec3<f32>,
}

// Returns the mean baked visibility at a height (formulas 4.9). The mean is used because the package does not store
// which strands of the tile are in a fin texture.
fn baked_at_height(height: f32, kept: f32, length: f32, slope: f32) -> Baked {
    var texel = vec4(1.0);
    if BAKED_SHADOW {
        let layer = height * f32(instance.baked_layers - 1u);
        let below = u32(layer);
        let last = f32(textureNumLevels(visibility) - 1u);
        texel = mix(
            textureSampleLevel(visibility, shell_sampler, vec2(0.5), below, last),
            textureSampleLevel(visibility, shell_sampler, vec2(0.5), min(below + 1u, instance.baked_layers - 1u), last),
            layer - f32(below),
        );
    }
    var baked: Baked;
    baked.texel = texel;
    baked.kept = kept;
    baked.length = length;
    baked.slope = slope;
    baked.within = 1.0;
    return baked;
}

@vertex
fn vs_fins(@builtin(vertex_index) index: u32) -> FinVarying {
    let corner = fin_corner(index);
    let opacity = corner.opacity * instance.fin_share;
    let v = corner.vertex;
    let at = hair_vertex(v, corner.tile, hair_position(v, corner.tile, corner.height));
    let length = length_share(v);
    let slope = lean_slope(v.lean, corner.height);
    var out: FinVarying;
    out.position = at.position;
    if opacity < LEAST_ALPHA {
        out.position = vec4(0.0, 0.0, 0.0, 1.0);
    }
    out.slab_uv = vec2(corner.along, corner.height);
    out.light_ts = at.light_ts;
    out.half_ts = half_or_factors(corner.slab, length, slope, at.light_ts, at.half_ts, 0.0);
    out.tint = at.tint;
    out.base_uv = at.base_uv;
    out.slab = corner.slab;
    out.opacity = opacity;
    out.groom = at.groom;
    out.length_slope = vec2(length, slope);
    out.place = at.place;
    out.position_ws = at.spot.position_ws;
    out.normal_ws = at.spot.normal_ws;
    out.tangent = at.spot.tangent;
    out.open = at.spot.open;
    return out;
}

// Returns premultiplied colour and opacity.
@fragment
fn fs_fins(in: FinVarying) -> @location(0) vec4<f32> {
    let hair = dry_hair_at(in.slab_uv, in.slab);
    var root = in.base_uv;
    if AT_ROOT {
        root -= root_aside(aside_at(in.slab_uv.y), hair.direction);
    }
    let groom = groom_at_root(in.groom, in.base_uv, root);
    let base = hair_base(base_color_at_root(in.tint, in.base_uv, root));
    // Keep the hair that grows outside wet locks; fins have no wet locks.
    let texel = hair.color * (in.opacity * groom.x * select(1.0, 1.0 - groom.y, WET));
    if texel.a < LEAST_ALPHA || is_cut(base.a) {
        discard;
    }
    let height = clamp(in.slab_uv.y, 0.0, 1.0);
    let receiver = Receiver(in.place, height * frame.last_map_layer, true, in.light_ts.z);
    let visible = visible_through_hair(receiver);
    let past = visible_past_things(receiver);
    let length = in.length_slope.x;
    let slope = in.length_slope.y;
    var point: HairPoint;
    point.spot = Spot(in.position_ws, in.normal_ws, in.tangent, in.open);
    point.direction = grown(hair.direction, length, slope);
    point.color = texel.rgb * base.rgb;
    point.opacity = texel.a;
    point.tint = vec3(1.0);
    point.deeper = mean_of_layer(in.slab, texel.rgb / texel.a) * base.rgb;
    point.wetness = 0.0;
    point.arriving = arriving_at(in.slab_uv.y, in.light_ts, in.half_ts, visible, past);
    point.baked = baked_at_height(height, groom.x, length, slope);
    point.sky = sky_at(point.spot, tile_of(point.spot));
    return false_color(vec4(light_hair(point), texel.a), 3u, 0.0);
}
