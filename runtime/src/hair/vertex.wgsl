//! uses light/point, light/visibility, shared/frame, shared/tile_frame, surface/place
// Vertex computations shared by all hair geometries. Only values that are linear over a triangle are computed here.
// Examples: the direction to the light, and the half vector H, in the tile frame of the direction texture.

// Values of a vertex that all hair geometries pass to their fragments.
struct HairVertex {
    position: vec4<f32>,
    light_ts: vec3<f32>,
    half_ts: vec3<f32>,
    // Base colour without the texture.
    tint: vec4<f32>,
    base_uv: vec2<f32>,
    // Bareness, wetness.
    groom: vec2<f32>,
    // Coordinates in the shadow maps.
    place: vec4<f32>,
    // Cosine between the surface normal and the direction to the eye.
    n_dot_e: f32,
    spot: Spot,
}

// Returns the values that all hair geometries pass to their fragments. `position`: world-space position of the hair
// above the surface vertex `v`.
fn hair_vertex(v: Vertex, tile: TileFrame, position: vec3<f32>) -> HairVertex {
    let light = direction_to(frame.light_ws, position);
    let eye = direction_to(frame.eye_ws, position);
    let half = half_vector(light, eye);
    var out: HairVertex;
    out.position = frame.clip_from_world * vec4(position, 1.0);
    out.light_ts = to_tile(tile, light);
    out.half_ts = to_tile(tile, half);
    out.tint = v.color * material.base_color;
    out.base_uv = v.base_uv;
    out.groom = v.groom.xy;
    out.place = map_place(position);
    out.n_dot_e = dot(tile.normal_ws, eye);
    out.spot = spot_of(v, position, tile);
    return out;
}
