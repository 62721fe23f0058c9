//! Images in memory, in linear light: output of renderers and input of comparisons.

use image::{EncodableLayout, ImageBuffer, ImageFormat, PixelWithColorType, RgbaImage};
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear, srgb_value_to_linear};
use pelage_import::BakeError;
use pelage_import::image_file::bounded_reader;

/// Image in linear light with coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Texels: `width * height`, row-major from the top. The fourth component is the coverage, 0..=1. Red, green and
    /// blue are linear, with sRGB primaries, and premultiplied by the coverage.
    pub pixels: Vec<[f32; 4]>,
}

impl From<&RgbaImage> for Picture {
    /// Converts from sRGB-encoded bytes with straight alpha, the PNG convention.
    fn from(image: &RgbaImage) -> Self {
        let texel = |p: &image::Rgba<u8>| {
            let [r, g, b, a] = p.0;
            premultiplied([srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b)], f32::from(a) / 255.0)
        };
        Self { width: image.width(), height: image.height(), pixels: image.pixels().map(texel).collect() }
    }
}

fn premultiplied(rgb: [f32; 3], alpha: f32) -> [f32; 4] {
    let [r, g, b] = rgb.map(|c| c * alpha);
    [r, g, b, alpha]
}

impl Picture {
    /// Decodes a PNG or EXR. A PNG has 8 or 16 bits and is sRGB-encoded with straight alpha; its gAMA chunk is ignored.
    /// An EXR is linear and premultiplied, as is its convention.
    ///
    /// Fails with the location in the file, and what was found and expected.
    pub fn decode(bytes: &[u8]) -> Result<Self, (String, String)> {
        let at_start = |reason: String| ("byte 0".to_owned(), reason);
        let format = match image::guess_format(bytes) {
            Ok(format @ (ImageFormat::Png | ImageFormat::OpenExr)) => format,
            Ok(other) => return Err(at_start(format!("is {other:?}, expected a PNG or EXR picture"))),
            Err(_) => return Err(at_start("expected a PNG or EXR picture".into())),
        };
        let (reader, width, height) = bounded_reader(bytes, format).map_err(at_start)?;
        let decoded = reader.decode().map_err(|e| at_start(format!("cannot be decoded: {e}")))?;
        let eight_bits = decoded.color().bytes_per_pixel() == decoded.color().channel_count();
        let pixels: Vec<[f32; 4]> = if format == ImageFormat::OpenExr {
            decoded.into_rgba32f().pixels().map(|p| p.0).collect()
        } else if eight_bits {
            return Ok(Self::from(&decoded.into_rgba8()));
        } else {
            let texel = |p: &image::Rgba<u16>| {
                let [r, g, b, a] = p.0.map(|x| f32::from(x) / 65535.0);
                premultiplied([r, g, b].map(srgb_value_to_linear), a)
            };
            decoded.into_rgba16().pixels().map(texel).collect()
        };
        if let Some(index) = pixels.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            let (x, y) = (index as u32 % width, index as u32 / width);
            return Err((format!("pixel {x},{y}"), format!("found {:?}, expected finite numbers", pixels[index])));
        }
        Ok(Self { width, height, pixels })
    }

    /// Composites the image over the sRGB-encoded background `over`. Returns `3 * width * height` sRGB-encoded bytes,
    /// row-major; light above 1 is clamped.
    pub fn composite_over(&self, over: [u8; 3]) -> Vec<u8> {
        let over = over.map(srgb_to_linear);
        let texel = |p: &[f32; 4]| [0, 1, 2].map(|i| linear_to_srgb(p[i] + (1.0 - p[3]) * over[i]));
        self.pixels.iter().flat_map(texel).collect()
    }
}

/// Encodes an image as PNG.
///
/// Fails with [`BakeError::Internal`] if the encoder fails.
pub fn encode_png<P>(pixels: &ImageBuffer<P, Vec<P::Subpixel>>) -> Result<Vec<u8>, BakeError>
where
    P: PixelWithColorType,
    [P::Subpixel]: EncodableLayout,
{
    let mut png = std::io::Cursor::new(Vec::new());
    let written = pixels.write_to(&mut png, ImageFormat::Png);
    written.map_err(|error| BakeError::Internal(format!("encoding PNG: {error}")))?;
    Ok(png.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, Rgba, Rgba32FImage};
    use std::io::Cursor;

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        assert!(image.write_to(&mut bytes, format).is_ok());
        bytes.into_inner()
    }

    #[test]
    fn every_format_decodes_to_linear_premultiplied_pixels() -> Result<(), (String, String)> {
        // Byte 188 encodes half the light, which an alpha of 128 halves again.
        let eight = RgbaImage::from_pixel(3, 2, Rgba([188, 0, 255, 128]));
        let alpha = 128.0 / 255.0;
        let expected = [0.5 * alpha, 0.0, alpha, alpha];
        let sixteen = DynamicImage::ImageRgba8(eight.clone()).into_rgba16();
        let float = Rgba32FImage::from_pixel(3, 2, Rgba(expected));
        for (name, image, format) in [
            ("8 bits", DynamicImage::ImageRgba8(eight.clone()), ImageFormat::Png),
            ("16 bits", DynamicImage::ImageRgba16(sixteen), ImageFormat::Png),
            ("floats", DynamicImage::ImageRgba32F(float), ImageFormat::OpenExr),
        ] {
            let picture = Picture::decode(&encoded(&image, format))?;
            assert_eq!((picture.width, picture.height, picture.pixels.len()), (3, 2, 6), "{name}");
            for (found, expected) in picture.pixels[5].iter().zip(expected) {
                assert!((found - expected).abs() < 2e-3, "{name}: {:?}", picture.pixels[5]);
            }
        }
        // An image without alpha has full coverage; grey has equal red, green and blue.
        let grey = DynamicImage::ImageLuma8(image::GrayImage::from_pixel(1, 1, image::Luma([255])));
        assert_eq!(Picture::decode(&encoded(&grey, ImageFormat::Png))?.pixels, [[1.0; 4]]);
        Ok(())
    }

    #[test]
    fn background_is_blended_by_alpha() {
        let pixels = vec![[0.0; 4], [0.25, 0.25, 0.25, 0.5], [3.0, 0.0, 1.0, 1.0]];
        let picture = Picture { width: 3, height: 1, pixels };
        // Half of the white background plus the image's own quarter is three quarters of the light, encoded as 225.
        assert_eq!(picture.composite_over([255; 3]), [255, 255, 255, 225, 225, 225, 255, 0, 255]);
    }

    #[test]
    fn invalid_pictures_are_refused() {
        let jpeg = encoded(&DynamicImage::new_rgb8(2, 2), ImageFormat::Jpeg);
        let mut cut = encoded(&DynamicImage::new_rgb8(64, 64), ImageFormat::Png);
        cut.truncate(60);
        let nan = Rgba32FImage::from_pixel(2, 1, Rgba([0.0, f32::NAN, 0.0, 1.0]));
        let nan = encoded(&DynamicImage::ImageRgba32F(nan), ImageFormat::OpenExr);
        for (bytes, place, words) in [
            (&b"PELAGE"[..], "byte 0", "expected a PNG or EXR"),
            (&jpeg, "byte 0", "is Jpeg"),
            (&cut, "byte 0", "cannot be decoded"),
            (&nan, "pixel 0,0", "expected finite"),
        ] {
            let error = Picture::decode(bytes).map(|_| ());
            assert!(error.as_ref().is_err_and(|(p, r)| p == place && r.contains(words)), "{error:?}");
        }
    }
}
