//! Sets of pixels and distances between them, for measuring lines in rendered images.
//!
//! [`Mask::core`] thins lines of any width to one pixel. [`Mask::widest_stroke`] returns the diameter of the largest
//! disc that fits into the ink.

mod thinning;

use image::RgbaImage;
use pelage_bake::mask::squared_distances;
use pelage_import::BakeError;

/// Set of pixels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mask {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Membership of each pixel: `width * height` values, row-major from the top.
    pub pixels: Vec<bool>,
}

/// Widest stroke of a drawing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stroke {
    /// Diameter of the largest disc that fits into ink, pixels; 0 without any ink.
    pub width_px: f64,
    /// Centre of that disc, pixels from the upper left corner of the image.
    pub at_px: [f64; 2],
}

impl Mask {
    /// Returns the empty set.
    pub fn empty(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![false; width as usize * height as usize] }
    }

    /// Returns the set of pixels for which `is_in` returns true, called row by row from the top.
    pub fn from_fn(width: u32, height: u32, mut is_in: impl FnMut(u32, u32) -> bool) -> Self {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self { width, height, pixels: places.map(|(x, y)| is_in(x, y)).collect() }
    }

    /// Returns the pixels of a black-on-white drawing whose largest colour component is below `grey`, 0..=255.
    pub fn darker(picture: &RgbaImage, grey: u8) -> Self {
        let dark = |x, y| {
            let [r, g, b, _] = picture.get_pixel(x, y).0;
            r.max(g).max(b) < grey
        };
        Self::from_fn(picture.width(), picture.height(), dark)
    }

    /// Returns the number of pixels in the set.
    pub fn count(&self) -> usize {
        self.pixels.iter().filter(|p| **p).count()
    }

    /// Whether a pixel is in the set; false outside the image.
    pub fn contains(&self, x: i64, y: i64) -> bool {
        self.index(x, y).is_some_and(|i| self.pixels[i])
    }

    /// Adds a pixel; ignored outside the image.
    pub fn insert(&mut self, x: i64, y: i64) {
        if let Some(i) = self.index(x, y) {
            self.pixels[i] = true;
        }
    }

    fn index(&self, x: i64, y: i64) -> Option<usize> {
        let inside = (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        inside.then(|| y as usize * self.width as usize + x as usize)
    }

    /// Returns the union of both sets.
    ///
    /// Fails with [`BakeError::Params`] if the sizes differ.
    pub fn union(&self, other: &Self) -> Result<Self, BakeError> {
        self.same_size(other)?;
        let pixels = self.pixels.iter().zip(&other.pixels).map(|(a, b)| *a || *b).collect();
        Ok(Self { pixels, ..*self })
    }

    /// Checks that both sets have the same size.
    ///
    /// Fails with [`BakeError::Params`] if the sizes differ.
    pub fn same_size(&self, other: &Self) -> Result<(), BakeError> {
        if (self.width, self.height) == (other.width, other.height) {
            return Ok(());
        }
        let size = |m: &Self| format!("{}x{}", m.width, m.height);
        let reason = format!("found {} and {} pixels, expected the same size for both", size(self), size(other));
        Err(BakeError::Params { what: "masks", reason })
    }

    /// Returns the distance from each pixel's centre to the centre of the nearest pixel of the set, pixels. It is 0 in
    /// the set, and infinite if the set is empty. It is exact except for the rounding of one square root.
    pub fn distances(&self) -> Vec<f64> {
        let mut squares = squared_distances(self.width as usize, self.height as usize, |i| self.pixels[i]);
        squares.iter_mut().for_each(|d| *d = d.sqrt());
        squares
    }

    /// Returns the widest stroke of the set, whose pixels are ink: the largest disc of ink, with pixels as squares.
    /// Pixels outside the image are not ink. A line of n pixels along an axis has width n.
    ///
    /// If several strokes are equally wide, the first from the top is returned.
    pub fn widest_stroke(&self) -> Stroke {
        // Sample at points half a pixel apart (centres, corners and edge midpoints of pixels), surrounded by a border
        // without ink. The centre of the largest disc is less than half a pixel from one of these points. For each
        // sample, the nearest point without ink is also a sample.
        let (w, h) = (self.width as usize, self.height as usize);
        let (columns, rows) = (2 * w + 1, 2 * h + 1);
        let mut paper = vec![false; columns * rows];
        for (i, _) in self.pixels.iter().enumerate().filter(|(_, ink)| !**ink) {
            let (x, y) = (2 * (i % w), 2 * (i / w));
            (y..=y + 2).for_each(|y| paper[y * columns + x..=y * columns + x + 2].fill(true));
        }
        for x in 0..columns {
            paper[x] = true;
            paper[(rows - 1) * columns + x] = true;
        }
        for y in 0..rows {
            paper[y * columns] = true;
            paper[(y + 1) * columns - 1] = true;
        }
        let squares = squared_distances(columns, rows, |i| paper[i]);
        let mut widest = (0.0, 0);
        for (i, square) in squares.iter().enumerate() {
            if *square > widest.0 {
                widest = (*square, i);
            }
        }
        let (square, i) = widest;
        if square <= 0.0 {
            return Stroke::default();
        }
        // `square` is the square of the radius in half pixels. Its root is therefore the diameter in pixels.
        Stroke { width_px: square.sqrt(), at_px: [(i % columns) as f64 / 2.0, (i / columns) as f64 / 2.0] }
    }
}

#[cfg(test)]
mod tests;
