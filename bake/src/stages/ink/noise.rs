//! Smooth noise on a repeating tile.

use crate::noise::{hash, smooth};
use glam::{UVec2, Vec2};

/// Returns the random gradient of a lattice point, each component in -1..1.
fn lattice_gradient(seed: u64, x: u32, y: u32) -> Vec2 {
    let h = hash(seed, u64::from(y) << 32 | u64::from(x));
    let component = |shift: u32| ((h >> shift) & 0xff_ffff) as f32 / (1 << 23) as f32 - 1.0;
    Vec2::new(component(0), component(24))
}

/// Returns gradient noise (Perlin 1985, with the smooth weights of 2002), roughly within -1..1 and 0 on average. The
/// period is 1 along both axes; each period has `cells` lattice points.
pub(super) fn gradient(seed: u64, p: Vec2, cells: UVec2) -> f32 {
    let q = p * cells.as_vec2();
    let cell = q.floor();
    let f = q - cell;
    let wrap = |i: f32, n: u32| (i as i64).rem_euclid(i64::from(n.max(1))) as u32;
    let at = |i: u32, j: u32| {
        let slope = lattice_gradient(seed, wrap(cell.x + i as f32, cells.x), wrap(cell.y + j as f32, cells.y));
        slope.dot(f - Vec2::new(i as f32, j as f32))
    };
    let w = f.map(smooth);
    let row = |j: u32| at(0, j) + (at(1, j) - at(0, j)) * w.x;
    1.6 * (row(0) + (row(1) - row(0)) * w.y)
}

/// Sums octaves of [`gradient`]. Each octave has twice the cells and `gain` times the strength of the one before. The
/// sum is scaled to the strength of a single octave.
pub(super) fn octaves(seed: u64, p: Vec2, cells: UVec2, count: u32, gain: f32) -> f32 {
    let (mut sum, mut power, mut weight) = (0.0, 0.0, 1.0f32);
    for octave in 0..count {
        sum += weight * gradient(hash(seed, u64::from(octave)), p, cells << octave);
        power += weight * weight;
        weight *= gain;
    }
    sum / power.sqrt().max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_tiles_and_is_smooth() {
        let cells = UVec2::new(5, 7);
        for i in 0..200 {
            let p = Vec2::new(i as f32 * 0.0371, i as f32 * 0.0173).fract();
            let value = octaves(3, p, cells, 3, 0.5);
            for step in [Vec2::X, Vec2::Y, -Vec2::X] {
                assert!((octaves(3, p + step, cells, 3, 0.5) - value).abs() < 1e-3, "at {p}");
            }
            assert!((octaves(3, p + Vec2::splat(1e-4), cells, 3, 0.5) - value).abs() < 0.05, "at {p}");
            assert!(value.abs() < 3.0);
        }
    }
}
