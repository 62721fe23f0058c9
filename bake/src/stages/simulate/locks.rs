//! Locks: wet hair sticks together, as do the tips of thick dry fur. So the strands of a tile gather into pointed
//! locks.
//!
//! Each strand belongs to the lock whose centre is nearest to its root in the periodic tile. A lock has an axis, a
//! curve that grows from its centre as a strand would. Strands of the lock steer onto the axis while they grow, and
//! follow it from then on. Because short strands end first, a lock tapers to a point.

use super::styles::StyleForces;
use crate::noise::{hash, stratified, uniform, vector};
use crate::recipe::HairParams;
use glam::{Vec2, Vec3};

/// Approximate distance between lock centres if the recipe does not set the number of locks, as a share of the hair's
/// length.
const SPACING_PER_LENGTH: f32 = 0.5;
/// Minimum number of strands per lock if the recipe does not set the number of locks. Fewer strands do not look like a
/// lock.
const LEAST_STRANDS: u32 = 8;

pub(super) struct Locks {
    seed: u64,
    count: u32,
    /// Number of cells along u and along v in the grid `cells`, which covers the tile.
    side: usize,
    /// Indices of the locks with their centre in each cell, row by row.
    cells: Vec<Vec<u32>>,
}

/// Lock that a strand belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lock {
    pub(super) index: u32,
    /// Centre of the lock: the periodic copy nearest to the root, not wrapped into the tile.
    pub(super) center: Vec2,
}

pub(super) fn forms_locks(params: &HairParams) -> bool {
    StyleForces::of(params.style).wet || params.dry_clump > 0.0
}

impl Locks {
    /// Creates the locks for guard hair that is `height` tile widths long; `None` if its hairs do not gather.
    pub(super) fn for_guard_hair(guard: &HairParams, height: f32) -> Option<Self> {
        forms_locks(guard).then(|| Self::new(guard.seed, guard.clump_count, guard.density, height))
    }

    /// Creates `count` locks. If `count` is `None`, the number of locks suits `density` strands of length `height`
    /// (tile widths).
    pub(super) fn new(seed: u64, count: Option<u32>, density: u32, height: f32) -> Self {
        let spacing = SPACING_PER_LENGTH * height;
        let suits = ((spacing * spacing).recip().round().min(1e9) as u32).min(density / LEAST_STRANDS);
        let count = count.unwrap_or(suits).clamp(1, density.max(1));
        let side = (f64::from(count).sqrt() as usize).max(1);
        let mut locks = Self { seed: hash(seed, u64::MAX - 3), count, side, cells: vec![Vec::new(); side * side] };
        for index in 0..count {
            let center = locks.center(index);
            let cell = |x: f32| ((x * side as f32) as usize).min(side - 1);
            locks.cells[cell(center.y) * side + cell(center.x)].push(index);
        }
        locks
    }

    fn center(&self, index: u32) -> Vec2 {
        stratified(self.seed, index, self.count)
    }

    pub(super) fn lock_at(&self, root: Vec2) -> Lock {
        // Centres are stratified, so each root has a centre in its own stratum, less than two grid cells away.
        const REACH: i64 = 2;
        let side = self.side as i64;
        let cell = (root * self.side as f32).floor();
        let mut best = Lock { index: 0, center: nearest_copy(self.center(0), root) };
        for (dx, dy) in (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy))) {
            let x = (cell.x as i64 + dx).rem_euclid(side);
            let y = (cell.y as i64 + dy).rem_euclid(side);
            for index in &self.cells[(y * side + x) as usize] {
                let center = nearest_copy(self.center(*index), root);
                if center.distance_squared(root) < best.center.distance_squared(root) {
                    best = Lock { index: *index, center };
                }
            }
        }
        best
    }

    /// Returns a lock's tilt, a vector with components in -1..1.
    pub(super) fn tilt(&self, index: u32) -> Vec3 {
        vector(self.seed, 2 << 32 | u64::from(index))
    }

    /// Returns a lock's brightness, in -1..1.
    pub(super) fn brightness(&self, index: u32) -> f32 {
        2.0 * uniform(self.seed, 3 << 32 | u64::from(index)) - 1.0
    }
}

/// Returns the copy of a point of the periodic tile that is nearest to `to`.
fn nearest_copy(point: Vec2, to: Vec2) -> Vec2 {
    point - (point - to).round()
}

/// Returns the heading that brings a strand at `position` onto the axis of its lock before the strand ends.
///
/// * `axis`: current point of the axis
/// * `axis_heading`: direction of the axis at that point
/// * `left`: remaining length of the strand
///
/// The distance from the axis shrinks in proportion to the square of the remaining length.
pub(super) fn heading_into_lock(position: Vec3, axis: Vec3, axis_heading: Vec3, left: f32) -> Vec3 {
    let pull = (axis - position) * (2.0 / left);
    // A strand far from its lock's axis runs towards it along the mesh surface, but never turns back below the surface.
    axis_heading + pull.clamp_length_max(1.6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_finds_the_nearest_lock_across_tile_borders() {
        for count in [1, 2, 3, 5, 8, 40, 121, 300] {
            let locks = Locks::new(7, Some(count), 5000, 0.4);
            for i in 0..400 {
                let root = stratified(3, i, 400);
                let found = locks.lock_at(root).center.distance(root);
                let nearest = (0..count).map(|k| nearest_copy(locks.center(k), root).distance(root));
                assert_eq!(found, nearest.fold(f32::INFINITY, f32::min), "{count} locks, root {root}");
            }
        }
    }

    #[test]
    fn default_lock_count_suits_density_and_height() {
        let count = |density, height| Locks::new(1, None, density, height).count;
        assert_eq!(count(1000, 0.4), 25);
        assert_eq!(count(1000, 0.01), 1000 / LEAST_STRANDS);
        assert_eq!((count(1, 0.4), count(1_000_000, 1e3), Locks::new(1, Some(99), 5, 0.4).count), (1, 1, 5));
    }
}
