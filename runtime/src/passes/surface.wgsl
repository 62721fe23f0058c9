// What the skin, fins and shells passes share: bindings and lighting a hair.

// Lights without shadow.
const MAX_FILL_LIGHTS: u32 = 32u;

@group(0) @binding(2) var<uniform> fill_lights: array<FillLight, MAX_FILL_LIGHTS>;
// Seen from the key light: transmittance of the hair above each map layer, and the soft shadow.
@group(0) @binding(3) var layer_maps: texture_2d_array<f32>;
@group(0) @binding(4) var width_map: texture_2d<f32>;
@group(0) @binding(5) var map_sampler: sampler;
@group(1) @binding(3) var groom_texture: texture_2d<f32>;
@group(2) @binding(0) var shell_colors: texture_2d_array<f32>;
@group(2) @binding(1) var shell_directions: texture_2d_array<f32>;
@group(2) @binding(2) var shell_sampler: sampler;
@group(2) @binding(3) var wet_colors: texture_2d_array<f32>;
@group(2) @binding(4) var wet_directions: texture_2d_array<f32>;

// The direction texture has two components.
override PLANAR_DIRECTIONS: bool = true;
// pd is 2: the power of sin^2 is itself.
override SQUARED_DIFFUSE: bool = false;
// ks is not zero.
override SPECULAR: bool = true;
// More or fewer layers are drawn than were baked.
override RESAMPLED: bool = true;
// Some of the layers are left out, or fade: a level of detail.
override DETAIL: bool = true;
// The far coat lies on the skin.
override COAT: bool = true;
// Some vertex is bare or wet.
override GROOM_VERTICES: bool = true;
// The material has a groom texture.
override GROOM_TEXTURE: bool = true;
// The package has wet hair to mix in.
override WET: bool = true;
// A layer blocks more of a look that goes through it at a slant.
override VIEW_SLANTED: bool = true;
// Hair shadows hair: t of eq. (3).
override SELF_SHADOW: bool = true;
// The light's way through a layer grows with its slant.
override SLANTED: bool = true;
// The layer-wise maps are of other layers than are drawn.
override MAPS_BETWEEN: bool = true;
// Things throw soft shadows: Attenu_Shadow of eq. (3).
override SOFT_SHADOW: bool = true;
// The penumbra lies on both sides of the hard edge.
override CENTRED: bool = true;
// There are lights without shadow.
override FILL_LIGHTS: bool = true;
// The key light's factors of eq. (1) are computed at vertices.
override VERTEX_LIGHTING: bool = false;

// Alpha test of the layered method: below half a step of an 8-bit texel there is nothing to see, and no depth to write.
const LEAST_ALPHA: f32 = 0.5 / 255.0;

// Height of a drawn layer: 0 on the skin, 1 the outermost.
fn height_of(layer: u32) -> f32 {
    return f32(layer) / f32(instance.drawn_layers - 1u);
}

// The layer that an instance of the draw is.
fn drawn_layer(index: u32) -> u32 {
    if !DETAIL {
        return index;
    }
    return detail_layer(index, instance.baked_layers, instance.layer_step);
}

// How many layers a drawn one stands for.
fn stands_for(layer: u32) -> f32 {
    if DETAIL {
        let baked = instance.baked_layers;
        return detail_exponent(
            layer, baked, instance.layer_step, instance.next_step, instance.detail_here, instance.detail_next,
        );
    }
    if RESAMPLED {
        return instance.opacity_exponent;
    }
    return 1.0;
}

// What the groom says of a point: share of the hair that grows, and wetness, both 0..=1. `at_vertex` is bareness and wetness.
fn groom_at(at_vertex: vec2<f32>, uv: vec2<f32>) -> vec2<f32> {
    var groom = vec2(1.0, 0.0);
    if GROOM_VERTICES {
        groom = vec2(1.0 - at_vertex.x, at_vertex.y);
    }
    if GROOM_TEXTURE {
        let texel = textureSample(groom_texture, base_color_sampler, uv);
        groom = vec2(groom.x * texel.x, min(groom.y + texel.y, 1.0));
    }
    return groom;
}

struct Hair {
    // Premultiplied colour and opacity.
    color: vec4<f32>,
    // In the tile frame.
    direction: vec3<f32>,
}

