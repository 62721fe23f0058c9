//! Painting an image such that whoever reads it at the vertices finds what they had.
//!
//! Painted as it lies between the vertices, a ridge at a vertex comes out lower than it is: a reader mixes four texels, and those beside the ridge
//! are below it. So what is missing is added and painted again, a few times (Richardson's iteration). It ends where triangles are much larger than
//! texels after two or three rounds; where they are smaller, no image could tell the vertices apart, and the best that was found is taken.

use crate::stages::groom::canvas::Canvas;
use glam::{Vec2, Vec4};

/// Rounds at most.
const ROUNDS: usize = 12;
/// Good enough: a tenth of what rounding to bytes costs.
const ENOUGH: f32 = 0.05 / 255.0;

/// An image, and who reads it where.
pub(super) struct Reading<'a> {
    pub(super) canvas: &'a Canvas,
    /// Width and height, texels.
    pub(super) side: u32,
    /// For each triangle's corners the number of who reads the image there.
    pub(super) places: &'a [[u32; 3]],
    /// Where each of those reads it; who reads it at several takes the mean.
    pub(super) uvs: &'a [Vec<Vec2>],
}

impl Reading<'_> {
    /// Texels from which readers find the mean of what `corners` have there, and the greatest difference that is left.
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
                // Who reads what another paints cannot be helped, and must not run away.
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
            let weights = spot.inside().weights;
            (a * weights.x + b * weights.y + c * weights.z).clamp(Vec4::ZERO, Vec4::ONE)
        })
    }

    /// The mean of the image at some places: bilinear, repeating beyond its borders, as maps of a groom are read.
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
