//! Sampling of images.

use glam::{Vec2, Vec4};
use pelage_formats::meaning::srgb_to_linear;
use pelage_import::mesh::Image;

/// Continuation of an image beyond its border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// Repeats the image.
    Repeat,
    /// Extends the outermost texels.
    Clamp,
}

/// Encoding of an image's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// All channels linear: 0..=255 maps to 0..=1.
    Linear,
    /// Colour is sRGB-encoded, alpha is linear.
    Srgb,
}

/// Returns a bilinear sample of the image at `uv`, computed like the runtime's sampler: (0, 0) is the upper left corner
/// of the image. The result is RGBA with linear colour, black for an image without texels.
pub(crate) fn bilinear(image: &Image, uv: Vec2, wrap: Wrap, encoding: Encoding) -> Vec4 {
    let size = Vec2::new(image.width as f32, image.height as f32);
    // Finite coordinates need no check for overflow. A float loses its fractional part long before the index overflows.
    let uv = if uv.is_finite() { uv } else { Vec2::ZERO };
    let uv = if wrap == Wrap::Repeat { uv - uv.floor() } else { uv.clamp(Vec2::ZERO, Vec2::ONE) };
    let at = uv * size - 0.5;
    let corner = at.floor();
    let f = at - corner;
    let index = |i: f32, n: u32| {
        let (i, n) = (i as i64, i64::from(n.max(1)));
        if wrap == Wrap::Repeat { i.rem_euclid(n) } else { i.clamp(0, n - 1) }
    };
    let texel = |dx: f32, dy: f32| {
        let (x, y) = (index(corner.x + dx, image.width), index(corner.y + dy, image.height));
        let at = 4 * (y as usize * image.width as usize + x as usize);
        let Some(&[r, g, b, a]) = image.rgba.get(at..at + 4) else { return Vec4::ZERO };
        let share = |byte: u8| f32::from(byte) / 255.0;
        match encoding {
            Encoding::Linear => Vec4::from([r, g, b, a].map(share)),
            Encoding::Srgb => Vec4::from([srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), share(a)]),
        }
    };
    let row = |dy: f32| texel(0.0, dy).lerp(texel(1.0, dy), f.x);
    row(0.0).lerp(row(1.0), f.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texel_centres_and_border_modes_are_respected() {
        let image = Image { width: 2, height: 1, rgba: vec![0, 0, 0, 255, 255, 255, 255, 255] };
        let red = |u: f32, wrap| bilinear(&image, Vec2::new(u, 0.5), wrap, Encoding::Linear).x;
        for (u, repeated, clamped) in
            [(0.25, 0.0, 0.0), (0.75, 1.0, 1.0), (0.5, 0.5, 0.5), (0.0, 0.5, 0.0), (1.0, 0.5, 1.0), (1.25, 0.0, 1.0)]
        {
            assert_eq!((red(u, Wrap::Repeat), red(u, Wrap::Clamp)), (repeated, clamped), "{u}");
        }
        assert!((bilinear(&image, Vec2::splat(0.5), Wrap::Clamp, Encoding::Srgb).x - 0.5).abs() < 1e-6);
        assert_eq!(bilinear(&image, Vec2::splat(f32::NAN), Wrap::Repeat, Encoding::Linear).w, 1.0);
        let none = Image { width: 0, height: 0, rgba: Vec::new() };
        assert_eq!(bilinear(&none, Vec2::ZERO, Wrap::Repeat, Encoding::Linear), Vec4::ZERO);
    }
}