// The hair of a layer: dry and wet mixed.
fn hair_at(uv: vec2<f32>, layer: u32, wetness: f32) -> Hair {
    let color = textureSample(shell_colors, shell_sampler, uv, layer);
    let direction = decode_direction(textureSample(shell_directions, shell_sampler, uv, layer), PLANAR_DIRECTIONS);
    if !WET {
        return Hair(color, direction);
    }
    let wet_color = textureSample(wet_colors, shell_sampler, uv, layer);
    let wet = decode_direction(textureSample(wet_directions, shell_sampler, uv, layer), PLANAR_DIRECTIONS);
    return Hair(mix(color, wet_color, wetness), mix(direction, wet, wetness));
}

// Place of a point in the shadow maps: (u w, v w, depth, w).
fn map_place(position: vec3<f32>) -> vec4<f32> {
    return frame.map_from_world * vec4(position, 1.0);
}

// Transmittance of the hair above a point between two of the layer-wise maps.
fn light_between(uv: vec2<f32>, map_layer: f32) -> f32 {
    let below = floor(map_layer);
    let above = min(below + 1.0, frame.last_map_layer);
    return mix(
        textureSampleLevel(layer_maps, map_sampler, uv, u32(below), 0.0).r,
        textureSampleLevel(layer_maps, map_sampler, uv, u32(above), 0.0).r,
        map_layer - below,
    );
}

// Share of the key light that the hair above lets through to a point: t of eq. (3). map_layer: 0 on the skin.
fn light_through_hair(place: vec4<f32>, map_layer: f32, between: bool) -> f32 {
    if !SELF_SHADOW {
        return 1.0;
    }
    let uv = place.xy / place.w;
    if between {
        return light_between(uv, map_layer);
    }
    return textureSampleLevel(layer_maps, map_sampler, uv, u32(map_layer + 0.5), 0.0).r;
}

fn soft_shadow_of_frame() -> SoftShadow {
    return SoftShadow(frame.soft_shadow.x, frame.soft_shadow.y, frame.soft_shadow.z, frame.soft_shadow.w);
}

fn width_texel(place: vec4<f32>) -> vec4<f32> {
    return textureSampleLevel(width_map, map_sampler, place.xy / place.w, 0.0);
}

// Share of the key light that other things let through: Attenu_Shadow of eq. (3).
fn light_past_things(place: vec4<f32>, n_dot_l: f32) -> f32 {
    if !SOFT_SHADOW {
        return 1.0;
    }
    return soft_shadow(width_texel(place), place.z, place.w, slanted_path(n_dot_l), soft_shadow_of_frame(), CENTRED);
}

// Share of the key light that arrives at skin without hair of its own. The layer-wise maps know the first surface only: where that
// is another, its hair is not what is above this skin.
fn light_on_bare(place: vec4<f32>, n_dot_l: f32) -> f32 {
    let through = light_through_hair(place, 0.0, false);
    if !SOFT_SHADOW {
        return through;
    }
    let texel = width_texel(place);
    let s = soft_shadow_of_frame();
    let path = slanted_path(n_dot_l);
    let hidden = (place.z - texel.z) * s.range_m > depth_bias(place.w, path, s);
    return soft_shadow(texel, place.z, place.w, path, s, CENTRED) * select(through, 1.0, hidden);
}

