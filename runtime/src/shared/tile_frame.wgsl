// The hair tile's frame on the skin (tangent along +u, bitangent along +v, normal) and hair directions in it. `_ts` vectors
// are in this frame, `_ws` vectors in world space.

struct TileFrame {
    tangent_ws: vec3<f32>,
    bitangent_ws: vec3<f32>,
    normal_ws: vec3<f32>,
}

// Any unit vector perpendicular to the unit vector n.
fn any_perpendicular(n: vec3<f32>) -> vec3<f32> {
    let axis = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(n.x) > 0.5);
    return normalize(axis - n * dot(n, axis));
}

// The tangent made perpendicular to the unit normal (Gram-Schmidt), unit length; any perpendicular where nothing is left.
fn orthonormal_tangent(tangent: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    let t = tangent - normal * dot(normal, tangent);
    let length_squared = dot(t, t);
    // Relative to what came in: rounding noise of a tangent along the normal is not a direction.
    if length_squared <= 1e-10 * dot(tangent, tangent) || length_squared < 1e-30 {
        return any_perpendicular(normal);
    }
    return t * inverseSqrt(length_squared);
}

// normal_ws has unit length; handedness is +1 or -1.
fn tile_frame(normal_ws: vec3<f32>, tangent_ws: vec3<f32>, handedness: f32) -> TileFrame {
    let t = orthonormal_tangent(tangent_ws, normal_ws);
    return TileFrame(t, handedness * cross(normal_ws, t), normal_ws);
}

fn to_tile(frame: TileFrame, v_ws: vec3<f32>) -> vec3<f32> {
    return vec3(dot(frame.tangent_ws, v_ws), dot(frame.bitangent_ws, v_ws), dot(frame.normal_ws, v_ws));
}

// A texel of the direction texture to a direction in the tile frame, as FORMAT.md, "Directions". planar: the format has two
// components. Without that text's clamps: what rounding and block compression overshoot, at most a few hundredths of the length,
// the lighting equation's own clamps absorb.
fn decode_direction(texel: vec4<f32>, planar: bool) -> vec3<f32> {
    let c = texel.xyz * (255.0 / 127.0) - 128.0 / 127.0;
    if planar {
        return vec3(c.xy, sqrt(max(1.0 - dot(c.xy, c.xy), 0.0)));
    }
    return c;
}

// The way from the root of hair to where it is seen. aside: of hair that points along the normal, and how much farther for each unit that its
// direction, of unit length, points aside.
fn root_aside(aside: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    return aside.xy + aside.z * direction.xy;
}

// Lean of a vertex beyond what the tile's strands do, 0..=1: how far a point of the hair volume at a share of its height lies
// aside, in the comb direction, heights of the volume. Roots stay where they are.
fn lean_offset(lean: f32, height: f32) -> f32 {
    return lean * height * height;
}

// Derivative of lean_offset by the height.
fn lean_slope(lean: f32, height: f32) -> f32 {
    return 2.0 * lean * height;
}

// What becomes of a piece of the tile's hair where hair is `share` as long as the tile's and leans by that slope along +v: it rises less and
// wanders as far, so it lies flatter.
fn grown_tangent(direction: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let rises = share * direction.z;
    return vec3(direction.x, direction.y + slope * rises, rises);
}

// Its direction. The length of the tile's, up to 1, is the direction's confidence and is kept.
fn hair_direction(direction: vec3<f32>, share: f32, slope: f32) -> vec3<f32> {
    let grown = grown_tangent(direction, share, slope);
    return grown * sqrt(dot(direction, direction) / max(dot(grown, grown), 1e-30));
}
