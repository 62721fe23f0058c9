//! Normals by which bare surface is lit, relative to the normals along which hair stands. They differ at hard edges.

use glam::{DVec2, Vec2, Vec3};

/// Scale from stored numbers to components −1..=1.
const SCALE: f32 = 32_767.0;

/// Encodes the normal of bare surface for a package: its components along u and v of the tile, as snorm.
///
/// `normal_ts` has unit length and components along u and v of the tile and along the normal of the hair. A normal more
/// than 90° from that of the hair is moved to 90°.
pub fn encode_bare_normal(normal_ts: Vec3) -> [i16; 2] {
    // A unit vector of f32 may be longer than 1 by more than the rounding below removes.
    let aside: DVec2 = normal_ts.truncate().as_dvec2();
    let aside = if normal_ts.z < 0.0 { aside.normalize_or_zero() } else { aside.clamp_length_max(1.0) };
    // Round towards 0, so that the stored vector is never longer than 1.
    (aside * f64::from(SCALE)).to_array().map(|x| x as i16)
}

/// Decodes the normal of bare surface: components along u and v of the tile and along the normal of the hair. The
/// length is 1; (0, 0) is the normal of the hair.
pub fn decode_bare_normal(stored: [i16; 2]) -> Vec3 {
    let aside = Vec2::from(stored.map(f32::from)) / SCALE;
    aside.extend((1.0 - aside.length_squared()).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bare_normals_survive_encoding_within_a_step() {
        assert_eq!(decode_bare_normal([0, 0]), Vec3::Z);
        assert_eq!(encode_bare_normal(Vec3::X), [32_767, 0]);
        // In f32 these are 1 along v, and yet longer than 1.
        for i in 1..200 {
            let [u, v] = encode_bare_normal(Vec3::new(-1e-6 * i as f32, 1.0, 0.0)).map(i32::from);
            assert!(u * u + v * v <= 32_767 * 32_767, "{u} {v}");
        }
        for i in 0..500 {
            let (z, turn) = ((i as f32 + 0.5) / 500.0, i as f32 * 2.399_963);
            let normal = (Vec2::from_angle(turn) * (1.0 - z * z).sqrt()).extend(z);
            let stored = encode_bare_normal(normal);
            let [u, v] = stored.map(i32::from);
            assert!(u * u + v * v <= 32_767 * 32_767, "{normal}");
            let back = decode_bare_normal(stored);
            assert!(back.distance(normal) < 5e-5 / z.max(5e-3), "{normal} became {back}");
        }
        let below = decode_bare_normal(encode_bare_normal(Vec3::new(0.6, 0.0, -0.8)));
        assert!(below.distance(Vec3::X) < 0.01, "{below}");
    }
}
