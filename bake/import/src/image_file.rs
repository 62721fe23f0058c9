//! Reading of PNG, JPEG and WebP images, with limits on texels and memory.

use crate::mesh::Image;
pub use crate::reduce::Channels;
use crate::reduce::Reducer;
use image::{DynamicImage, ImageDecoder as _, ImageFormat};
use pelage_formats::Limits;
use std::io::Cursor;
use std::sync::Arc;

/// Maximum number of texels of all image files of a model together. This allows one image of 16 384² texels or sixteen
/// of 4096². A limit is needed because a PNG of a few kilobytes can claim as much.
pub const MAX_TEXELS: u64 = 1 << 28;

/// Maximum size of all image files of a model together, bytes. A limit is needed because many images can name the same
/// large file.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

/// Decoded images of a model, and what is left of the limits that they share.
#[derive(Debug)]
pub(crate) struct ImageList {
    pub images: Vec<Arc<Image>>,
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
    ///
    /// * `name`: subject of a warning that the image is reduced
    /// * `warn`: receives warnings
    pub fn add(&mut self, bytes: &[u8], name: &str, warn: &mut dyn FnMut(String)) -> Result<usize, String> {
        self.bytes_left = self.bytes_left.saturating_sub(bytes.len() as u64);
        let (image, note) = decode_image(bytes, &mut self.texels_left, Channels::Color)?;
        self.images.push(Arc::new(image));
        let mut images: Vec<&mut Image> = self.images.iter_mut().map(Arc::make_mut).collect();
        let reduced = fit_images(&mut images, Channels::Color);
        note.map(|note| format!("{name} {note}")).into_iter().chain(reduced).for_each(warn);
        Ok(self.images.len() - 1)
    }
}

/// Maximum number of texels kept of one image: 64 MiB, 4096². Larger images are reduced while they are decoded.
const MAX_KEPT: u64 = 1 << 24;

/// Maximum number of texels kept of all images together: 256 MiB.
const MAX_KEPT_TOGETHER: u64 = 1 << 26;

/// Maximum memory for a command, and the part of it that is not available to a decoder; bytes.
const MEMORY: (u64, u64) = (1 << 30, 1 << 27);

/// Maximum memory for parts of an image file other than its texels, such as colour profiles; bytes.
const MAX_METADATA: u64 = 1 << 26;

/// Decodes a PNG, JPEG or WebP of at most `texels_left` texels, and subtracts its texels. Texels of an image that
/// cannot be decoded are subtracted too. A large image is reduced, which the returned text reports.
///
/// Both texts lack a subject: the caller puts the image's name before them.
pub fn decode_image(
    bytes: &[u8],
    texels_left: &mut u64,
    channels: Channels,
) -> Result<(Image, Option<String>), String> {
    use ImageFormat::{Jpeg, Png, WebP};
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
    let kept = |side: u32| u64::from(width.div_ceil(side)) * u64::from(height.div_ceil(side));
    let mut side = 1;
    while kept(side) > MAX_KEPT {
        side *= 2;
    }
    if side > 1 && format == ImageFormat::Png && !is_interlaced(bytes) {
        let image = reduce_png(bytes, side, channels).map_err(|error| format!("cannot be decoded: {error}"))?;
        return Ok(with_note(image, [width, height]));
    }
    let decoder = pixels.into_decoder().map_err(broken)?;
    check_memory(decoder_bytes(bytes, format, decoder.total_bytes()))?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(broken)?;
    if side == 1 {
        return Ok((Image { width, height, rgba: decoded.into_rgba8().into_raw() }, None));
    }
    let color = decoded.color();
    let components = usize::from(color.channel_count());
    let image = if usize::from(color.bytes_per_pixel()) == components {
        reduce_rows(decoded.as_bytes(), components, [width, height], side, channels)
    } else {
        reduce_rows(&decoded.into_rgba8(), 4, [width, height], side, channels)
    };
    Ok(with_note(image, [width, height]))
}

fn broken(error: image::ImageError) -> String {
    format!("cannot be decoded: {error}")
}

fn with_note(image: Image, [width, height]: [u32; 2]) -> (Image, Option<String>) {
    let note = format!("is {width} x {height} texels, read as {} x {} to limit memory", image.width, image.height);
    (image, Some(note))
}

/// Returns an image reduced by the factor `side`.
fn reduce_rows(bytes: &[u8], components: usize, size: [u32; 2], side: u32, channels: Channels) -> Image {
    let mut reducer = Reducer::new(size, side, channels);
    bytes.chunks_exact(size[0] as usize * components).for_each(|row| reducer.push_row(row, components));
    reducer.finish()
}

