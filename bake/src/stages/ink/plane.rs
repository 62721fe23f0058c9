//! Channel of a square repeating tile, and conversion of four channels to texels with mips.

use crate::noise::hash;
use crate::stages::slice::gaussian_weights;
use glam::Vec2;
use rayon::prelude::*;

/// Square grid of numbers that repeats along both axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Width and height, texels.
    pub side: usize,
    /// Values of the texels, `side * side`, row by row.
    pub values: Vec<f32>,
}

/// Returns the mean. Values are summed in their order, so that the result does not depend on the number of threads.
fn mean_of(values: impl Iterator<Item = f32>, count: usize) -> f32 {
    (values.map(f64::from).sum::<f64>() / count.max(1) as f64) as f32
}

/// Returns the values of `f` at the centres of the texels, row by row.
fn texels<T: Copy + Default + Send>(side: usize, f: impl Fn(Vec2) -> T + Sync) -> Vec<T> {
    let mut values = vec![T::default(); side * side];
    values.par_chunks_mut(side).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = f((Vec2::new(x as f32, y as f32) + 0.5) / side as f32);
        }
    });
    values
}

impl Plane {
    /// Creates a plane of zeros.
    pub(super) fn empty(side: usize) -> Self {
        Self { side, values: vec![0.0; side * side] }
    }

    /// Evaluates `f` at the centre of every texel; the tile covers 0..1 along both axes.
    pub(super) fn from_fn(side: usize, f: impl Fn(Vec2) -> f32 + Sync) -> Self {
        Self { side, values: texels(side, f) }
    }

    /// Evaluates a function of two values at the centre of every texel, and returns a plane for each.
    pub(super) fn pair_from_fn(side: usize, f: impl Fn(Vec2) -> [f32; 2] + Sync) -> [Self; 2] {
        let pairs = texels(side, f);
        [0, 1].map(|of| Self { side, values: pairs.iter().map(|pair| pair[of]).collect() })
    }

    /// Applies `f` to each value and returns a new plane.
    pub(super) fn map(&self, f: impl Fn(f32) -> f32 + Sync) -> Self {
        Self { side: self.side, values: self.values.iter().map(|v| f(*v)).collect() }
    }

    /// Combines the values of two planes of equal size by `f` and returns a new plane.
    pub(super) fn with(&self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let values = self.values.iter().zip(&other.values).map(|(a, b)| f(*a, *b)).collect();
        Self { side: self.side, values }
    }

    /// Returns the value of a texel; coordinates wrap around.
    pub(super) fn at(&self, x: i64, y: i64) -> f32 {
        let wrap = |i: i64| i.rem_euclid(self.side as i64) as usize;
        self.values[wrap(y) * self.side + wrap(x)]
    }

    /// Samples bilinearly between texel centres; the tile covers 0..1 along both axes and repeats.
    pub(super) fn sample(&self, uv: Vec2) -> f32 {
        let p = uv * self.side as f32 - 0.5;
        let (cell, f) = (p.floor(), p - p.floor());
        let (x, y) = (cell.x as i64, cell.y as i64);
        let row = |y: i64| self.at(x, y) + (self.at(x + 1, y) - self.at(x, y)) * f.x;
        row(y) + (row(y + 1) - row(y)) * f.y
    }

    /// Resamples the plane to another size.
    pub(super) fn resized(&self, side: usize) -> Self {
        // Without a filter, skipped texels would cause aliasing.
        let ratio = self.side as f32 / side as f32;
        if ratio > 1.5 {
            return self.blurred(0.4 * ratio).sampled_at(side);
        }
        self.sampled_at(side)
    }

    fn sampled_at(&self, side: usize) -> Self {
        if side == self.side { self.clone() } else { Self::from_fn(side, |uv| self.sample(uv)) }
    }

    /// Applies a Gaussian blur with standard deviation `sigma` in texels; the tile repeats.
    pub(super) fn blurred(&self, sigma: f32) -> Self {
        let n = self.side;
        let mut weights = Vec::new();
        let first = gaussian_weights(0.5, (sigma * sigma).max(1e-4), &mut weights);
        let along = |from: &[f32], step: usize| {
            let mut to = vec![0.0; n * n];
            to.par_iter_mut().with_min_len(4096).enumerate().for_each(|(i, sum)| {
                let at = i / step % n;
                let start = i - at * step;
                let mut other = (at as i64 + first).rem_euclid(n as i64) as usize;
                for w in &weights {
                    *sum += w * from[start + other * step];
                    other = if other + 1 == n { 0 } else { other + 1 };
                }
            });
            to
        };
        Self { side: n, values: along(&along(&self.values, 1), n) }
    }

    /// Returns the mean value.
    pub fn mean(&self) -> f32 {
        mean_of(self.values.iter().copied(), self.values.len())
    }

    /// Returns the standard deviation.
    pub fn deviation(&self) -> f32 {
        let mean = self.mean();
        mean_of(self.values.iter().map(|v| (v - mean) * (v - mean)), self.values.len()).max(0.0).sqrt()
    }

    /// Shifts and scales the values to a mean of 0.5 and the given standard deviation, clamped to 0..=1.
    pub(super) fn balanced(&self, deviation: f32) -> Self {
        let stretch = deviation / self.deviation().max(1e-6);
        let mean = self.mean();
        let mut out = self.map(|v| 0.5 + (v - mean) * stretch);
        // Clamping the tails of a skewed histogram changes the mean again, so the shift is repeated.
        for _ in 0..8 {
            let shift = 0.5 - out.map(|v| v.clamp(0.0, 1.0)).mean();
            out = out.map(|v| v + shift);
        }
        out.map(|v| v.clamp(0.0, 1.0))
    }

