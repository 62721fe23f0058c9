//! Image of a seal on a painting.

use std::fmt;

/// Image of a seal: coloured characters on transparent or white ground.
#[derive(Clone, PartialEq, Eq)]
pub struct SealImage {
    size: [u32; 2],
    rgba: Vec<u8>,
}

impl SealImage {
    /// Largest width and height, pixels.
    pub const MAX_SIDE: u32 = 2048;

    /// Creates an image of `size` pixels, width and height, from rows of sRGB-encoded red, green, blue and straight
    /// alpha, 1 byte each, from top to bottom.
    ///
    /// Fails with what was found and expected if a side is not 1..=[`Self::MAX_SIDE`], or if the number of bytes does
    /// not match the size.
    pub fn new(size: [u32; 2], rgba: Vec<u8>) -> Result<Self, String> {
        let [width, height] = size;
        if !size.iter().all(|side| (1..=Self::MAX_SIDE).contains(side)) {
            return Err(format!("found {width} x {height} pixels, expected 1..={} for each side", Self::MAX_SIDE));
        }
        let expected = 4 * width as usize * height as usize;
        if rgba.len() != expected {
            return Err(format!("found {} bytes for {width} x {height} pixels, expected {expected}", rgba.len()));
        }
        Ok(Self { size, rgba })
    }

    /// Returns width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the rows, in the format of [`Self::new`].
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }
}

impl fmt::Debug for SealImage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SealImage({} x {})", self.size[0], self.size[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_with_wrong_sizes_are_refused() {
        assert_eq!(SealImage::new([2, 1], vec![0; 8]).unwrap().size(), [2, 1]);
        for (size, bytes, said) in [
            ([0, 1], 0, "found 0 x 1 pixels, expected 1..=2048 for each side"),
            ([1, 2049], 0, "found 1 x 2049 pixels, expected 1..=2048 for each side"),
            ([2, 1], 7, "found 7 bytes for 2 x 1 pixels, expected 8"),
        ] {
            assert_eq!(SealImage::new(size, vec![0; bytes]).unwrap_err(), said);
        }
    }
}
