//! Rays through the strands of a tile that repeats.

use crate::stages::hair::Strands;
use glam::{Vec2, Vec3};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Tiles that a ray goes aside at most.
const LONGEST: f32 = 8.0;

/// A piece of a strand: a round stick that tapers.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: Vec3,
    to: Vec3,
    radii: [f32; 2],
    strand: u32,
}

impl Boundable for Piece {
    fn aabb(&self) -> Aabb {
        let radius = self.radii[0].max(self.radii[1]) + 1e-6;
        Aabb::new((self.from.min(self.to) - radius).into(), (self.from.max(self.to) + radius).into())
    }
}

impl Piece {
    /// Whether the ray, of unit direction, meets it: where the two come nearest, they are nearer than its radius.
    fn hides(&self, origin: Vec3, way: Vec3, reach: f32) -> bool {
        let axis = self.to - self.from;
        let from = origin - self.from;
        let (length, along, from_axis, from_way) = (axis.dot(axis), axis.dot(way), axis.dot(from), way.dot(from));
        let across = length - along * along;
        // Along each other every place is as near as another.
        let share =
            if across > 1e-6 * length { ((from_axis - along * from_way) / across).clamp(0.0, 1.0) } else { 0.5 };
        let place = self.from + axis * share;
        let distance = way.dot(place - origin);
        let radius = self.radii[0] + (self.radii[1] - self.radii[0]) * share;
        distance > 0.0
            && distance <= reach + 1e-6
            && (origin + way * distance).distance_squared(place) < radius * radius
    }
}

/// All strands of a tile.
pub(super) struct Rays {
    /// In the order of the tree's leaves.
    pieces: Vec<Piece>,
    tree: Option<CwBvh>,
    /// Where the strands of one tile lie, neighbours left out.
    low: Vec2,
    high: Vec2,
    top: f32,
}

impl Rays {
    pub(super) fn new(strands: &Strands) -> Self {
        let mut pieces = Vec::new();
        for strand in 0..strands.len() {
            let range = strands.range(strand);
            pieces.extend((range.start..range.end.saturating_sub(1)).map(|i| Piece {
                from: strands.points[i],
                to: strands.points[i + 1],
                radii: [strands.radii[i], strands.radii[i + 1]],
                strand: strand as u32,
            }));
        }
        let boxes = || pieces.iter().map(Boundable::aabb);
        let low = boxes().fold(Vec2::splat(f32::INFINITY), |low, b| low.min(Vec3::from(b.min).truncate()));
        let high = boxes().fold(Vec2::splat(f32::NEG_INFINITY), |high, b| high.max(Vec3::from(b.max).truncate()));
        let top = boxes().fold(0.0, |top: f32, b| top.max(b.max.z));
        let tree = (!pieces.is_empty())
            .then(|| build_cwbvh(&pieces, BvhBuildParams::medium_build(), &mut Duration::default()));
        if let Some(tree) = &tree {
            pieces = tree.primitive_indices.iter().map(|i| pieces[*i as usize]).collect();
        }
        Self { pieces, tree, low, high, top }
    }

    /// Whether a distant light in the direction `way`, of unit length and upwards, is seen from `origin` past all strands but `own`. Copies of `own` in
    /// other tiles are others. What has not come out of the hair after [`LONGEST`] tiles is hidden.
    pub(super) fn lit(&self, origin: Vec3, way: Vec3, own: Option<u32>) -> bool {
        let reach = ((self.top - origin.z) / way.z).max(0.0);
        let aside = reach * way.truncate().length();
        // Tile after tile: most rays end near where they begin.
        let steps = aside.ceil().clamp(1.0, LONGEST);
        let step = if aside > LONGEST { LONGEST / aside } else { 1.0 } * reach / steps;
        let free = |n: u16| self.free(origin + way * (step * f32::from(n)), way, step, own);
        (0..steps as u16).all(free) && aside <= LONGEST
    }

    /// Whether there is nothing between `origin` and what is `reach` away.
    fn free(&self, origin: Vec3, way: Vec3, reach: f32, own: Option<u32>) -> bool {
        let Some(tree) = &self.tree else { return true };
        let end = origin + way * reach;
        // Copies of the tile that the way may cross.
        let (from, to) = (origin.min(end).truncate() - self.high, origin.max(end).truncate() - self.low);
        let (first, last) = (from.ceil().as_ivec2(), to.floor().as_ivec2());
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let shifted = origin - Vec3::new(x as f32, y as f32, 0.0);
                let own = own.filter(|_| x == 0 && y == 0);
                let ray = Ray::new(shifted.into(), way.into(), 0.0, reach + 1e-6);
                let free = tree.ray_traverse_miss(ray, |_, id| {
                    let piece = &self.pieces[id];
                    if Some(piece.strand) != own && piece.hides(shifted, way, reach) { 0.0 } else { f32::INFINITY }
                });
                if !free {
                    return false;
                }
            }
        }
        true
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    /// One strand, upright at the middle of the tile.
    fn pole() -> Strands {
        Strands {
            points: vec![Vec3::new(0.5, 0.5, 0.0), Vec3::new(0.5, 0.5, 0.5)],
            radii: vec![0.02, 0.02],
            colors: vec![Vec3::ONE; 2],
            offsets: vec![0, 2],
            height: 0.5,
            root_color: Vec3::ONE,
        }
    }

    #[test]
    fn a_pole_hides_what_is_behind_it_in_each_tile() {
        let rays = Rays::new(&pole());
        let towards = |x: f32, z: f32| Vec3::new(x, 0.0, z).normalize();
        let lit = |x: f32, y: f32, way: Vec3, own| rays.lit(Vec3::new(x, y, 0.1), way, own);
        assert!(!lit(0.2, 0.5, towards(1.0, 0.2), None), "the pole stands in the way");
        assert!(lit(0.2, 0.5, towards(1.0, 2.0), None), "the ray passes above it");
        assert!(lit(0.2, 0.6, towards(1.0, 0.2), None), "the ray passes beside it");
        assert!(!lit(0.8, 0.5, towards(1.0, 0.2), None), "that of the next tile");
        assert!(!lit(-2.2, 0.5, towards(1.0, 0.2), None), "places beyond the tile are places of it");
        assert!(lit(0.5, 0.5, towards(1.0, 1.0), Some(0)), "its own strand hides nothing");
        assert!(!lit(0.5, 0.5, towards(1.0, 0.2), Some(0)), "but its copy in the next tile does");
        assert!(lit(0.2, 0.5, Vec3::Z, None));
        assert!(Rays::new(&Strands::default()).lit(Vec3::ZERO, Vec3::Z, None));
    }
}
