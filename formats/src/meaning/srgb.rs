//! sRGB transfer function (IEC 61966-2-1), identical to the byte on every machine.
//!
//! `powf` differs in the last bit between mathematics libraries, which could change a byte. So both directions use one
//! table of 256 linear values, computed with the `libm` crate.

use glam::DVec3;
use std::sync::LazyLock;

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|byte| decode(byte as f64 / 255.0) as f32));

/// Byte at which the search for the byte of a linear value starts, for each interval of 0..=1. The table saves time,
/// because slicing encodes some 10⁸ values.
static START: LazyLock<[u8; INTERVALS + 1]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let x = i as f32 / INTERVALS as f32;
        LINEAR.partition_point(|value| *value < x).saturating_sub(1) as u8
    })
});

const INTERVALS: usize = 4096;

fn decode(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Returns the linear light, 0..=1, of an encoded value 0..=1.
pub fn srgb_value_to_linear(encoded: f32) -> f32 {
    decode(f64::from(encoded)) as f32
}

/// Returns the linear light, 0..=1, of an sRGB byte.
pub fn srgb_to_linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

/// Returns the sRGB byte whose linear light is nearest to `linear`; values outside 0..=1 are clamped, NaN gives 0.
pub fn linear_to_srgb(linear: f32) -> u8 {
    let (table, linear) = (&*LINEAR, linear.clamp(0.0, 1.0));
    let mut below = usize::from(START[(linear * INTERVALS as f32) as usize]);
    while below < 254 && table[below + 1] < linear {
        below += 1;
    }
    // Choose the byte that is nearest in linear light, because filters sum linear light.
    let up = linear - table[below] >= table[below + 1] - linear;
    (below + usize::from(up)) as u8
}

/// Returns the luminance of a linear colour, or the luma of an encoded one (ITU-R BT.709).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_bytes_survive_a_round_trip_and_out_of_range_values_clamp() {
        for byte in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(byte)), byte);
        }
        assert_eq!((linear_to_srgb(-1.0), linear_to_srgb(2.0), linear_to_srgb(f32::NAN)), (0, 255, 0));
        for i in 0..=100_000 {
            let x = i as f32 / 100_000.0;
            let distance = |byte: u8| (srgb_to_linear(byte) - x).abs();
            let byte = linear_to_srgb(x);
            let nearer =
                [byte.saturating_sub(1), byte.saturating_add(1)].into_iter().any(|b| distance(b) < distance(byte));
            assert!(!nearer, "{x} became {byte}");
        }
        // IEC 61966-2-1: 21.586 % of the light is byte 128.
        assert_eq!(linear_to_srgb(0.21586), 128);
    }
}
