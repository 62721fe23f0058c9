//! Bounding volume hierarchy of triangles, for rays and for nearest triangles.
//!
//! A sliver has a box far larger than itself, and a mesh of slivers, such as a fan of thousands of triangles, has a box
//! of nearly every triangle at every point. Such triangles are split into several boxes.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::Ray;
use obvhs::splits::split_aabbs_precise;
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Half the surface area of a box, relative to the mean area of a triangle, above which the box may be split. Boxes of
/// ordinary triangles are far smaller.
const SPLIT_AREA: f32 = 64.0;
/// Approximate limit of the mean number of boxes per triangle, for meshes of slivers. It assumes that k boxes of a
/// sliver have 1/k² of the area of its single box each.
const MOST_BOXES: f32 = 8.0;
/// Limits of the search for splits: rounds, each of which may double the boxes; and tried positions of a split.
const SPLIT_ROUNDS: u32 = 10;
const SPLIT_POSITIONS: u32 = 8;

/// Returns boxes that cover the triangles, and the triangle of each box.
fn split_boxes(triangles: &[Triangle]) -> (Vec<Aabb>, Vec<u32>) {
    let mut boxes: Vec<Aabb> = triangles.iter().map(Boundable::aabb).collect();
    let mut triangle_of: Vec<u32> = (0..triangles.len() as u32).collect();
    let mean = |values: &mut dyn Iterator<Item = f32>| {
        (values.map(f64::from).sum::<f64>() / triangles.len().max(1) as f64) as f32
    };
    let area = |t: &Triangle| (t.v1 - t.v0).cross(t.v2 - t.v0).length() / 2.0;
    let mean_area = mean(&mut triangles.iter().map(area));
    let mean_root = mean(&mut boxes.iter().map(|b| b.half_area().sqrt()));
    let root = mean_root / MOST_BOXES;
    let largest = (SPLIT_AREA * mean_area).max(root * root);
    if largest.is_finite() && largest > 0.0 {
        // Both factors ask for the same gain, so that the second threshold has no effect.
        let gain = 1.6;
        split_aabbs_precise(
            &mut boxes,
            &mut triangle_of,
            triangles,
            largest,
            largest,
            gain,
            gain,
            SPLIT_ROUNDS,
            SPLIT_POSITIONS,
        );
    }
    (boxes, triangle_of)
}

/// Triangles that block rays, on both sides.
pub(crate) struct Occluders {
    tree: CwBvh,
    /// Triangle of each primitive of the tree.
    facets: Vec<Triangle>,
}

impl Occluders {
    pub(crate) fn new(triangles: &[Triangle]) -> Self {
        let (boxes, triangle_of) = split_boxes(triangles);
        let tree = build_cwbvh(&boxes, BvhBuildParams::fast_build(), &mut Duration::default());
        let facets = tree.primitive_indices.iter().map(|i| triangles[triangle_of[*i as usize] as usize]).collect();
        Self { tree, facets }
    }

    /// Whether no triangle blocks the ray from a point in a direction.
    pub(crate) fn is_open(&self, from: Vec3, way: Vec3) -> bool {
        let ray = Ray::new(from.into(), way.into(), 0.0, f32::INFINITY);
        self.tree.ray_traverse_miss(ray, |ray, id| self.facets[id].intersect(ray))
    }
}

/// Triangles, searched by distance.
pub(crate) struct TriangleTree {
    tree: Bvh2,
    /// Triangle of each box.
    triangle_of: Vec<u32>,
}

impl TriangleTree {
    pub(crate) fn new(triangles: &[Triangle]) -> Self {
        let (boxes, triangle_of) = split_boxes(triangles);
        let tree = build_bvh2(&boxes, BvhBuildParams::very_fast_build(), &mut Duration::default());
        Self { tree, triangle_of }
    }

