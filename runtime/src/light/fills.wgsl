//! uses light/baked, light/fibre, light/gloss, light/point, light/scatter, shared/frame, shared/kajiya_kay,
//! shared/skinning, shared/tile_frame, surface/place
// Fill lights, which cast no shadows.

// Maximum number of fill lights per frame.
const MAX_FILL_LIGHTS: u32 = 32u;
// Maximum number of lobes of an environment.
const MAX_LOBES: u32 = 32u;

// Fill lights; then, from MAX_FILL_LIGHTS, the lobes of the environment.
@group(0) @binding(2) var<uniform> fill_lights: array<FillLight, MAX_FILL_LIGHTS + MAX_LOBES>;

// Whether the frame has fill lights.
override FILL_LIGHTS: bool = false;

// Returns the tile frame of a point of hair, in which lights are evaluated.
fn tile_of(spot: Spot) -> TileFrame {
    return tile_frame(normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)), spot.tangent.xyz, spot.tangent.w);
}

// Returns the terms of eq. (1) times Attenu_Back, summed over the fill lights (formulas 4.1).
fn fill_lights_on_hair(p: HairPoint, coat: Coat) -> vec3<f32> {
    let spot = p.spot;
    let color = p.color * p.tint;
    let tile = tile_of(spot);
    let eye = direction_to(frame.eye_ws, spot.position_ws);
    var sum = vec3(0.0);
    for (var i = 0u; i < frame.fill_lights; i++) {
        let towards = direction_to(fill_lights[i].light_ws, spot.position_ws);
        let light = to_tile(tile, towards);
        if SCATTERING {
            let above = above_rim(light.z, p.baked.texel.w);
            let direct = visible_past_strands(p.baked, light);
            let sent = scatter(p.direction, light, to_tile(tile, eye), coat, above, direct);
            sum += fill_lights[i].color.rgb * (sent.once + sent.often) * p.opacity;
            continue;
        }
        let sent = fibre(p.direction, light, to_tile(tile, half_vector(towards, eye)), p.wetness)
            * (back_attenuation(light.z, instance.back_light_range) * visible_past_strands(p.baked, light));
        let lit = color * instance.diffuse_constant * sent.x + instance.specular_constant * (sent.y * p.opacity);
        sum += lit * fill_lights[i].color.rgb;
    }
    return sum;
}

// Returns the fill light that the mat of an undercoat with that colour reflects (formulas 4.13).
fn fill_lights_on_mat(p: HairPoint, color: vec3<f32>) -> vec3<f32> {
    let tile = tile_of(p.spot);
    var sum = vec3(0.0);
    for (var i = 0u; i < frame.fill_lights; i++) {
        let light = to_tile(tile, direction_to(fill_lights[i].light_ws, p.spot.position_ws));
        sum += fill_lights[i].color.rgb * reaches_mat(light.z, color, visible_past_strands(p.baked, light));
    }
    return sum;
}

// Returns the fill light on a bare surface, by Lambert's law (formulas 4.1). `side`: -1 for the back of a double-sided
// part.
fn fill_lights_on_bare(color: vec3<f32>, spot: Spot, side: f32, gloss: GlossPoint) -> vec3<f32> {
    var sum = vec3(0.0);
    if !FILL_LIGHTS {
        return sum;
    }
    let normal = normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)) * side;
    for (var i = 0u; i < frame.fill_lights; i++) {
        let towards = direction_to(fill_lights[i].light_ws, spot.position_ws);
        let enters = past_gloss(gloss, towards) * max(dot(normal, towards), 0.0);
        sum += color * instance.diffuse_constant * enters * fill_lights[i].color.rgb;
    }
    return sum;
}