// sin^pd and sin^ps of eq. (1), the latter as strong as wet and dry hair have it together.
fn hair_factors(direction: vec3<f32>, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec2<f32> {
    var diffuse = sin_squared(direction, light);
    if !SQUARED_DIFFUSE {
        diffuse = sin_power(diffuse, instance.diffuse_half_exponent);
    }
    if !SPECULAR {
        return vec2(diffuse, 0.0);
    }
    var strength = 1.0;
    var half_exponent = instance.specular_half_exponent;
    if WET {
        strength = mix(1.0, instance.wet_specular, wetness);
        half_exponent = mix(half_exponent, instance.wet_specular_half_exponent, wetness);
    }
    return vec2(diffuse, strength * sin_power(sin_squared(direction, half), half_exponent));
}

// What a vertex hands on for the key light: H, or hair_factors themselves where light is computed at vertices. There all that is known
// of the hair is the mean direction of its layer, which is the last level of the direction texture, and how the vertex leans it.
fn half_or_factors(layer: u32, slope: f32, light: vec3<f32>, half: vec3<f32>, wetness: f32) -> vec3<f32> {
    if !VERTEX_LIGHTING {
        return half;
    }
    var direction =
        decode_direction(textureLoad(shell_directions, vec2(0), layer, textureNumLevels(shell_directions) - 1u), PLANAR_DIRECTIONS);
    if WET {
        let last = textureNumLevels(wet_directions) - 1u;
        let wet = decode_direction(textureLoad(wet_directions, vec2(0), layer, last), PLANAR_DIRECTIONS);
        direction = mix(direction, wet, wetness);
    }
    if LEAN {
        direction = leaned_direction(direction, slope);
    }
    return vec3(hair_factors(direction, light, half, wetness), 0.0);
}

// The key light's factors in a fragment.
fn key_factors(direction: vec3<f32>, light: vec3<f32>, half_or_factors: vec3<f32>, wetness: f32) -> vec2<f32> {
    if VERTEX_LIGHTING {
        return half_or_factors.xy;
    }
    return hair_factors(direction, light, half_or_factors, wetness);
}

// Yang 2006, eq. (3). Linear in the hair's colour, so `color` may be premultiplied with `alpha`, and the result then is.
// light and half: towards the light and H in the tile frame, lengths near 1, or what half_or_factors puts there. reach: share of the key light that arrives, which is
// t Attenu_Shadow.
fn shade_hair(
    color: vec3<f32>,
    alpha: f32,
    direction: vec3<f32>,
    light: vec3<f32>,
    half: vec3<f32>,
    ambient_share: f32,
    wetness: f32,
    reach: f32,
) -> vec3<f32> {
    let arriving = back_attenuation(light.z, instance.back_light_range) * reach;
    let factors = key_factors(direction, light, half, wetness) * arriving;
    let soft = color * (instance.ambient * ambient_share + instance.diffuse * factors.x);
    return soft + instance.specular * (factors.y * alpha);
}

// Where a fragment is, for lights that are not known per vertex.
struct Spot {
    position_ws: vec3<f32>,
    normal_ws: vec3<f32>,
    // Along +u of the tile; handedness.
    tangent: vec4<f32>,
}

fn spot_of(v: Vertex, position: vec3<f32>, tile: TileFrame) -> Spot {
    return Spot(position, tile.normal_ws, vec4(tile.tangent_ws, v.tangent.w * instance.handedness));
}

// What the lights without shadow add to hair: the terms of eq. (1) and Attenu_Back of each.
fn fill_hair(color: vec3<f32>, alpha: f32, direction: vec3<f32>, spot: Spot, wetness: f32) -> vec3<f32> {
    var sum = vec3(0.0);
    if !FILL_LIGHTS {
        return sum;
    }
    let tile = tile_frame(normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)), spot.tangent.xyz, spot.tangent.w);
    let eye = direction_to(frame.eye_ws, spot.position_ws);
    for (var i = 0u; i < frame.fill_lights; i++) {
        let towards = direction_to(fill_lights[i].light_ws, spot.position_ws);
        let light = to_tile(tile, towards);
        let factors = hair_factors(direction, light, to_tile(tile, half_vector(towards, eye)), wetness)
            * back_attenuation(light.z, instance.back_light_range);
        let lit = color * instance.diffuse_constant * factors.x + instance.specular_constant * (factors.y * alpha);
        sum += lit * fill_lights[i].color.rgb;
    }
    return sum;
}

// What they add to bare skin, by Lambert's law. side: -1 for the back of a double-sided part.
fn fill_bare(color: vec3<f32>, spot: Spot, side: f32) -> vec3<f32> {
    var sum = vec3(0.0);
    if !FILL_LIGHTS {
        return sum;
    }
    let normal = normalize_or(spot.normal_ws, vec3(0.0, 1.0, 0.0)) * side;
    for (var i = 0u; i < frame.fill_lights; i++) {
        let towards = direction_to(fill_lights[i].light_ws, spot.position_ws);
        sum += color * instance.diffuse_constant * max(dot(normal, towards), 0.0) * fill_lights[i].color.rgb;
    }
    return sum;
}
