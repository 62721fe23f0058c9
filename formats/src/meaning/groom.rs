//! How much hair grows at a point of the skin and how wet it is, from the bytes of a vertex and a texel of the groom texture.

use glam::Vec2;

/// Bytes of [`crate::AttributeVertex::groom`] for a bareness and a wetness, both 0..=1.
pub fn groom_bytes(bareness: f32, wetness: f32) -> [u8; 4] {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    [byte(bareness), byte(wetness), 0, 0]
}

/// Share of the hair that grows at a vertex, and of that which is wet; 0..=1 each.
pub fn groom_of_vertex(bytes: [u8; 4]) -> Vec2 {
    let [bareness, wetness, ..] = bytes.map(|byte| f32::from(byte) / 255.0);
    Vec2::new(1.0 - bareness, wetness)
}

/// The same with a texel of the material's groom texture: growths multiply, wetness adds up to 1.
pub fn groom_with_texel(groom: Vec2, texel: Vec2) -> Vec2 {
    Vec2::new(groom.x * texel.x, (groom.y + texel.y).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_and_textures_join_in() {
        assert_eq!(groom_of_vertex([0; 4]), Vec2::X, "a vertex of version 1: all hair, none of it wet");
        assert_eq!(groom_of_vertex(groom_bytes(1.0, 1.0)), Vec2::Y);
        assert_eq!(groom_bytes(-1.0, 7.0), [0, 255, 0, 0]);
        for byte in 0..=255u8 {
            let groom = groom_of_vertex([byte, byte, 0, 0]);
            assert_eq!(groom_bytes(1.0 - groom.x, groom.y), [byte, byte, 0, 0]);
        }
        assert_eq!(groom_with_texel(Vec2::new(0.5, 0.75), Vec2::new(0.5, 0.5)), Vec2::new(0.25, 1.0));
    }
}
