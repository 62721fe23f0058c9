//! Uncompressed video: YUV4MPEG2, "Y4M", which ffmpeg and players read from a file or a pipe.
//!
//! Frames are 4:4:4 with 8 bits, in Y'CbCr of ITU-R BT.709 (§3: luma 0.2126, 0.7152, 0.0722). The range is limited
//! (16..=235 and 16..=240), as is usual for video. The header declares the range with the word `XCOLORRANGE`, which
//! ffmpeg introduced. The format cannot declare the matrix, and many readers treat small undeclared video as BT.601.
//! Set BT.709 in the reader explicitly.

use std::io::{self, Write};

/// Video writer that writes frame by frame.
#[derive(Debug)]
pub struct Y4m<W> {
    out: W,
    width: u32,
    height: u32,
    planes: Vec<u8>,
}

impl<W: Write> Y4m<W> {
    /// Writes the header of a video of `width × height` square pixels and `fps` progressive frames per second.
    ///
    /// Fails with errors of `out`.
    pub fn new(mut out: W, width: u32, height: u32, fps: u32) -> io::Result<Self> {
        writeln!(out, "YUV4MPEG2 W{width} H{height} F{fps}:1 Ip A1:1 C444 XCOLORRANGE=LIMITED")?;
        Ok(Self { out, width, height, planes: Vec::new() })
    }

    /// Writes a frame of `3 * width * height` sRGB-encoded bytes, row-major from the top: red, green and blue of each
    /// pixel. The bytes are treated as R'G'B' of BT.709, which has the same primaries and, on screens, nearly the same
    /// curve.
    ///
    /// Fails with errors of `out`, and [`io::ErrorKind::InvalidInput`] for a frame of another size.
    pub fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        let pixels = self.width as usize * self.height as usize;
        if rgb.len() != 3 * pixels {
            let text = format!("a frame of {} bytes, expected {}", rgb.len(), 3 * pixels);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        self.planes.clear();
        for plane in 0..3 {
            self.planes.extend(rgb.chunks_exact(3).map(|p| ycbcr([p[0], p[1], p[2]])[plane]));
        }
        self.out.write_all(b"FRAME\n")?;
        self.out.write_all(&self.planes)
    }

    /// Flushes buffered data.
    ///
    /// Fails with errors of `out`.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Converts sRGB-encoded bytes to Y'CbCr of BT.709, limited range.
fn ycbcr(rgb: [u8; 3]) -> [u8; 3] {
    let [r, g, b] = rgb.map(|byte| f32::from(byte) / 255.0);
    let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    // The divisors scale the extreme colours to ±1/2: 2 (1 − 0.0722) and 2 (1 − 0.2126).
    let [cb, cr] = [(b - y) / 1.8556, (r - y) / 1.5748];
    [16.0 + 219.0 * y, 128.0 + 224.0 * cb, 128.0 + 224.0 * cr].map(|x| x.round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn video_has_a_header_and_planar_frames() {
        let mut bytes = Vec::new();
        let mut video = Y4m::new(&mut bytes, 3, 1, 24).unwrap();
        video.frame(&[255, 255, 255, 0, 0, 0, 255, 0, 0]).unwrap();
        video.frame(&[0, 0, 255, 0, 0, 0, 0, 255, 0]).unwrap();
        assert_eq!(video.frame(&[0; 6]).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        video.flush().unwrap();
        let mut expected = b"YUV4MPEG2 W3 H1 F24:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\nFRAME\n".to_vec();
        expected.extend([235, 16, 63, 128, 128, 102, 128, 128, 240]);
        expected.extend(b"FRAME\n");
        expected.extend([32, 16, 173, 240, 128, 42, 118, 128, 26]);
        assert_eq!(bytes, expected);
    }

    #[test]
    fn colour_bars_of_the_standard_are_reproduced() {
        // The frames are colour bars of 100 % and 75 % (SMPTE RP 219, table of 8-bit values in BT.709).
        for (rgb, expected) in [
            ([255, 255, 0], [219, 16, 138]),
            ([0, 255, 255], [188, 154, 16]),
            ([255, 0, 255], [78, 214, 230]),
            ([191, 191, 191], [180, 128, 128]),
            ([191, 191, 0], [168, 44, 136]),
            ([0, 191, 191], [145, 147, 44]),
            ([0, 191, 0], [133, 63, 52]),
            ([191, 0, 191], [63, 193, 204]),
            ([191, 0, 0], [51, 109, 212]),
            ([0, 0, 191], [28, 212, 120]),
        ] {
            let found = ycbcr(rgb);
            let off = found.iter().zip(&expected).map(|(a, b)| i32::from(*a).abs_diff(*b)).max();
            assert!(off <= Some(1), "{rgb:?}: {found:?}, expected {expected:?}");
        }
    }

    #[test]
    fn ycbcr_stays_in_the_limited_range() {
        for i in 0..=255_u8 {
            for rgb in [[i, 0, 255], [255, i, 0], [0, 255, i], [i, i, i]] {
                let [y, cb, cr] = ycbcr(rgb);
                assert!((16..=235).contains(&y) && (16..=240).contains(&cb) && (16..=240).contains(&cr), "{rgb:?}");
            }
            let [_, cb, cr] = ycbcr([i; 3]);
            assert_eq!((cb, cr), (128, 128), "grey has no colour");
        }
    }
}
