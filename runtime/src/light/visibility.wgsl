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

// Share of the key light that comes past the first surface on its way: behind a body in whose shadow nothing else lies, the map's occlusion is none. Deep
// in a shadow that it knows, it knows more: how soft.
fn visible_past_first(place: vec4<f32>, path: f32, occlusion: f32) -> f32 {
    let uv = place.xy / place.w;
    if any(abs(uv - 0.5) > vec2(0.5)) {
        return 1.0;
    }
    let s = soft_shadow_of_frame();
    // The map's half floats are good to a 2048th of its range.
    let nearest = place.z - depth_bias(place.w, path, s) / s.range_m - 1.0 / 2048.0;
    let lit = select(vec4(0.0), vec4(1.0), textureGather(2, width_map, map_sampler, uv) >= vec4(nearest));
    let share = fract(uv * vec2<f32>(textureDimensions(width_map)) - 0.5);
    let past = mix(mix(lit.w, lit.z, share.x), mix(lit.x, lit.y, share.x), share.y);
    return mix(past, 1.0, clamp(10.0 * occlusion - 4.0, 0.0, 1.0));
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
    let texel = width_texel(r.place);
    past *= soft_shadow(texel, r.place.z, r.place.w, path, soft_shadow_of_frame(), CENTRED);
    if HANGS {
        // Hair on guides hangs anywhere, and its root's skin says nothing of the way there.
        past *= visible_past_first(r.place, 4.0, texel.x);
    } else if SCATTERING && r.n_dot_l < 0.0 {
        // Fur that faces away is lit where it stands out beyond the outline, and not farther behind.
        past *= mix(1.0, visible_past_first(r.place, path, texel.x), min(-10.0 * r.n_dot_l, 1.0));
    }
    return past;
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
