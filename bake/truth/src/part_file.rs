//! File format for a part of a ray-traced picture, so that several machines can trace one picture.
//!
//! A file has a line with the format's name, a line of JSON that identifies the picture, and the pixels of the part's
//! squares. It ends with a SHA-256 of everything before. Each pixel has two values: the traced value (four floats), and
//! its value in a PNG (four bytes). Parts can thus be joined without knowing the background.

use super::picture::{Part, Rays, Square, TracedPicture};
use image::RgbaImage;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// First line of a file.
const MAGIC: &[u8] = b"pelage part 1\n";
/// Size of the hash at the end, bytes.
const HASH: usize = 32;
/// Size of a pixel, bytes.
const PIXEL: usize = 20;
/// Maximum number of pixels of the whole picture.
const MOST_PIXELS: u64 = 8192 * 8192;

/// A traced part of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct TracedPart {
    /// Description of the whole picture and of the part.
    pub of: PartHeader,
    /// Traced pixels of the part; all others are empty.
    pub traced: TracedPicture,
    /// The same pixels, as stored in a PNG.
    pub shown: RgbaImage,
}

/// Description of a picture and one of its parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartHeader {
    /// Identifies everything that the pixels depend on.
    pub picture: String,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Samples per pixel.
    pub spp: u32,
    /// Index of the part, from 0.
    pub part: u32,
    /// Number of parts.
    pub parts: u32,
    /// Whether the picture has a background.
    pub background: bool,
    /// Number of rays from the eye.
    pub primary_rays: u64,
    /// Number of rays to the lights.
    pub shadow_rays: u64,
}

impl TracedPart {
    /// Encodes the part as a file.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        // Serialisation cannot fail: the header has only numbers, a boolean and a string.
        bytes.extend(serde_json::to_vec(&self.of).unwrap_or_default());
        bytes.push(b'\n');
        for at in pixel_indices(&self.of) {
            let shown = self.shown.as_raw().get(4 * at..4 * at + 4).unwrap_or_default();
            bytes.extend(self.traced.pixels[at].iter().flat_map(|channel| channel.to_le_bytes()));
            bytes.extend_from_slice(shown);
        }
        let hash = Sha256::digest(&bytes);
        bytes.extend_from_slice(&hash);
        bytes
    }

    /// Decodes a file.
    ///
    /// Fails with the position of the fault in the file, and the reason.
    pub fn decode(bytes: &[u8]) -> Result<Self, (String, String)> {
        let wrong = |place: &str, reason: String| (place.to_owned(), reason);
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| {
            wrong("byte 0", "is not a part of a picture; expected a file written by `pelage reference --part`".into())
        })?;
        let end = rest.iter().position(|byte| *byte == b'\n');
        let end = end.ok_or_else(|| wrong("line 2", "the line does not end; the file is cut off".into()))?;
        let of: PartHeader = serde_json::from_slice(&rest[..end]).map_err(|e| wrong("line 2", e.to_string()))?;
        let squares = u64::from(of.width) * u64::from(of.height);
        if of.parts == 0 || of.part >= of.parts || squares > MOST_PIXELS || squares == 0 {
            let found = format!("part {} of {} of {}x{} pixels", of.part, of.parts, of.width, of.height);
            return Err(wrong(
                "line 2",
                format!("found {found}, expected a part of a picture of 1 to {MOST_PIXELS} pixels"),
            ));
        }
        let begin = MAGIC.len() + end + 1;
        let part = Part { number: of.part, of: of.parts }.squares((of.width, of.height));
        let pixels: u64 = part.iter().map(Square::pixels).sum();
        let length = begin + PIXEL * pixels as usize + HASH;
        if bytes.len() != length {
            let found = bytes.len();
            return Err(wrong(&format!("byte {begin}"), format!("the file has {found} bytes, expected {length}")));
        }
        let (body, hash) = bytes.split_at(length - HASH);
        if Sha256::digest(body).as_slice() != hash {
            let reason = "the hash of the preceding bytes differs; the file is damaged";
            return Err(wrong(&format!("byte {}", length - HASH), reason.into()));
        }
        let count = squares as usize;
        let (mut pixels, mut shown) = (vec![[0.0; 4]; count], vec![0; 4 * count]);
        for (at, pixel) in pixel_indices(&of).into_iter().zip(body[begin..].chunks_exact(PIXEL)) {
            let (floats, bytes) = pixel.split_at(16);
            for (channel, float) in pixels[at].iter_mut().zip(floats.chunks_exact(4)) {
                *channel = f32::from_le_bytes(float.try_into().unwrap_or_default());
            }
            shown[4 * at..4 * at + 4].copy_from_slice(bytes);
        }
        let rays = Rays { primary: of.primary_rays, shadow: of.shadow_rays };
        let traced = TracedPicture { width: of.width, height: of.height, pixels, rays };
        let shown = RgbaImage::from_raw(of.width, of.height, shown).unwrap_or_default();
        Ok(Self { of, traced, shown })
    }

    /// Adds another part of the same picture to this one.
    ///
    /// Fails with the reason, if the other part belongs to a different picture.
    pub fn add(&mut self, other: &Self) -> Result<(), String> {
        let whole = |of: &PartHeader| PartHeader { part: 0, primary_rays: 0, shadow_rays: 0, ..of.clone() };
        let (here, there) = (whole(&self.of), whole(&other.of));
        if here != there {
            let words = |of: &PartHeader| {
                let PartHeader { width, height, spp, parts, picture, .. } = of;
                let picture = picture.get(..12).unwrap_or(picture);
                format!("one of {parts} parts of {width}x{height} pixels, {spp} samples, of picture {picture}")
            };
            return Err(format!("found {}, expected {}", words(&there), words(&here)));
        }
        for at in pixel_indices(&other.of) {
            self.traced.pixels[at] = other.traced.pixels[at];
            let (here, there) = (self.shown.get_mut(4 * at..4 * at + 4), other.shown.get(4 * at..4 * at + 4));
            if let (Some(here), Some(there)) = (here, there) {
                here.copy_from_slice(there);
            }
        }
        self.traced.rays.primary += other.traced.rays.primary;
        self.traced.rays.shadow += other.traced.rays.shadow;
        Ok(())
    }
}