    /// Replaces each value by its rank, 0..1, so that all values are equally frequent. Equal values are ranked in
    /// random order, to avoid a ramp.
    pub(super) fn equalised(&self) -> Self {
        let mut order: Vec<u32> = (0..self.values.len() as u32).collect();
        order.par_sort_unstable_by(|a, b| {
            let by_value = self.values[*a as usize].total_cmp(&self.values[*b as usize]);
            by_value.then_with(|| (hash(0, (*a).into()), a).cmp(&(hash(0, (*b).into()), b)))
        });
        let mut values = vec![0.0; order.len()];
        for (rank, i) in order.iter().enumerate() {
            values[*i as usize] = (rank as f32 + 0.5) / order.len() as f32;
        }
        Self { side: self.side, values }
    }

    /// Halves the size by averaging 2 × 2 texels.
    fn halved(&self) -> Self {
        let n = self.side / 2;
        let mean = |x: usize, y: usize| {
            let row = |y: usize| self.values[y * self.side + 2 * x] + self.values[y * self.side + 2 * x + 1];
            0.25 * (row(2 * y) + row(2 * y + 1))
        };
        Self { side: n, values: (0..n * n).map(|i| mean(i % n, i / n)).collect() }
    }
}

/// Meaning of a channel, which determines how its mips are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channel {
    /// Plain quantity: the texels of mips are means.
    Value,
    /// Threshold for comparisons. All values are equally frequent in every mip, so that the same share of texels passes
    /// at any distance. Plain means would concentrate around the middle, so that all texels would pass or none.
    Threshold,
}

/// Returns RGBA bytes of all mip levels, finest first, down to one texel. All planes are square, with the same
/// power-of-two side.
pub(super) fn levels(planes: [Plane; 4], channels: [Channel; 4]) -> Vec<Vec<u8>> {
    let mut planes = planes;
    let mut out = Vec::new();
    loop {
        let shown: Vec<_> = planes
            .iter()
            .zip(channels)
            .map(|(plane, channel)| if channel == Channel::Threshold { plane.equalised() } else { plane.clone() })
            .collect();
        let byte = |v: f32| (255.0 * v.clamp(0.0, 1.0) + 0.5) as u8;
        let texels = 0..shown[0].values.len();
        out.push(texels.flat_map(|i| [0, 1, 2, 3].map(|c: usize| byte(shown[c].values[i]))).collect());
        if planes[0].side <= 1 {
            return out;
        }
        planes = planes.map(|plane| plane.halved());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(side: usize) -> Plane {
        Plane { side, values: (0..side * side).map(|i| (i * 37 % 101) as f32 / 100.0).collect() }
    }

    #[test]
    fn ranks_are_uniform_in_every_mip_level() {
        let plane = ramp(16);
        let channels = [Channel::Value, Channel::Threshold, Channel::Value, Channel::Value];
        let levels = levels([plane.clone(), plane.clone(), plane.clone(), plane.clone()], channels);
        assert_eq!(levels.iter().map(Vec::len).collect::<Vec<_>>(), [1024, 256, 64, 16, 4]);
        for level in &levels[..4] {
            let mut ranks: Vec<_> = level.chunks_exact(4).map(|t| t[1]).collect();
            ranks.sort_unstable();
            for (i, rank) in ranks.iter().enumerate() {
                assert!((f32::from(*rank) - 255.0 * (i as f32 + 0.5) / ranks.len() as f32).abs() <= 1.0);
            }
        }
        assert!((f32::from(levels[4][0]) - 255.0 * plane.mean()).abs() < 1.0);
    }

    #[test]
    fn equal_values_are_ranked_without_a_gradient() {
        let ranks = Plane::from_fn(32, |_| 0.3).equalised();
        let half =
            |rows: std::ops::Range<usize>| ranks.values[32 * rows.start..32 * rows.end].iter().sum::<f32>() / 512.0;
        assert!((half(0..16) - half(16..32)).abs() < 0.1, "{} {}", half(0..16), half(16..32));
    }

    #[test]
    fn balanced_planes_have_mean_one_half() {
        let lopsided = ramp(32).map(|v| v.powi(6));
        for deviation in [0.05, 0.2, 0.45] {
            let plane = lopsided.balanced(deviation);
            assert!((plane.mean() - 0.5).abs() < 0.01, "{} at {deviation}", plane.mean());
            assert!(plane.values.iter().all(|v| (0.0..=1.0).contains(v)));
        }
        // Scaling must not divide by zero: a constant plane has no deviation.
        assert!((ramp(8).map(|_| 3.0).balanced(0.2).mean() - 0.5).abs() < 1e-3);
    }

    #[test]
    fn blur_wraps_at_the_borders_and_keeps_the_sum() {
        let mut plane = Plane { side: 16, values: vec![0.0; 256] };
        plane.values[0] = 1.0;
        let blurred = plane.blurred(1.5);
        assert!((blurred.mean() * 256.0 - 1.0).abs() < 1e-4);
        assert!((blurred.at(-1, 0) - blurred.at(1, 0)).abs() < 1e-6 && blurred.at(-1, 0) > 0.01);
        assert!((blurred.at(0, -2) - blurred.at(2, 0)).abs() < 1e-6);
    }
}
