//! Visibility of a distant light from a point of the tile's hair: t = s(ω.z) clamp(c₀ + c · ω, 0, 1). ω is the unit
//! vector towards the light in the tile; s is [`above_horizon`]; a texel stores c₀ and c. `FORMAT.md`, "VISI".

use glam::{Vec3, Vec4};

/// Component z of the mean direction towards lights. For ω = (0, 0, `VISIBILITY_MEAN_Z`), c₀ + c · ω equals a texel's
/// alpha, whatever the slopes c.
pub const VISIBILITY_MEAN_Z: f32 = 0.585;

/// Steps of a byte per unit of a slope, which is (byte − 128) / 64.
const STEPS: f32 = 64.0;

/// Encodes coefficients (c₀, c) in four bytes. Red, green and blue hold c, from −2 to just below 2. Alpha holds c₀ +
/// c.z [`VISIBILITY_MEAN_Z`], 0..=1.
pub fn encode_visibility(c: Vec4) -> [u8; 4] {
    let slope = |x: f32| (STEPS * x + 128.0).round().clamp(0.0, 255.0) as u8;
    let mean = (c.x + c.w * VISIBILITY_MEAN_Z).clamp(0.0, 1.0);
    [slope(c.y), slope(c.z), slope(c.w), (255.0 * mean).round() as u8]
}

/// Returns the factor s for a light whose direction has component z along the tile's normal: 1 − exp(−k z), where k is
/// `horizon`. It is 0 at and below the horizon. The lower the light, the longer its path through any hair.
pub fn above_horizon(z: f32, horizon: f32) -> f32 {
    -libm::expm1f(-horizon * z.max(0.0))
}

/// Returns the share of a light that reaches the hair at a texel, whose components are 0..=1. `towards` comes from
/// [`light_in_tile`].
pub fn visibility_towards(texel: Vec4, towards: Vec3, horizon: f32) -> f32 {
    let slopes = texel.truncate() * (255.0 / STEPS) - 128.0 / STEPS;
    (texel.w + slopes.dot(towards - Vec3::Z * VISIBILITY_MEAN_Z)).clamp(0.0, 1.0) * above_horizon(towards.z, horizon)
}

/// Converts `towards`, the direction of a light in the tile frame, to the undeformed tile, for hair that is shorter or
/// leans. This inverts the deformation of the tile into that hair.
///
/// * `share` - the vertex's fur height divided by `FurInfo::height_m`
/// * `slope` - result of [`super::lean_slope`]
pub fn light_in_tile(towards: Vec3, share: f32, slope: f32) -> Vec3 {
    let upright = Vec3::new(share * towards.x, share * (towards.y - slope * towards.z), towards.z);
    upright * upright.dot(upright).max(1e-30).sqrt().recip()
}

#[cfg(test)]
mod tests {
    use super::super::hair_direction;
    use super::*;

    #[test]
    fn visibility_texels_decode_to_the_encoded_values() {
        let c = Vec4::new(0.2, 0.5, -0.25, 0.75);
        let texel = Vec4::from(encode_visibility(c).map(|b| f32::from(b) / 255.0));
        for towards in [Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.48, 0.6, 0.64)] {
            let expected = (c.x + c.truncate().dot(Vec3::ZERO) + Vec3::new(c.y, c.z, c.w).dot(towards)).clamp(0.0, 1.0);
            assert!((visibility_towards(texel, towards, 1e3) - expected).abs() < 3e-3, "{towards}");
        }
        assert_eq!(encode_visibility(Vec4::new(9.0, -9.0, 9.0, -9.0)), [0, 255, 0, 255].map(|b: u8| b));
        // Nothing or everything is visible from all directions.
        assert_eq!(visibility_towards(Vec4::new(128.0, 128.0, 128.0, 0.0) / 255.0, Vec3::Z, 1e3), 0.0);
        assert_eq!(visibility_towards(Vec4::new(128.0, 128.0, 128.0, 255.0) / 255.0, Vec3::Z, 1e3), 1.0);
    }

    #[test]
    fn light_parallel_to_a_hair_stays_parallel_in_the_tile() {
        for (direction, share, slope) in
            [(Vec3::new(0.6, 0.0, 0.8), 0.25, 0.0), (Vec3::new(0.0, 0.6, 0.8), 1.0, 0.7), (Vec3::Z, 0.5, 1.2)]
        {
            let found = light_in_tile(hair_direction(direction, share, slope), share, slope);
            assert!(found.distance(direction) < 1e-6, "{found}, expected {direction}");
        }
        assert!(light_in_tile(Vec3::X, 0.0, 0.0).is_finite());
    }
}