    /// Returns the minimum of `measure` over all triangles; infinite if there are none.
    ///
    /// * `measure`: arguments are a triangle and the minimum so far; returns at least the squared distance between `p`
    ///   and the triangle. If the result exceeds the minimum so far, any larger value is right. It is not called for
    ///   triangles that are too far away, and may be called several times for others.
    pub(crate) fn minimum(&self, p: Vec3, mut measure: impl FnMut(u32, f32) -> f32) -> f32 {
        let p = Vec3A::from(p);
        let square = |node: u32| {
            let bounds = self.tree.nodes[node as usize].aabb();
            p.clamp(bounds.min, bounds.max).distance_squared(p)
        };
        let mut best = f32::INFINITY;
        let mut open: Vec<(u32, f32)> = Vec::with_capacity(64);
        if !self.tree.nodes.is_empty() {
            open.push((0, square(0)));
        }
        while let Some((node, distance)) = open.pop() {
            if distance >= best {
                continue;
            }
            let node = &self.tree.nodes[node as usize];
            let (first, count) = (node.first_index, node.prim_count);
            if node.is_leaf() {
                for index in &self.tree.primitive_indices[first as usize..][..count as usize] {
                    best = measure(self.triangle_of[*index as usize], best).min(best);
                }
            } else {
                let mut children = [first, first + 1].map(|child| (child, square(child)));
                // The nearer child is taken from the end first.
                children.sort_by(|a, b| b.1.total_cmp(&a.1));
                open.extend(children);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::cells::closest_barycentric;

    /// Makes a disc of radius 1 around the origin: `n` slivers from its centre.
    fn disc(n: usize) -> Vec<Triangle> {
        let rim = |i: usize| {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * i as f32 / n as f32);
            Vec3A::new(cos, 0.1, sin)
        };
        (0..n).map(|i| Triangle { v0: Vec3A::ZERO, v1: rim(i), v2: rim(i + 1) }).collect()
    }

    #[test]
    fn nearest_triangles_of_a_disc_equal_a_full_search_after_few_measurements() {
        let triangles = disc(4000);
        let tree = TriangleTree::new(&triangles);
        let square = |t: u32, p: Vec3| {
            let corners =
                [triangles[t as usize].v0, triangles[t as usize].v1, triangles[t as usize].v2].map(Vec3::from);
            let w = closest_barycentric(p, corners);
            (corners[0] * w.x + corners[1] * w.y + corners[2] * w.z).distance_squared(p)
        };
        let mut measured = 0;
        let points: Vec<Vec3> = (0..50).map(|i| Vec3::new(0.9, 0.02 * i as f32 - 0.3, 0.03 * i as f32)).collect();
        for p in &points {
            let found = tree.minimum(*p, |t, _| {
                measured += 1;
                square(t, *p)
            });
            let expected = (0..triangles.len() as u32).map(|t| square(t, *p)).fold(f32::INFINITY, f32::min);
            assert!((found - expected).abs() <= 1e-6, "{p}: {found}, expected {expected}");
        }
        // A tree of one box per triangle measures more than a thousand.
        assert!(measured < 400 * points.len(), "{measured} measurements for {} points", points.len());
    }

    #[test]
    fn boxes_of_ordinary_and_degenerate_triangles_are_not_split() {
        let grid = (0..100).map(|i| Vec3A::new((i % 10) as f32, (i / 10) as f32, 0.0));
        let ordinary: Vec<Triangle> = grid.map(|p| Triangle { v0: p, v1: p + Vec3A::X, v2: p + Vec3A::Y }).collect();
        let point = Triangle { v0: Vec3A::ONE, v1: Vec3A::ONE, v2: Vec3A::ONE };
        for (triangles, boxes) in [(&ordinary[..], 100), (&[point; 5], 5), (&[], 0)] {
            assert_eq!(split_boxes(triangles).0.len(), boxes);
        }
        assert_eq!(TriangleTree::new(&[]).minimum(Vec3::ZERO, |_, _| 0.0), f32::INFINITY);
        let slivers = split_boxes(&disc(4000)).0.len();
        assert!((8_000..200_000).contains(&slivers), "{slivers} boxes");
    }
}
