//! Reading of PNG, JPEG and WebP images, with limits on texels and memory.

use crate::mesh::Image;
use pelage_formats::Limits;
use std::io::Cursor;

/// Maximum number of texels of all images of a model together: 1 GiB when decoded. This allows one image of 16 384²
/// texels or sixteen of 4096². A limit is needed because a PNG of a few kilobytes can claim as much.
pub const MAX_TEXELS: u64 = 1 << 28;

/// Maximum size of all image files of a model together, bytes. A limit is needed because many images can name the same
/// large file.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

/// Decoded images of a model, and what is left of the limits that they share.
#[derive(Debug)]
pub(crate) struct ImageList {
    pub images: Vec<Image>,
    texels_left: u64,
    bytes_left: u64,
}

impl Default for ImageList {
    fn default() -> Self {
        Self { images: Vec::new(), texels_left: MAX_TEXELS, bytes_left: MAX_IMAGE_BYTES }
    }
}

impl ImageList {
    /// Checks that a limit is not reached yet; to be called before an image is opened. The error text lacks a subject,
    /// as in [`decode_image`].
    pub fn check_limits(&self) -> Result<(), String> {
        if self.texels_left.min(self.bytes_left) > 0 {
            return Ok(());
        }
        Err(format!(
            "is not opened, because the model's images have reached a limit: {MAX_TEXELS} texels or \
             {MAX_IMAGE_BYTES} bytes in total"
        ))
    }

    /// Decodes an image and returns its index. An image that cannot be decoded counts towards the limits as well. The
    /// error text lacks a subject, as in [`decode_image`].
    pub fn add(&mut self, bytes: &[u8]) -> Result<usize, String> {
        self.bytes_left = self.bytes_left.saturating_sub(bytes.len() as u64);
        self.images.push(decode_image(bytes, &mut self.texels_left)?);
        Ok(self.images.len() - 1)
    }
}

/// Decodes a PNG, JPEG or WebP of at most `texels_left` texels, and subtracts its texels. Texels of an image that
/// cannot be decoded are subtracted too. The error text lacks a subject: the caller puts the image's name before it.
pub fn decode_image(bytes: &[u8], texels_left: &mut u64) -> Result<Image, String> {
    use image::ImageFormat::{Jpeg, Png, WebP};
    let readable = match image::guess_format(bytes) {
        Ok(format @ (Png | Jpeg | WebP)) => Ok(format),
        Ok(other) => Err(format!("{other:?}")),
        Err(_) if bytes.starts_with(b"\xabKTX") => Err("KTX".to_owned()),
        Err(_) => {
            let head: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
            Err(format!("{} bytes that begin with [{}]", bytes.len(), head.join(" ")))
        }
    };
    let format = readable.map_err(|found| format!("is {found}, expected PNG, JPEG or WebP"))?;
    let (pixels, width, height) = bounded_reader(bytes, format)?;
    let left = texels_left.checked_sub(u64::from(width) * u64::from(height)).ok_or_else(|| {
        format!(
            "is {width} x {height} texels and makes the model's images larger than {MAX_TEXELS} texels \
             in total"
        )
    })?;
    *texels_left = left;
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
