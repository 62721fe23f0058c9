//! sRGB encoding of colours (IEC 61966-2-1); Rust counterpart of `srgb.wgsl`.

use glam::Vec3;

/// WGSL source of this topic.
pub const WGSL: &str = include_str!("srgb.wgsl");

/// Converts an sRGB-encoded colour to linear light, 0..=1 each.
pub fn linear_of(srgb: Vec3) -> Vec3 {
    let decode = |c: f32| if c <= 0.04045 { c / 12.92 } else { ((c.max(0.0) + 0.055) / 1.055).powf(2.4) };
    Vec3::new(decode(srgb.x), decode(srgb.y), decode(srgb.z))
}

/// Converts linear light to its sRGB encoding, 0..=1 each.
pub fn encoded(linear: Vec3) -> Vec3 {
    let encode = |c: f32| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    Vec3::new(encode(linear.x), encode(linear.y), encode(linear.z))
}