/// Decodes a PNG row by row, and reduces it by the factor `side`.
fn reduce_png(bytes: &[u8], side: u32, channels: Channels) -> Result<Image, png::DecodingError> {
    let limits = png::Limits { bytes: MAX_METADATA as usize };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut rows = decoder.read_info()?;
    let components = rows.output_color_type().0.samples();
    let mut reducer = Reducer::new([rows.info().width, rows.info().height], side, channels);
    while let Some(row) = rows.next_row()? {
        reducer.push_row(row.data(), components);
    }
    Ok(reducer.finish())
}

/// Whether a PNG stores its texels in several passes. Then the decoder needs all of them at once.
fn is_interlaced(png: &[u8]) -> bool {
    png.get(28).is_some_and(|method| *method != 0)
}

/// Whether a JPEG stores its texels in several scans. Then the decoder keeps the coefficients of all texels.
fn is_progressive(jpeg: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, marker, high, low]) = jpeg.get(at..at + 4) {
        match marker {
            0xc4 | 0xc8 | 0xcc => {}
            0xc0..=0xcf => return marker & 3 == 2,
            // Bytes between markers.
            0xff => {
                at += 1;
                continue;
            }
            _ => {}
        }
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
    }
    false
}

/// Returns the memory in which an image is decoded as a whole; `decoded` is the size of its texels, bytes.
fn decoder_bytes(bytes: &[u8], format: ImageFormat, decoded: u64) -> u64 {
    let file = bytes.len() as u64;
    match format {
        // The decoder of JPEG copies the file, and coefficients have two bytes.
        ImageFormat::Jpeg => 2 * file + if is_progressive(bytes) { 3 * decoded } else { decoded },
        _ => file + decoded,
    }
}

/// Checks that an image can be decoded in `needed` bytes. The error text lacks a subject, as in [`decode_image`].
pub fn check_memory(needed: u64) -> Result<(), String> {
    let (limit, reserved) = MEMORY;
    if needed + reserved <= limit {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    Err(format!("needs {:.1} GiB of memory to decode; the limit is {:.0} GiB in total", gib(needed), gib(limit)))
}

/// Halves the largest images until all together are small enough to keep. Returns a warning if it halved any.
pub fn fit_images(images: &mut [&mut Image], channels: Channels) -> Option<String> {
    let texels = |image: &Image| u64::from(image.width) * u64::from(image.height);
    let mut halved = false;
    while images.iter().map(|image| texels(image)).sum::<u64>() > MAX_KEPT_TOGETHER {
        let largest = images.iter_mut().max_by_key(|image| texels(image))?;
        let size = [largest.width, largest.height];
        **largest = reduce_rows(&largest.rgba, 4, size, 2, channels);
        halved = true;
    }
    halved.then(|| {
        format!(
            "the images have more than {MAX_KEPT_TOGETHER} texels in total; the largest are read at half their size"
        )
    })
}

type Reader<'a> = image::ImageReader<Cursor<&'a [u8]>>;

/// Returns a decoder with limited memory, and the image's width and height. The error text lacks a subject, as in
/// [`decode_image`].
pub fn bounded_reader(bytes: &[u8], format: ImageFormat) -> Result<(Reader<'_>, u32, u32), String> {
    let side = Limits::default().texture_size;
    let reader = |max_alloc| {
        let mut reader = image::ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(max_alloc);
        reader.limits(limits);
        reader
    };
    // Read only the header, without the decoder's own limits on size: errors from these would be less precise than
    // those below.
    let (width, height) = reader(MAX_METADATA).into_dimensions().map_err(broken)?;
    if width == 0 || height == 0 || width > side || height > side {
        return Err(format!("is {width} x {height} texels, expected 1..={side} per side"));
    }
    // Texels of pictures have at most 16 bytes.
    Ok((reader(16 * u64::from(width) * u64::from(height) + MAX_METADATA), width, height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jpegs_in_several_scans_are_limited_by_their_coefficients() {
        let frame = |marker: u8| {
            let start = [0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, 2, 0xff, 0xff, 0xc4, 0, 3, 9];
            [&start[..], &[0xff, marker, 0, 11, 8]].concat()
        };
        // RGB of the largest size that the texel limit allows.
        let decoded = 3 * MAX_TEXELS;
        for (marker, accepted) in [(0xc0, true), (0xc1, true), (0xc2, false), (0xca, false)] {
            let jpeg = frame(marker);
            let found = check_memory(decoder_bytes(&jpeg, ImageFormat::Jpeg, decoded));
            assert_eq!(found.is_ok(), accepted, "{marker:x}: {found:?}");
            assert!(found.err().is_none_or(|reason| reason.contains("2.3 GiB") && reason.contains("limit is 1 GiB")));
        }
        assert!(check_memory(decoder_bytes(&[], ImageFormat::Png, 4 * MAX_TEXELS)).is_err());
    }
}
