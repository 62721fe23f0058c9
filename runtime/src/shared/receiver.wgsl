// The key light on the application's own geometry: what the shadow maps say to a shader that is not pelage's. Needs layer_shadow.wgsl
// and soft_shadow.wgsl before it.

// 96 bytes. All zero where nothing throws a shadow: everything then lies outside the maps, and is lit.
struct ShadowReceiver {
    // World to the shadow maps: (u w, v w, depth, w).
    map_from_world: mat4x4<f32>,
    soft_shadow: SoftShadow,
    // 1 where the penumbra lies on both sides of the hard edge, 0 where inside it alone.
    centred: u32,
    reserved0: u32,
    reserved1: u32,
    reserved2: u32,
}

// Share of the key light that arrives at a point of the maps, 0..=1, where the shadow-width map has that texel: past things, and through
// the hair above; beyond the maps 1. place: map_from_world of the point; n_dot_l: cosine between its normal and the light.
fn light_at_place(texel: vec4<f32>, place: vec4<f32>, n_dot_l: f32, receiver: ShadowReceiver) -> f32 {
    let inside = place.w > 0.0 && all(place.xyz >= vec3(0.0)) && all(place.xyz <= vec3(place.ww, 1.0));
    let past = soft_shadow(texel, place.z, place.w, slanted_path(n_dot_l), receiver.soft_shadow, receiver.centred != 0u);
    return select(1.0, past * texel.w, inside);
}

// Share of the key light that arrives at a point in world space. width_map, receiver: of the frame; map_sampler: linear.
fn light_received(
    width_map: texture_2d<f32>,
    map_sampler: sampler,
    position_ws: vec3<f32>,
    n_dot_l: f32,
    receiver: ShadowReceiver,
) -> f32 {
    let place = receiver.map_from_world * vec4(position_ws, 1.0);
    // What is behind a point light has no place in the maps, and takes no texel from them.
    let uv = place.xy / max(place.w, 1e-6);
    return light_at_place(textureSampleLevel(width_map, map_sampler, uv, 0.0), place, n_dot_l, receiver);
}
