// Frame of the hair tile on the mesh surface (tangent along +u, bitangent along +v, normal), and hair directions in it.
// `_ts` vectors are in this frame, `_ws` vectors in world space.

struct TileFrame {
    tangent_ws: vec3<f32>,
    bitangent_ws: vec3<f32>,
    normal_ws: vec3<f32>,
}

// Returns an arbitrary unit vector perpendicular to the unit vector n.
fn any_perpendicular(n: vec3<f32>) -> vec3<f32> {
    let axis = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(n.x) > 0.5);
    return normalize(axis - n * dot(n, axis));
}

// Returns a unit tangent perpendicular to the unit normal (Gram-Schmidt; formulas 2.4); an arbitrary perpendicular if
// the tangent is along the normal.
fn orthonormal_tangent(tangent: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let t = tangent - normal * dot(normal, tangent);
    let length_squared = dot(t, t);
    // The threshold is relative to the input length, because the rounding error of a tangent along the normal is not a
    // direction.
    if length_squared <= 1e-10 * dot(tangent, tangent) || length_squared < 1e-30 {
        return any_perpendicular(normal);
    }
    return t * inverseSqrt(length_squared);
}

// Returns the tile frame (formulas 2.4). `normal_ws` has unit length; `handedness` is +1 or -1.
fn tile_frame(normal_ws: vec3<f32>, tangent_ws: vec3<f32>, handedness: f32) -> TileFrame {
    let t = orthonormal_tangent(tangent_ws, normal_ws);
    return TileFrame(t, handedness * cross(normal_ws, t), normal_ws);
}

// Transforms a world-space vector to the tile frame.
fn to_tile(frame: TileFrame, v_ws: vec3<f32>) -> vec3<f32> {
    return vec3(dot(frame.tangent_ws, v_ws), dot(frame.bitangent_ws, v_ws), dot(frame.normal_ws, v_ws));
}

// Decodes a texel of the direction texture to a direction in the tile frame (formulas 1.3), as in FORMAT.md,
// "Directions", but without the clamps described there. `planar`: the format has two components. Rounding and block
// compression exceed the range by at most a few hundredths of the length, which the clamps of the lighting functions
// absorb.
fn decode_direction(texel: vec4<f32>, planar: bool) -> vec3<f32> {
    let c = texel.xyz * (255.0 / 127.0) - 128.0 / 127.0;
    if planar {
        return vec3(c.xy, sqrt(max(1.0 - dot(c.xy, c.xy), 0.0)));
    }
    return c;
}

// Returns the sideways offset of visible hair from its root. `direction` has unit length.
// * aside.xy: offset of hair that points along the normal
// * aside.z: additional offset per unit of the hair's sideways direction
fn root_aside(aside: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    return aside.xy + aside.z * direction.xy;
}

// Returns the sideways offset of a point of the hair volume, along the comb direction, relative to the height of the
// volume (formulas 2.5). `lean`: lean of the vertex beyond that of the tile's strands, 0..=1; `height`: height relative
// to that of the volume. Roots do not move.
fn lean_offset(lean: f32, height: f32) -> f32 {
    return lean * height * height;
}

// Returns the derivative of lean_offset with respect to height: sigma of formulas 2.5.
fn lean_slope(lean: f32, height: f32) -> f32 {
    return 2.0 * lean * height;
}

// Returns the tangent of the tile's hair, adjusted to hair whose length is `share` of the tile's and whose lean adds
// `slope` along +v: T' of formulas 2.5. Shorter hair rises less over the same sideways distance, so it is flatter.
fn grown_tangent(direction: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let rises = share * direction.z;
    return vec3(direction.x, direction.y + slope * rises, rises);
}

// Returns the direction of grown_tangent: d' of formulas 2.5. The length of the tile's direction, at most 1, is a
// confidence and is preserved.
fn hair_direction(direction: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let grown = grown_tangent(direction, share, slope);
    return grown * sqrt(dot(direction, direction) / max(dot(grown, grown), 1e-30));
}
