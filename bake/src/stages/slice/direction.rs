//! Averaging of hair directions.
//!
//! A direction is the unit tangent of a strand in the tile frame: x along u, y along v, z away from the mesh surface.
//! Kajiya–Kay lighting depends on (T·L)² only, so T and −T are equivalent, and the one with z ≥ 0 is averaged.
//!
//! The mean of several unit vectors is shorter than one. Its length is the confidence: 1 if all directions agree.
//! Opposing hairs cancel out, and normalising the remainder would give noise or NaN. So if `|mean|² < 1e-8`, the
//! isotropic direction (0, 0, 1) is used. Two-component formats store the direction, four-component ones the mean with
//! its length ([`pelage_formats::encode_direction`]).

use glam::Vec3;
use pelage_formats::{TextureFormat, encode_direction};

/// Squared length of a mean below which its direction is undefined.
pub const MIN_LENGTH_SQUARED: f32 = 1e-8;

/// Returns `t` or `-t`, whichever does not point into the surface.
pub fn upward(t: Vec3) -> Vec3 {
    if t.z < 0.0 { -t } else { t }
}

/// Returns the unit direction and the confidence (0..=1) for a mean of unit vectors.
pub fn resolve(mean: Vec3) -> (Vec3, f32) {
    let length_squared = mean.length_squared();
    // The comparison is written so that NaN also uses the fallback.
    if length_squared >= MIN_LENGTH_SQUARED {
        let length = length_squared.sqrt();
        (mean / length, length.min(1.0))
    } else {
        (Vec3::Z, 0.0)
    }
}

/// Encodes a mean of unit vectors as four bytes for a texture of `format`.
pub fn encode_mean(mean: Vec3, format: TextureFormat) -> [u8; 4] {
    let (unit, confidence) = resolve(mean);
    encode_direction(if format.components() == 2 { unit } else { unit * confidence }, format)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_nan_mean_directions_are_isotropic() {
        for mean in [Vec3::ZERO, Vec3::splat(1e-6), Vec3::NAN, Vec3::new(0.0, f32::NAN, 1.0)] {
            assert_eq!(resolve(mean), (Vec3::Z, 0.0));
            assert_eq!(encode_mean(mean, TextureFormat::Rg8Unorm)[..2], [128, 128]);
            assert_eq!(encode_mean(mean, TextureFormat::Rgba8Unorm)[..3], [128, 128, 128]);
        }
        assert_eq!(resolve(Vec3::new(0.0, 0.0, 0.4)), (Vec3::Z, 0.4));
    }

    #[test]
    fn length_is_kept_by_four_components_only() {
        let mean = Vec3::new(0.25, 0.0, 0.0);
        assert_eq!(encode_mean(mean, TextureFormat::Bc5Unorm)[..2], [255, 128]);
        assert_eq!(encode_mean(mean, TextureFormat::Rgba8Unorm)[..3], [160, 128, 128]);
        assert_eq!(upward(-Vec3::Z), Vec3::Z);
    }
}
