//! Rays through the strands of a periodic tile.

use crate::stages::simulate::Strands;
use glam::{Vec2, Vec3};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Maximum horizontal length of a ray, tile widths.
const MAX_TILES: f32 = 8.0;

/// Segment of a strand: a tapered cylinder.
#[derive(Clone, Copy, Debug)]
struct StrandSegment {
    from: Vec3,
    to: Vec3,
    radii: [f32; 2],
    strand: u32,
}

impl Boundable for StrandSegment {
    fn aabb(&self) -> Aabb {
        let radius = self.radii[0].max(self.radii[1]) + 1e-6;
        Aabb::new((self.from.min(self.to) - radius).into(), (self.from.max(self.to) + radius).into())
    }
}

impl StrandSegment {
    /// Returns whether a ray with unit direction hits the segment: whether its smallest distance from the segment's
    /// axis is below the segment's radius there.
    fn is_hit(&self, origin: Vec3, way: Vec3, reach: f32) -> bool {
        let axis = self.to - self.from;
        let from = origin - self.from;
        let (length, along, from_axis, from_way) = (axis.dot(axis), axis.dot(way), axis.dot(from), way.dot(from));
        let across = length - along * along;
        // If ray and segment are parallel, all points of the segment are equally near to the ray.
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

/// All strands of a tile in an acceleration structure for ray tracing.
pub(super) struct StrandTree {
    /// Segments in the order of the tree's leaves.
    pieces: Vec<StrandSegment>,
    tree: Option<CwBvh>,
    /// Lower corner of the bounds of one tile's strands, without neighbouring tiles; [`Self::high`] is the upper
    /// corner.
    low: Vec2,
    high: Vec2,
    top: f32,
}

impl StrandTree {
    pub(super) fn new(strands: &Strands) -> Self {
        let mut pieces = Vec::new();
        for strand in 0..strands.len() {
            let range = strands.range(strand);
            pieces.extend((range.start..range.end.saturating_sub(1)).map(|i| StrandSegment {
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

    /// Returns whether a distant light is visible from `origin` past all strands except `own`. `way` is the unit
    /// direction towards the light and points upwards. Copies of `own` in other tiles count as other strands. A ray
    /// that is still inside the hair after [`MAX_TILES`] tiles counts as blocked.
    pub(super) fn is_lit(&self, origin: Vec3, way: Vec3, own: Option<u32>) -> bool {
        let reach = ((self.top - origin.z) / way.z).max(0.0);
        let aside = reach * way.truncate().length();
        // The ray is traced tile by tile, because most rays end near their start.
        let steps = aside.ceil().clamp(1.0, MAX_TILES);
        let step = if aside > MAX_TILES { MAX_TILES / aside } else { 1.0 } * reach / steps;
        let free = |n: u16| self.is_clear(origin + way * (step * f32::from(n)), way, step, own);
        (0..steps as u16).all(free) && aside <= MAX_TILES
    }

    /// Returns whether nothing is between `origin` and the point at distance `reach`.
    fn is_clear(&self, origin: Vec3, way: Vec3, reach: f32, own: Option<u32>) -> bool {
        let Some(tree) = &self.tree else { return true };
        let end = origin + way * reach;
        // Copies of the tile that the ray may cross.
        let (from, to) = (origin.min(end).truncate() - self.high, origin.max(end).truncate() - self.low);
        let (first, last) = (from.ceil().as_ivec2(), to.floor().as_ivec2());
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                let shifted = origin - Vec3::new(x as f32, y as f32, 0.0);
                let own = own.filter(|_| x == 0 && y == 0);
                let ray = Ray::new(shifted.into(), way.into(), 0.0, reach + 1e-6);
                let free = tree.ray_traverse_miss(ray, |_, id| {
                    let piece = &self.pieces[id];
                    if Some(piece.strand) != own && piece.is_hit(shifted, way, reach) { 0.0 } else { f32::INFINITY }
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
mod tests {
    use super::*;

    /// Makes one strand, upright in the middle of the tile.
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
    fn pole_casts_shadows_in_every_tile() {
        let rays = StrandTree::new(&pole());
        let towards = |x: f32, z: f32| Vec3::new(x, 0.0, z).normalize();
        let lit = |x: f32, y: f32, way: Vec3, own| rays.is_lit(Vec3::new(x, y, 0.1), way, own);
        assert!(!lit(0.2, 0.5, towards(1.0, 0.2), None), "the pole stands in the way");
        assert!(lit(0.2, 0.5, towards(1.0, 2.0), None), "the ray passes above it");
        assert!(lit(0.2, 0.6, towards(1.0, 0.2), None), "the ray passes beside it");
        assert!(!lit(0.8, 0.5, towards(1.0, 0.2), None), "the pole of the next tile stands in the way");
        assert!(!lit(-2.2, 0.5, towards(1.0, 0.2), None), "positions outside the tile wrap around");
        assert!(lit(0.5, 0.5, towards(1.0, 1.0), Some(0)), "its own strand hides nothing");
        assert!(!lit(0.5, 0.5, towards(1.0, 0.2), Some(0)), "but its copy in the next tile does");
        assert!(lit(0.2, 0.5, Vec3::Z, None));
        assert!(StrandTree::new(&Strands::default()).is_lit(Vec3::ZERO, Vec3::Z, None));
    }
}
