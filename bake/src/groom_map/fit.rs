//! Paints an image such that sampling it at the vertices returns the vertices' values.
//!
//! Plain interpolation flattens ridges: a bilinear lookup at a vertex also mixes in the lower texels beside it. So the
//! residual is added to the values and the image is painted again, a few times (Richardson iteration). If triangles are
//! much larger than texels, two or three rounds are enough. If they are smaller, no image can reproduce all vertex
//! values, and the best round is used.

use crate::stages::groom::canvas::Canvas;
use glam::{Vec2, Vec4};

/// Maximum number of rounds.
const ROUNDS: usize = 12;
/// Error at which the iteration stops: a tenth of the error of rounding to bytes.
const ENOUGH: f32 = 0.05 / 255.0;

/// Image to paint, and the points at which it is sampled.
pub(super) struct SampledImage<'a> {
    pub(super) canvas: &'a Canvas,
    /// Width and height, texels.
    pub(super) side: u32,
    /// Index of the sample at each corner of each triangle.
    pub(super) places: &'a [[u32; 3]],
    /// Texture coordinates of each sample. If a sample has several, it is the mean of the image at all of them.
    pub(super) uvs: &'a [Vec<Vec2>],
}

impl SampledImage<'_> {
    /// Returns the fitted texels and the largest remaining error. `corners` holds the values at the corners of each
    /// triangle. The target of a sample is the mean of all corner values that belong to it.
    pub(super) fn fitted(&self, corners: &[[Vec4; 3]]) -> (Vec<Vec4>, f32) {
        let targets = self.targets(corners);
        let mut values = targets.clone();
        let mut best = (Vec::new(), f32::INFINITY);
        for _ in 0..ROUNDS {
            let texels = self.paint(&values);
            let mut worst = 0.0f32;
            for ((value, target), uvs) in values.iter_mut().zip(&targets).zip(self.uvs) {
                let missing = *target - self.read(&texels, uvs);
                worst = worst.max(missing.abs().max_element());
                // Samples that share texels cannot all be matched. Clamping keeps the iteration from diverging.
                *value = (*value + missing).clamp(Vec4::splat(-1.0), Vec4::splat(2.0));
            }
            let settled = worst > 0.98 * best.1;
            if worst < best.1 {
                best = (texels, worst);
            }
            if worst <= ENOUGH || settled {
                break;
            }
        }
        best
    }

    fn targets(&self, corners: &[[Vec4; 3]]) -> Vec<Vec4> {
        let mut sums = vec![(Vec4::ZERO, 0.0f32); self.uvs.len()];
        for (values, places) in corners.iter().zip(self.places) {
            for (value, place) in values.iter().zip(places) {
                let (sum, count) = &mut sums[*place as usize];
                (*sum, *count) = (*sum + *value, *count + 1.0);
            }
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(1.0)).collect()
    }

    fn paint(&self, values: &[Vec4]) -> Vec<Vec4> {
        self.canvas.paint(|spot, _| {
            let [a, b, c] = self.places[spot.triangle].map(|place| values[place as usize]);
            let weights = spot.clamped().weights;
            (a * weights.x + b * weights.y + c * weights.z).clamp(Vec4::ZERO, Vec4::ONE)
        })
    }

    /// Returns the mean of the image at `uvs`, sampled like a groom map: bilinear and repeating.
    fn read(&self, texels: &[Vec4], uvs: &[Vec2]) -> Vec4 {
        let n = i64::from(self.side);
        let one = |uv: &Vec2| {
            let at = (*uv - uv.floor()) * self.side as f32 - 0.5;
            let (corner, f) = (at.floor(), at - at.floor());
            let texel = |dx: i64, dy: i64| {
                let (x, y) = ((corner.x as i64 + dx).rem_euclid(n), (corner.y as i64 + dy).rem_euclid(n));
                texels[(y * n + x) as usize]
            };
            texel(0, 0).lerp(texel(1, 0), f.x).lerp(texel(0, 1).lerp(texel(1, 1), f.x), f.y)
        };
        uvs.iter().filter(|uv| uv.is_finite()).map(one).sum::<Vec4>() / uvs.len().max(1) as f32
    }
}
