//! Reading of PNG and JPEG images, with limits on texels and memory.

use crate::mesh::Image;
use pelage_formats::Limits;
use std::io::Cursor;

/// Maximum number of texels of all images of a model together: 1 GiB when decoded. This allows one image of 16 384²
/// texels or sixteen of 4096². A limit is needed because a PNG of a few kilobytes can claim as much.
pub const MAX_TEXELS: u64 = 1 << 28;

/// Decodes a PNG or JPEG of at most `texels_left` texels. The error text lacks a subject: the caller puts the image's
/// name before it.
pub fn decode_image(bytes: &[u8], texels_left: u64) -> Result<Image, String> {
    let png_or_jpeg = match image::guess_format(bytes) {
        Ok(format @ (image::ImageFormat::Png | image::ImageFormat::Jpeg)) => Ok(format),
        Ok(other) => Err(format!("{other:?}")),
        Err(_) if bytes.starts_with(b"\xabKTX") => Err("KTX".to_owned()),
        Err(_) => {
            let head: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
            Err(format!("{} bytes that begin with [{}]", bytes.len(), head.join(" ")))
        }
    };
    let format = png_or_jpeg.map_err(|found| format!("is {found}, expected PNG or JPEG"))?;
    let (pixels, width, height) = bounded_reader(bytes, format)?;
    if u64::from(width) * u64::from(height) > texels_left {
        return Err(format!(
            "is {width} x {height} texels and makes the model's images larger than {MAX_TEXELS} texels \
             in total"
        ));
    }
    let rgba = pixels.decode().map_err(broken)?.into_rgba8().into_raw();
    Ok(Image { width, height, rgba })
}

fn broken(error: image::ImageError) -> String {
    format!("cannot be decoded: {error}")
}

type Reader<'a> = image::ImageReader<Cursor<&'a [u8]>>;

/// Returns a decoder with limited memory, and the image's width and height. The error text lacks a subject, as in
/// [`decode_image`].
pub fn bounded_reader(bytes: &[u8], format: image::ImageFormat) -> Result<(Reader<'_>, u32, u32), String> {
    let side = Limits::default().texture_size;
    let reader = || image::ImageReader::with_format(Cursor::new(bytes), format);
    // Read only the header, without the decoder's own limits: errors from these would be less precise than those below.
    let mut header = reader();
    header.no_limits();
    let (width, height) = header.into_dimensions().map_err(broken)?;
    if width == 0 || height == 0 || width > side || height > side {
        return Err(format!("is {width} x {height} texels, expected 1..={side} per side"));
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(side);
    limits.max_image_height = Some(side);
    // An image with 16 bits per channel needs twice the memory of the result, which has 8 bits per channel.
    limits.max_alloc = Some(8 * MAX_TEXELS);
    let mut pixels = reader();
    pixels.limits(limits);
    Ok((pixels, width, height))
}
