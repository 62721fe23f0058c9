//! uses light/baked, light/forms, light/scatter, shared/layer_shadow, shared/soft_shadow, surface/place
// Share of the key light that reaches a point, as the product of two factors. One is the share that the hair above lets
// through, from the layer-wise maps. The other is the share that other objects let through, from the shadow-width map.
// A function computes each factor for a receiver.

@group(0) @binding(3) var layer_maps: texture_2d_array<f32>;
@group(0) @binding(4) var width_map: texture_2d<f32>;
@group(0) @binding(5) var map_sampler: sampler;

// Whether hair shadows hair: t of eq. (3).
override SELF_SHADOW: bool = false;
// Whether guided hair casts shadows on fur whose baked shadows include only the fur itself.
override GUIDED_SHADOW: bool = false;
// Whether objects cast soft shadows: Attenu_Shadow of eq. (3).
override SOFT_SHADOW: bool = false;

// Point that receives the key light.
struct Receiver {
    // Position in the shadow maps: (u w, v w, depth, w).
    place: vec4<f32>,
    // Layer of the receiver in the layer-wise maps: 0 on the skin.
    map_layer: f32,
    // The receiver is between two layers of the maps.
    between: bool,
    // Cosine between the surface normal and the direction towards the light.
    n_dot_l: f32,
}

// Returns the position of a world-space point in the shadow maps: (u w, v w, depth, w).
fn map_place(position: vec3<f32>) -> vec4<f32> {
    return frame.map_from_world * vec4(position, 1.0);
}

// Returns the transmittance of the hair above a point between two layer-wise maps (formulas 4.2).
fn light_between(uv: vec2<f32>, map_layer: f32) -> f32 {
    let below = floor(map_layer);
    let above = min(below + 1.0, frame.last_map_layer);
    return mix(
        textureSampleLevel(layer_maps, map_sampler, uv, u32(below), 0.0).r,
        textureSampleLevel(layer_maps, map_sampler, uv, u32(above), 0.0).r,
        map_layer - below,
    );
}

// Returns the share of the key light that the hair above lets through: t of eq. (3) (formulas 4.2).
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

// Returns the scales of the shadow-width map of this frame.
fn soft_shadow_of_frame() -> SoftShadow {
    return SoftShadow(frame.soft_shadow.x, frame.soft_shadow.y, frame.soft_shadow.z, frame.soft_shadow.w);
}

// Samples the shadow-width map. `place`: position in the maps.
fn width_texel(place: vec4<f32>) -> vec4<f32> {
    return textureSampleLevel(width_map, map_sampler, place.xy / place.w, 0.0);
}

// Resolution of the shadow-width map's half floats, relative to their range.
const WIDTH_MAP_STEP: f32 = 1.0 / 2048.0;
// Slope and offset of a ramp that rises from 0 to 1 between the occlusions 0.4 and 0.5. Above it, the map's own soft
// shadow is used.
const OCCLUDED_SLOPE: f32 = 10.0;
const OCCLUDED_OFFSET: f32 = 4.0;
// Slope of the ramp over -n_dot_l along which fur behind the terminator loses light to the first surface.
const AWAY_SLOPE: f32 = 10.0;

// Returns the share of the key light that the first surface on its path lets through (formulas 4.13). It is needed
// because the map stores no occlusion behind a body whose shadow falls on nothing else. Deep in a stored shadow, the
// map's own soft shadow is used.
fn visible_past_first(place: vec4<f32>, path: f32, occlusion: f32) -> f32 {
    let uv = place.xy / place.w;
    if any(abs(uv - 0.5) > vec2(0.5)) {
        return 1.0;
    }
    let s = soft_shadow_of_frame();
    let nearest = place.z - depth_bias(place.w, path, s) / s.range_m - WIDTH_MAP_STEP;
    let lit = select(vec4(0.0), vec4(1.0), textureGather(2, width_map, map_sampler, uv) >= vec4(nearest));
    let share = fract(uv * vec2<f32>(textureDimensions(width_map)) - 0.5);
    let past = mix(mix(lit.w, lit.z, share.x), mix(lit.x, lit.y, share.x), share.y);
    return mix(past, 1.0, clamp(OCCLUDED_SLOPE * occlusion - OCCLUDED_OFFSET, 0.0, 1.0));
}

// Returns the share of the key light that other objects let through: Attenu_Shadow of eq. (3) (formulas 4.4).
fn visible_past_things(r: Receiver) -> f32 {
    var past = 1.0;
    if GUIDED_SHADOW {
        // The last layer of the maps holds the transmittance of guided hair only.
        let last = textureNumLayers(layer_maps) - 1u;
        past = textureSampleLevel(layer_maps, map_sampler, r.place.xy / r.place.w, last, 0.0).r;
    }
    if !SOFT_SHADOW {
        return past;
    }
    let path = slanted_path(r.n_dot_l);
    let texel = width_texel(r.place);
    past *= soft_shadow(texel, r.place.z, r.place.w, path, soft_shadow_of_frame(), CENTRED);
    if HANGS {
        // Guided hair can hang anywhere; the surface at its root does not determine the path of the light.
        past *= visible_past_first(r.place, MOST_SLANTED, texel.x);
    } else if SCATTERING && r.n_dot_l < 0.0 {
        // Fur that faces away from the light is lit only where it extends beyond the outline.
        past *= mix(1.0, visible_past_first(r.place, path, texel.x), min(-AWAY_SLOPE * r.n_dot_l, 1.0));
    }
    return past;
}

// Returns the share of the key light that reaches a surface without hair of its own: the product of both factors. The
// hair maps store only the hair above the first surface. If that is a different surface, its hair does not shadow this
// one.
fn visible_on_bare(r: Receiver) -> f32 {
    var through = visible_through_hair(r);
    if !SOFT_SHADOW {
        return through;
    }
    let texel = width_texel(r.place);
    if BAKED_SHADOW {
        // Packages do not store the shadow of hair on the bare surface beside it; the map of all hair does.
        through = texel.w;
    }
    let s = soft_shadow_of_frame();
    let path = slanted_path(r.n_dot_l);
    let hidden = (r.place.z - texel.z) * s.range_m > depth_bias(r.place.w, path, s);
    return soft_shadow(texel, r.place.z, r.place.w, path, s, CENTRED) * select(through, 1.0, hidden);
}
