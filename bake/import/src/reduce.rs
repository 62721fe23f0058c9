//! Reduction of images whose rows arrive one by one, so that an image of any size needs little memory.

use crate::mesh::Image;
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};

/// Content of an image's channels, which determines how texels are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// sRGB-encoded colour and alpha. Colours are averaged in linear light, weighted by alpha.
    Color,
    /// Values, each averaged by itself.
    Values,
}

/// Sums of the texels that one texel of the result replaces.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Red, green and blue.
    color: [f32; 3],
    /// Red, green and blue times alpha.
    visible: [f32; 3],
    alpha: f32,
    count: f32,
}

impl Sums {
    fn add(&mut self, [r, g, b, alpha]: [f32; 4]) {
        for (i, channel) in [r, g, b].into_iter().enumerate() {
            self.color[i] += channel;
            self.visible[i] += alpha * channel;
        }
        self.alpha += alpha;
        self.count += 1.0;
    }

    fn mean(&self, channels: Channels) -> [u8; 4] {
        let byte = |share: f32| (255.0 * share).round() as u8;
        let alpha = byte(self.alpha / self.count);
        let [r, g, b] = match channels {
            Channels::Values => self.color.map(|sum| byte(sum / self.count)),
            // Where all texels are clear, their colour still counts for materials that ignore alpha.
            Channels::Color if self.alpha == 0.0 => self.color.map(|sum| linear_to_srgb(sum / self.count)),
            Channels::Color => self.visible.map(|sum| linear_to_srgb(sum / self.alpha)),
        };
        [r, g, b, alpha]
    }
}

/// Reduces an image; each texel of the result is the mean of a square of `side` times `side` texels.
pub(crate) struct Reducer {
    channels: Channels,
    side: usize,
    /// Sums of the row of squares that is being read.
    sums: Vec<Sums>,
    /// Number of rows in `sums`.
    rows: usize,
    result: Image,
}

impl Reducer {
    /// Creates a reducer of images with this width and height, texels. Squares that the image does not fill are
    /// averaged over their part of the image.
    pub(crate) fn new([width, height]: [u32; 2], side: u32, channels: Channels) -> Self {
        let (width, height) = (width.div_ceil(side), height.div_ceil(side));
        let rgba = Vec::with_capacity(4 * width as usize * height as usize);
        let sums = vec![Sums::default(); width as usize];
        Self { channels, side: side as usize, sums, rows: 0, result: Image { width, height, rgba } }
    }

    /// Adds the next row of bytes. A texel has one to four components: grey, grey and alpha, RGB, or RGBA.
    pub(crate) fn push_row(&mut self, row: &[u8], components: usize) {
        let share = |byte: u8| f32::from(byte) / 255.0;
        let channel = |byte| if self.channels == Channels::Color { srgb_to_linear(byte) } else { share(byte) };
        for (sums, square) in self.sums.iter_mut().zip(row.chunks(self.side * components)) {
            for texel in square.chunks_exact(components) {
                let (rgb, alpha) = match *texel {
                    [grey] => ([grey; 3], 255),
                    [grey, alpha] => ([grey; 3], alpha),
                    [r, g, b] => ([r, g, b], 255),
                    [r, g, b, alpha, ..] => ([r, g, b], alpha),
                    [] => ([0; 3], 0),
                };
                let [r, g, b] = rgb.map(channel);
                sums.add([r, g, b, share(alpha)]);
            }
        }
        self.rows += 1;
        if self.rows == self.side {
            self.finish_row();
        }
    }

    fn finish_row(&mut self) {
        let channels = self.channels;
        self.result.rgba.extend(self.sums.iter().flat_map(|sums| sums.mean(channels)));
        self.sums.fill(Sums::default());
        self.rows = 0;
    }

    /// Returns the reduced image after the last row.
    pub(crate) fn finish(mut self) -> Image {
        if self.rows > 0 {
            self.finish_row();
        }
        self.result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reduced(size: [u32; 2], texels: &[[u8; 4]], channels: Channels) -> Image {
        let mut reducer = Reducer::new(size, 2, channels);
        texels.chunks(size[0] as usize).for_each(|row| reducer.push_row(&row.concat(), 4));
        reducer.finish()
    }

    #[test]
    fn colours_are_averaged_in_linear_light_and_weighted_by_alpha() {
        let (black, white) = ([0, 0, 0, 255], [255; 4]);
        let texels = [black, white, [9, 9, 9, 0], white, black, [230, 140, 60, 255]];
        let found = reduced([3, 2], &texels, Channels::Color);
        assert_eq!((found.width, found.height), (2, 1));
        // Half the light has the byte 188. The clear texel has no weight.
        assert_eq!(found.rgba, [188, 188, 188, 255, 230, 140, 60, 128]);
        let values = reduced([2, 1], &[black, white], Channels::Values);
        assert_eq!(values.rgba, [128, 128, 128, 255]);
        let clear = reduced([2, 1], &[[230, 140, 60, 0]; 2], Channels::Color);
        assert_eq!(clear.rgba, [230, 140, 60, 0], "clear texels keep their colour");
    }
}
