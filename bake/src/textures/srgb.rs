//! The sRGB transfer function (IEC 61966-2-1), byte for byte the same on every machine.
//!
//! `powf` differs in the last bit between mathematics libraries, which could move a byte; so both directions go through one table
//! of 256 linear values, computed with the `libm` crate.

use std::sync::LazyLock;

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) };
        linear as f32
    })
});

/// Linear light, 0..=1, of an sRGB byte.
pub fn srgb_to_linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// The sRGB byte whose linear light is nearest to `linear`; values outside 0..=1 are clamped, NaN gives 0.
pub fn linear_to_srgb(linear: f32) -> u8 {
    let table = &*LINEAR;
    let above = table.partition_point(|value| *value < linear).min(255);
    if above == 0 || linear.is_nan() {
        return 0;
    }
    let below = above - 1;
    // Nearest in linear light is what a filter that sums linear light wants.
    if linear - table[below] < table[above] - linear { below as u8 } else { above as u8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_and_ends_clamp() {
        for byte in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(byte)), byte);
        }
        assert_eq!((linear_to_srgb(-1.0), linear_to_srgb(2.0), linear_to_srgb(f32::NAN)), (0, 255, 0));
        // IEC 61966-2-1: 21.586 % of the light is byte 128.
        assert_eq!(linear_to_srgb(0.21586), 128);
    }
}
