//! Smooth noise on a repeating tile.

use super::plane::Plane;
use crate::noise::{hash, smooth};
use glam::{UVec2, Vec2};
use rayon::prelude::*;

/// Gradient noise (Perlin 1985, with the smooth weights of 2002), roughly within -1..1 and 0 on average. The period is
/// 1 along both axes. Each period has `cells` lattice points, whose random gradients are computed once.
pub(super) struct Gradient {
    cells: UVec2,
    /// Gradients of the lattice points, row by row, each component in -1..1.
    slopes: Vec<Vec2>,
}

impl Gradient {
    pub(super) fn new(seed: u64, cells: UVec2) -> Self {
        let cells = cells.max(UVec2::ONE);
        let slope = |x: u32, y: u32| {
            let h = hash(seed, u64::from(y) << 32 | u64::from(x));
            let component = |shift: u32| ((h >> shift) & 0xff_ffff) as f32 / (1 << 23) as f32 - 1.0;
            Vec2::new(component(0), component(24))
        };
        let slopes = (0..cells.y).flat_map(|y| (0..cells.x).map(move |x| slope(x, y))).collect();
        Self { cells, slopes }
    }

    /// Returns the noise at a point.
    pub(super) fn at(&self, p: Vec2) -> f32 {
        self.at_position(LatticePosition::new(p.x, self.cells.x), LatticePosition::new(p.y, self.cells.y))
    }

    fn at_position(&self, x: LatticePosition, y: LatticePosition) -> f32 {
        let along = |row: u32, dy: f32| {
            let slope =
                |column: u32, dx: f32| self.slopes[(row * self.cells.x + column) as usize].dot(Vec2::new(dx, dy));
            let low = slope(x.low, x.share);
            low + (slope(x.high, x.share - 1.0) - low) * x.weight
        };
        let low = along(y.low, y.share);
        1.6 * (low + (along(y.high, y.share - 1.0) - low) * y.weight)
    }
}

/// Position along an axis: the lattice points on both sides, the share of the way between them, and its smooth weight.
#[derive(Clone, Copy)]
struct LatticePosition {
    low: u32,
    high: u32,
    share: f32,
    weight: f32,
}

impl LatticePosition {
    fn new(p: f32, cells: u32) -> Self {
        let q = p * cells as f32;
        let cell = q.floor();
        let low = (cell as i64).rem_euclid(i64::from(cells)) as u32;
        let share = q - cell;
        Self { low, high: if low + 1 == cells { 0 } else { low + 1 }, share, weight: smooth(share) }
    }
}

/// Sum of octaves of [`Gradient`]. Each octave has twice the cells and `gain` times the strength of the one before. The
/// sum is scaled to the strength of a single octave.
pub(super) struct Octaves {
    /// Weight and noise of each octave.
    octaves: Vec<(f32, Gradient)>,
    /// Strength of the sum before it is scaled.
    strength: f32,
}

impl Octaves {
    pub(super) fn new(seed: u64, cells: UVec2, count: u32, gain: f32) -> Self {
        let (mut octaves, mut power, mut weight) = (Vec::new(), 0.0, 1.0f32);
        for octave in 0..count {
            octaves.push((weight, Gradient::new(hash(seed, u64::from(octave)), cells << octave)));
            power += weight * weight;
            weight *= gain;
        }
        Self { octaves, strength: power.sqrt().max(1e-6) }
    }

    /// Returns the noise at a point.
    pub(super) fn at(&self, p: Vec2) -> f32 {
        self.octaves.iter().fold(0.0, |sum, (weight, noise)| sum + weight * noise.at(p)) / self.strength
    }

    /// Evaluates the noise at the centre of every texel.
    pub(super) fn plane(&self, side: usize) -> Plane {
        let mut plane = Plane::empty(side);
        for (weight, noise) in &self.octaves {
            let position = |i: usize, cells: u32| LatticePosition::new((i as f32 + 0.5) / side as f32, cells);
            let columns: Vec<LatticePosition> = (0..side).map(|x| position(x, noise.cells.x)).collect();
            plane.values.par_chunks_mut(side).enumerate().for_each(|(y, row)| {
                let y = position(y, noise.cells.y);
                row.iter_mut().zip(&columns).for_each(|(sum, x)| *sum += weight * noise.at_position(*x, y));
            });
        }
        plane.map(|sum| sum / self.strength)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_tiles_and_is_smooth() {
        let noise = Octaves::new(3, UVec2::new(5, 7), 3, 0.5);
        for i in 0..200 {
            let p = Vec2::new(i as f32 * 0.0371, i as f32 * 0.0173).fract();
            let value = noise.at(p);
            for step in [Vec2::X, Vec2::Y, -Vec2::X] {
                assert!((noise.at(p + step) - value).abs() < 1e-3, "at {p}");
            }
            assert!((noise.at(p + Vec2::splat(1e-4)) - value).abs() < 0.05, "at {p}");
            assert!(value.abs() < 3.0);
        }
    }
}
