//! Tone mapping: compression of light that a screen cannot show.

use glam::Vec3;

/// Peak value, of the brightest channel, from which light is compressed. Darker colours are unchanged.
pub const SHOULDER: f32 = 0.7;
/// Strength with which compressed colours fade to white.
pub const FADE: f32 = 0.15;

/// Returns `color` with its brightest channel compressed below 1. The compression has slope 1 at [`SHOULDER`] and
/// approaches 1 for infinite light. All channels are scaled alike, and very bright colours fade to white (Khronos PBR
/// Neutral, without its offset of dark colours).
///
/// * `color`: linear RGB, 0 or more
pub fn tone_mapped(color: Vec3) -> Vec3 {
    let peak = color.max_element();
    if peak <= SHOULDER {
        return color;
    }
    let room = 1.0 - SHOULDER;
    let shown = 1.0 - room * room / (peak + 1.0 - 2.0 * SHOULDER);
    let white = 1.0 - 1.0 / (FADE * (peak - shown) + 1.0);
    (color * (shown / peak)).lerp(Vec3::splat(shown), white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_bright_light_is_compressed() {
        let dark = Vec3::new(0.7, 0.01, 0.3);
        assert_eq!(tone_mapped(dark), dark);
        let mut before = SHOULDER;
        for step in 1..400 {
            let peak = SHOULDER * 1.05_f32.powi(step);
            let shown = tone_mapped(Vec3::new(peak, 0.5 * peak, 0.25 * peak));
            assert!(shown.x >= before && shown.x <= 1.0, "{peak}: {shown} after {before}");
            assert!(shown.x >= shown.y && shown.y >= shown.z, "{peak}: {shown}");
            before = shown.x;
        }
        let slope = (tone_mapped(Vec3::splat(SHOULDER + 1e-3)).x - SHOULDER) / 1e-3;
        assert!((slope - 1.0).abs() < 0.01, "{slope}");
    }
}