/// Returns the indices in the picture of a part's pixels, in the order of the part's file.
fn pixel_indices(of: &PartHeader) -> Vec<usize> {
    let squares = Part { number: of.part, of: of.parts }.squares((of.width, of.height));
    let width = of.width as usize;
    let pixels = squares.into_iter().flat_map(|square| {
        let columns = square.columns;
        square.rows.flat_map(move |y| columns.clone().map(move |x| y as usize * width + x as usize))
    });
    pixels.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(number: u32) -> TracedPart {
        let of = PartHeader {
            picture: "a".into(),
            width: 40,
            height: 20,
            spp: 4,
            part: number,
            parts: 2,
            background: false,
            primary_rays: 7,
            shadow_rays: 3,
        };
        let mut traced = TracedPicture { width: 40, height: 20, ..TracedPicture::default() };
        traced.rays = Rays { primary: 7, shadow: 3 };
        traced.pixels = vec![[0.0; 4]; 800];
        let mut shown = RgbaImage::new(40, 20);
        for at in pixel_indices(&of) {
            traced.pixels[at] = [at as f32, 0.1, f32::MIN_POSITIVE, 1.0];
            shown.put_pixel(at as u32 % 40, at as u32 / 40, image::Rgba([at as u8, 1, 2, 255]));
        }
        TracedPart { of, traced, shown }
    }

    #[test]
    fn part_files_add_up_to_the_whole() {
        let mut whole = TracedPart::decode(&part(1).encode()).unwrap();
        assert_eq!(whole, part(1));
        whole.add(&TracedPart::decode(&part(0).encode()).unwrap()).unwrap();
        assert!((0..800).all(|at| whole.traced.pixels[at][0] == at as f32));
        assert!((0..800).all(|at| whole.shown.as_raw()[4 * at] == at as u8));
        assert_eq!(whole.traced.rays, Rays { primary: 14, shadow: 6 });
        let mut other = part(0);
        other.of.picture = "b".into();
        assert!(whole.add(&other).unwrap_err().contains("of picture b, expected one of 2 parts of 40x20 pixels"));
    }

    #[test]
    fn damaged_part_files_are_refused_with_the_position() {
        let bytes = part(0).encode();
        for (cut, word) in [(0, "byte 0"), (20, "line 2"), (bytes.len() - 1, "byte 132")] {
            let (place, reason) = TracedPart::decode(&bytes[..cut]).unwrap_err();
            assert_eq!(place, word, "{reason}");
        }
        for at in 0..bytes.len() {
            let mut broken = bytes.clone();
            broken[at] ^= 1;
            assert!(TracedPart::decode(&broken).is_err(), "bit {at}");
        }
    }
}
