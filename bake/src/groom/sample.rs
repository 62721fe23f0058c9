//! Reading images at a point.

use crate::mesh::Image;
use glam::{Vec2, Vec4};

/// The image at `uv`, bilinear, as the runtime's sampler reads it: (0, 0) is the upper left corner of the image, which repeats.
/// RGBA, 0..=255 for 0..=1; zero for an image without texels.
pub(super) fn bilinear(image: &Image, uv: Vec2) -> Vec4 {
    let size = Vec2::new(image.width as f32, image.height as f32);
    // A float's whole part is lost long before an index overflows.
    let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
    let at = (uv - uv.floor()) * size - 0.5;
    let corner = at.floor();
    let f = at - corner;
    let index = |i: f32, n: u32| (i as i64).rem_euclid(i64::from(n.max(1)));
    let texel = |dx: f32, dy: f32| {
        let (x, y) = (index(corner.x + dx, image.width), index(corner.y + dy, image.height));
        let at = 4 * (y as usize * image.width as usize + x as usize);
        let Some(texel) = image.rgba.get(at..at + 4) else { return Vec4::ZERO };
        Vec4::from_slice(&[0, 1, 2, 3].map(|c| f32::from(texel[c]) / 255.0))
    };
    let row = |dy: f32| texel(0.0, dy).lerp(texel(1.0, dy), f.x);
    row(0.0).lerp(row(1.0), f.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_lie_at_their_centres_and_the_image_repeats() {
        let image = Image { width: 2, height: 1, rgba: vec![0, 0, 0, 255, 255, 255, 255, 255] };
        for (u, expected) in [(0.25, 0.0), (0.75, 1.0), (0.5, 0.5), (0.0, 0.5), (1.0, 0.5), (1.25, 0.0)] {
            assert_eq!(bilinear(&image, Vec2::new(u, 0.5)).x, expected, "{u}");
        }
        assert_eq!(bilinear(&image, Vec2::splat(f32::NAN)).w, 1.0);
        let none = Image { width: 0, height: 0, rgba: Vec::new() };
        assert_eq!(bilinear(&none, Vec2::ZERO), Vec4::ZERO);
    }
}
