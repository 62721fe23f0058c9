//! uses shared/layer_shadow, shared/soft_shadow
// Key light on the application's own geometry: lookup in the shadow maps for shaders outside pelage. Join
// layer_shadow.wgsl and soft_shadow.wgsl before it.

// Size: 96 bytes. All zero if nothing casts a shadow: every point is then outside the maps, and lit.
struct ShadowReceiver {
    // Transform from world space to the shadow maps: (u w, v w, depth, w).
    map_from_world: mat4x4<f32>,
    soft_shadow: SoftShadow,
    // 1 if the penumbra extends to both sides of the hard edge, 0 if only inwards.
    centred: u32,
    reserved0: u32,
    reserved1: u32,
    reserved2: u32,
}

// Returns the share of the key light that arrives at a point past occluders and through the hair above, 0..=1 (formulas
// 4.4); 1 outside the maps. `texel`: texel of the shadow-width map; `place`: the point transformed by map_from_world;
// `n_dot_l`: cosine between the normal at the point and the light.
fn light_at_place(texel: vec4<f32>, place: vec4<f32>, n_dot_l: f32, receiver: ShadowReceiver) -> f32 {
    let inside = place.w > 0.0 && all(place.xyz >= vec3(0.0)) && all(place.xyz <= vec3(place.ww, 1.0));
    let path = slanted_path(n_dot_l);
    let past = soft_shadow(texel, place.z, place.w, path, receiver.soft_shadow, receiver.centred != 0u);
    return select(1.0, past * texel.w, inside);
}

// Returns the share of the key light that arrives at a world-space point. `width_map` and `receiver` come from the
// frame; `map_sampler` is linear.
fn light_received(
    width_map: texture_2d<f32>,
    map_sampler: sampler,
    position_ws: vec3<f32>,
    n_dot_l: f32,
    receiver: ShadowReceiver,
) -> f32 {
    let place = receiver.map_from_world * vec4(position_ws, 1.0);
    // Points behind a point light are outside the maps, so the clamp serves only to avoid a division by zero.
    let uv = place.xy / max(place.w, 1e-6);
    return light_at_place(textureSampleLevel(width_map, map_sampler, uv, 0.0), place, n_dot_l, receiver);
}
