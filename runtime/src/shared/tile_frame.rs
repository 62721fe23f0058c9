use glam::{Vec3, Vec4};

/// The shader source.
pub const WGSL: &str = include_str!("tile_frame.wgsl");

/// The hair tile's frame at a point of the skin, three perpendicular unit vectors in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileFrame {
    /// Along +u of the tile.
    pub tangent_ws: Vec3,
    /// Along +v of the tile.
    pub bitangent_ws: Vec3,
    /// Away from the skin.
    pub normal_ws: Vec3,
}

/// Any unit vector perpendicular to the unit vector `n`.
pub fn any_perpendicular(n: Vec3) -> Vec3 {
    let axis = if n.x.abs() > 0.5 { Vec3::Y } else { Vec3::X };
    (axis - n * n.dot(axis)).normalize()
}

/// `tangent` made perpendicular to the unit `normal` (Gram–Schmidt), unit length; any perpendicular where nothing is left.
pub fn orthonormal_tangent(tangent: Vec3, normal: Vec3) -> Vec3 {
    let t = tangent - normal * normal.dot(tangent);
    let length_squared = t.dot(t);
    if length_squared <= 1e-10 * tangent.dot(tangent) || length_squared < 1e-30 {
        return any_perpendicular(normal);
    }
    t * length_squared.sqrt().recip()
}

/// The frame of a unit normal, a tangent and a handedness of ±1.
pub fn tile_frame(normal_ws: Vec3, tangent_ws: Vec3, handedness: f32) -> TileFrame {
    let t = orthonormal_tangent(tangent_ws, normal_ws);
    TileFrame { tangent_ws: t, bitangent_ws: handedness * normal_ws.cross(t), normal_ws }
}

/// Components of `v_ws` along the frame's axes.
pub fn to_tile(frame: TileFrame, v_ws: Vec3) -> Vec3 {
    Vec3::new(frame.tangent_ws.dot(v_ws), frame.bitangent_ws.dot(v_ws), frame.normal_ws.dot(v_ws))
}

/// A texel of the direction texture to a direction in the tile frame. `planar`: the format has two components.
///
/// As [`pelage_formats::decode_direction`] without its clamps, which a shader can spare: what rounding and block compression
/// overshoot, at most a few hundredths of the length, the lighting equation's own clamps absorb.
pub fn decode_direction(texel: Vec4, planar: bool) -> Vec3 {
    let c = texel.truncate() * (255.0 / 127.0) - 128.0 / 127.0;
    if planar { Vec3::new(c.x, c.y, (1.0 - c.x * c.x - c.y * c.y).max(0.0).sqrt()) } else { c }
}

/// How far a point of the hair volume lies aside in the comb direction, heights of the volume, for a lean of 0..=1 beyond that of the
/// tile's strands at a share of the volume's height.
pub fn lean_offset(lean: f32, height: f32) -> f32 {
    lean * height * height
}

/// Derivative of [`lean_offset`] by the height.
pub fn lean_slope(lean: f32, height: f32) -> f32 {
    2.0 * lean * height
}

/// A hair direction in the tile frame, of any length up to 1, under the shear by that slope along +v; its length is kept.
pub fn leaned_direction(direction: Vec3, slope: f32) -> Vec3 {
    let leaned = direction + Vec3::Y * (slope * direction.z);
    leaned * (direction.dot(direction) / leaned.dot(leaned).max(1e-30)).sqrt()
}
