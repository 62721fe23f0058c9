//! Encoding of hair directions as texels. `FORMAT.md`, "Directions".

use crate::sections::textures::TextureFormat;
use glam::Vec3;

/// Scale from texel values 0..=1 to components −1..=1: `c = (255 v − 128) / 127`, so that the byte 128 is exactly 0 and
/// upright hair (0, 0) has no rounding error. Byte 0 means the same as byte 1.
const SCALE: f32 = 255.0 / 127.0;
const OFFSET: f32 = -128.0 / 127.0;

/// Decodes a sampled texel of the direction texture to a direction in the tile frame: x along +u of the tile, y along
/// +v, z away from the surface.
///
/// * Two-component formats hold x and y; z is computed for unit length. Hair that points towards the surface is stored
///   reversed, because Yang 2006, eq. (1), lights T and −T equally. The result has unit length, also between texels.
/// * Four-component formats hold x, y and z in red, green and blue; alpha is 1. Texels are unit vectors; between
///   texels, and in smaller mip levels, the length decreases where directions disagree. The length is kept here as a
///   measure of confidence in the direction.
///
/// No input gives NaN or a vector longer than √3.
pub fn decode_direction(texel: [f32; 4], format: TextureFormat) -> Vec3 {
    let c = texel.map(|v| (v * SCALE + OFFSET).clamp(-1.0, 1.0));
    if format.components() == 2 {
        let planar = c[0] * c[0] + c[1] * c[1];
        // Filtering and rounding can push (x, y) outside the unit disc: move it back to the rim, with z = 0.
        let shrink = if planar > 1.0 { planar.sqrt().recip() } else { 1.0 };
        Vec3::new(c[0] * shrink, c[1] * shrink, (1.0 - planar).max(0.0).sqrt())
    } else {
        Vec3::new(c[0], c[1], c[2])
    }
}

/// Encodes a direction in the tile frame as four bytes; a two-component format uses the first two. Inverse of
/// [`decode_direction`] up to rounding (half a step of 1/127) and, for two components, sign.
///
/// `direction` has unit length, or less to express low confidence.
pub fn encode_direction(direction: Vec3, format: TextureFormat) -> [u8; 4] {
    let byte = |c: f32| (c.clamp(-1.0, 1.0) * 127.0 + 128.0).round() as u8;
    if format.components() == 2 {
        let d = if direction.z < 0.0 { -direction } else { direction };
        [byte(d.x), byte(d.y), 0, 255]
    } else {
        [byte(direction.x), byte(direction.y), byte(direction.z), 255]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encoded_directions_decode_within_one_step() {
        for format in [TextureFormat::Rg8Unorm, TextureFormat::Rgba8Unorm] {
            for i in 0..2000 {
                let (z, a) = (1.0 - (i as f32 + 0.5) / 1000.0, i as f32 * 2.399_963);
                let r = (1.0 - z * z).sqrt();
                let mut d = Vec3::new(r * a.cos(), r * a.sin(), z);
                let back = decode_direction(encode_direction(d, format).map(|b| f32::from(b) / 255.0), format);
                if format.components() == 2 && d.z < 0.0 {
                    d = -d;
                }
                // For directions nearly tangential to the surface, z is computed from a small difference. An error of
                // half a step in x or y then changes the direction by up to 0.11.
                let tolerance = if format.components() == 2 { 0.12 } else { 0.007 };
                assert!(d.distance(back) < tolerance, "{format:?}: {d} came back as {back}");
            }
            let up = decode_direction(encode_direction(Vec3::Z, format).map(|b| f32::from(b) / 255.0), format);
            assert!(up.distance(Vec3::Z) < 1e-6, "{format:?}: upright came back as {up}");
        }
    }
}
