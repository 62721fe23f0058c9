use glam::{Vec3, Vec4};

pub use pelage_formats::meaning::{TileFrame, any_perpendicular, orthonormal_tangent, tile_frame, to_tile};
pub use pelage_formats::meaning::{grown_tangent, hair_direction, lean_offset, lean_slope, root_aside};

/// The shader source.
pub const WGSL: &str = include_str!("tile_frame.wgsl");

/// A texel of the direction texture to a direction in the tile frame. `planar`: the format has two components.
///
/// As [`pelage_formats::decode_direction`] without its clamps, which a shader can spare: what rounding and block compression
/// overshoot, at most a few hundredths of the length, the lighting equation's own clamps absorb.
pub fn decode_direction(texel: Vec4, planar: bool) -> Vec3 {
    let c = texel.truncate() * (255.0 / 127.0) - 128.0 / 127.0;
    if planar { Vec3::new(c.x, c.y, (1.0 - c.x * c.x - c.y * c.y).max(0.0).sqrt()) } else { c }
}
