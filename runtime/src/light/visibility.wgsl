// How much of the key light arrives at a point: past the hair above it, by the layer-wise maps, and past other things, by the shadow-width
// map. Each part is a function of a receiver, and what arrives is their product.

@group(0) @binding(3) var layer_maps: texture_2d_array<f32>;
@group(0) @binding(4) var width_map: texture_2d<f32>;
@group(0) @binding(5) var map_sampler: sampler;

// Hair shadows hair: t of eq. (3).
override SELF_SHADOW: bool = false;
// Hair on guides shades what knows of its own hair alone.
override GUIDED_SHADOW: bool = false;
// Things throw soft shadows: Attenu_Shadow of eq. (3).
override SOFT_SHADOW: bool = false;

// Hair that skin is far from, or that faces away, is told where skin hides the light from it: fibres need no rule for what faces away. With SOFT_SHADOW.
override KNOWS_SKIN: bool = false;

// What the key light falls on.
struct Receiver {
    // Place in the shadow maps: (u w, v w, depth, w).
    place: vec4<f32>,
    // Layer of the layer-wise maps: 0 on the skin.
    map_layer: f32,
    // It lies between two of them.
    between: bool,
    // Cosine between the skin's normal and the direction towards the light.
    n_dot_l: f32,
}

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

// Share of the key light that the hair above lets through: t of eq. (3).
fn visible_through_hair(r: Receiver) -> f32 {
    if !SELF_SHADOW {
        return 1.0;
    }
    let uv = r.place.xy / r.place.w;
    if r.between {
        return light_between(uv, r.map_layer);
    }
    return textureSampleLevel(layer_maps, map_sampler, uv, u32(r.map_layer + 0.5), 0.0).r;
}

fn soft_shadow_of_frame() -> SoftShadow {
    return SoftShadow(frame.soft_shadow.x, frame.soft_shadow.y, frame.soft_shadow.z, frame.soft_shadow.w);
}

fn width_texel(place: vec4<f32>) -> vec4<f32> {
    return textureSampleLevel(width_map, map_sampler, place.xy / place.w, 0.0);
}

// Share of the key light that other things let through: Attenu_Shadow of eq. (3).
fn visible_past_things(r: Receiver) -> f32 {
    var past = 1.0;
    if GUIDED_SHADOW {
        // The outermost of the maps: nothing but that hair is above it.
        past = textureSampleLevel(layer_maps, map_sampler, r.place.xy / r.place.w, textureNumLayers(layer_maps) - 1u, 0.0).r;
    }
    if !SOFT_SHADOW {
        return past;
    }
    let path = slanted_path(r.n_dot_l);
    return past * soft_shadow(width_texel(r.place), r.place.z, r.place.w, path, soft_shadow_of_frame(), CENTRED);
}

// Share of the key light that comes past the first skin on its way, for hair far from its own: how wide shadows are is known where skin lies in
// them, and behind a body there may be none. 
fn visible_past_skin(r: Receiver) -> f32 {
    let uv = r.place.xy / r.place.w;
    let s = soft_shadow_of_frame();
    let nearest = r.place.z - depth_bias(r.place.w, slanted_path(r.n_dot_l), s) / s.range_m;
    let lit = select(vec4(0.0), vec4(1.0), textureGather(2, width_map, map_sampler, uv) >= vec4(nearest));
    let share = fract(uv * vec2<f32>(textureDimensions(width_map)) - 0.5);
    return mix(mix(lit.w, lit.z, share.x), mix(lit.x, lit.y, share.x), share.y);
}

// Both, for skin without hair of its own. The maps of hair know the first surface only: where that is another, its hair is not what is
// above this skin.
fn visible_on_bare(r: Receiver) -> f32 {
    var through = visible_through_hair(r);
    if !SOFT_SHADOW {
        return through;
    }
    let texel = width_texel(r.place);
    if BAKED_SHADOW {
        // No package knows what hair beside bare skin throws on it: the map of all hair does.
        through = texel.w;
    }
    let s = soft_shadow_of_frame();
    let path = slanted_path(r.n_dot_l);
    let hidden = (r.place.z - texel.z) * s.range_m > depth_bias(r.place.w, path, s);
    return soft_shadow(texel, r.place.z, r.place.w, path, s, CENTRED) * select(through, 1.0, hidden);
}
