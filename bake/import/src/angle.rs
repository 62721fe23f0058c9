//! Angles between vectors, bit-identical on every platform. glam is not: with `std` it uses the system's math library.

use glam::{DVec3, Mat2, Vec2};

/// Returns the angle between two vectors of any length, 0..=π; NaN if either has length 0.
pub fn between(a: DVec3, b: DVec3) -> f64 {
    libm::acos((a.dot(b) / (a.length_squared() * b.length_squared()).sqrt()).clamp(-1.0, 1.0))
}

/// Returns the rotation by `angle_rad` from x towards y.
pub fn rotation(angle_rad: f32) -> Mat2 {
    let (sin, cos) = libm::sincosf(angle_rad);
    Mat2::from_cols(Vec2::new(cos, sin), Vec2::new(-sin, cos))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_rotations_have_known_values() {
        assert!((between(DVec3::X * 3.0, DVec3::new(1e-9, 5.0, 0.0)) - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        assert_eq!(between(DVec3::ONE, DVec3::ONE * 7.0), 0.0);
        assert!(between(DVec3::ZERO, DVec3::X).is_nan());
        assert!((rotation(std::f32::consts::FRAC_PI_2) * Vec2::X).distance(Vec2::Y) < 1e-6);
    }
}
