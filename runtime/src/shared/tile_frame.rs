use glam::{Vec3, Vec4};

pub use pelage_formats::meaning::{
    TileFrame, any_perpendicular, grown_tangent, hair_direction, lean_offset, lean_slope, orthonormal_tangent,
    root_offset, tile_frame, to_tile,
};

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("tile_frame.wgsl");

/// Decodes a texel of the direction texture to a direction in the tile frame. `planar`: the format has two components.
///
/// Same as [`pelage_formats::decode_direction`], but without its clamps. Rounding and block compression exceed the
/// range by at most a few hundredths of the length, which the clamps of the lighting functions absorb.
pub fn decode_direction(texel: Vec4, planar: bool) -> Vec3 {
    let c = texel.truncate() * (255.0 / 127.0) - 128.0 / 127.0;
    if planar { Vec3::new(c.x, c.y, (1.0 - c.x * c.x - c.y * c.y).max(0.0).sqrt()) } else { c }
}
