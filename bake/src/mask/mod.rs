//! Exact Euclidean distance transform: P. F. Felzenszwalb, D. P. Huttenlocher, *Distance Transforms of Sampled
//! Functions*, Theory of Computing 8 (2012).
//!
//! The squared distance to a set of points is the lower envelope of one parabola per point. A grid is processed column
//! by column, then row by row.

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

impl Mask {
    /// Returns the distance from each pixel's centre to the centre of the nearest pixel of the set, pixels. It is 0 in
    /// the set, and infinite if the set is empty. It is exact except for the rounding of one square root.
    pub fn distances(&self) -> Vec<f64> {
        let mut squares = squared_distances(self.width as usize, self.height as usize, |i| self.pixels[i]);
        squares.iter_mut().for_each(|d| *d = d.sqrt());
        squares
    }
}

/// Returns the squared distance of every grid point to the nearest point of a set; infinite if the set is empty.
///
/// * `width`, `height`: size of the grid, row-major
/// * `is_in`: whether the point with that index is in the set
pub fn squared_distances(width: usize, height: usize, is_in: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut grid: Vec<f64> = (0..width * height).map(|i| if is_in(i) { 0.0 } else { f64::INFINITY }).collect();
    let mut envelope = Envelope::default();
    let mut column = vec![0.0; height];
    for x in 0..width {
        for (y, value) in column.iter_mut().enumerate() {
            *value = grid[y * width + x];
        }
        envelope.transform_line(&mut column);
        for (y, value) in column.iter().enumerate() {
            grid[y * width + x] = *value;
        }
    }
    if width > 0 {
        grid.chunks_exact_mut(width).for_each(|row| envelope.transform_line(row));
    }
    grid
}

/// Lower envelope of parabolas, which are stored from left to right.
#[derive(Default)]
struct Envelope {
    /// Position and height of the vertex of each parabola.
    feet: Vec<(f64, f64)>,
    /// Left end of the interval in which each parabola is the lowest.
    from: Vec<f64>,
}

impl Envelope {
    /// Replaces each value f(q) by the minimum of f(p) + (p − q)² over all p.
    fn transform_line(&mut self, values: &mut [f64]) {
        self.feet.clear();
        self.from.clear();
        for (q, height) in values.iter().enumerate().filter(|(_, height)| height.is_finite()) {
            let q = q as f64;
            let mut from = f64::NEG_INFINITY;
            while let (Some((p, lowest)), Some(last)) = (self.feet.last(), self.from.last()) {
                // Intersection of this parabola with the last one, to the right of which this one is lower.
                from = ((height + q * q) - (lowest + p * p)) / (2.0 * (q - p));
                if from > *last {
                    break;
                }
                self.feet.pop();
                self.from.pop();
                from = f64::NEG_INFINITY;
            }
            self.feet.push((q, *height));
            self.from.push(from);
        }
        if self.feet.is_empty() {
            return;
        }
        let mut k = 0;
        for (q, value) in values.iter_mut().enumerate() {
            let q = q as f64;
            while self.from.get(k + 1).is_some_and(|from| *from < q) {
                k += 1;
            }
            let (p, lowest) = self.feet[k];
            *value = lowest + (q - p) * (q - p);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::uniform;

    #[test]
    fn distances_agree_with_an_exhaustive_search() {
        for (seed, (width, height)) in [(1, 1), (7, 1), (1, 9), (13, 8), (31, 22)].into_iter().enumerate() {
            for share in [0.0, 0.01, 0.1, 0.6, 1.0] {
                let pixels = (0..width * height).map(|i| uniform(seed as u64, u64::from(i)) < share).collect();
                let mask = Mask { width, height, pixels };
                let set: Vec<usize> = (0..mask.pixels.len()).filter(|i| mask.pixels[*i]).collect();
                let place = |i: usize| (f64::from(i as u32 % width), f64::from(i as u32 / width));
                for (i, found) in mask.distances().into_iter().enumerate() {
                    let far = |j: &usize| (place(i).0 - place(*j).0).hypot(place(i).1 - place(*j).1);
                    let nearest = set.iter().map(far).fold(f64::INFINITY, f64::min);
                    assert!(found == nearest || (found - nearest).abs() < 1e-12, "{width}x{height}, pixel {i}");
                }
            }
        }
    }
}
