//! Amount and wetness of hair at a surface point, from the bytes of a vertex and a texel of the groom texture.

use glam::Vec2;

/// Returns the bytes of [`crate::AttributeVertex::groom`] for a bareness and a wetness, both 0..=1.
pub fn groom_bytes(bareness: f32, wetness: f32) -> [u8; 4] {
    let byte = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u8;
    [byte(bareness), byte(wetness), 0, 0]
}

/// Returns the share of the hair that grows at a vertex, and its wetness; 0..=1 each.
pub fn groom_of_vertex(bytes: [u8; 4]) -> Vec2 {
    let [bareness, wetness, ..] = bytes.map(|byte| f32::from(byte) / 255.0);
    Vec2::new(1.0 - bareness, wetness)
}

/// Combines the values of [`groom_of_vertex`] with a texel of the material's groom texture. The shares of hair are
/// multiplied; the wetnesses are added, up to 1.
pub fn groom_with_texel(groom: Vec2, texel: Vec2) -> Vec2 {
    Vec2::new(groom.x * texel.x, (groom.y + texel.y).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groom_bytes_survive_a_round_trip_and_combine_with_texels() {
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
