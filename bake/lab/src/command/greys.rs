//! Grey values of pictures for measuring flicker.

use image::RgbaImage;

/// Returns the luma of sRGB-encoded pixels, 0..=1.
pub fn greys(picture: &RgbaImage) -> Vec<f32> {
    let luma = |p: &image::Rgba<u8>| {
        let [r, g, b, _] = p.0.map(|byte| f32::from(byte) / 255.0);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    picture.pixels().map(luma).collect()
}
