//! How thick a body is under each place of its skin: the shape diameter function (Shapira, Shamir and Cohen-Or 2008).

use super::skin::Skin;
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use std::time::Duration;

/// Rays from a place, and how many all places have together at most: many places are near each other, and their mean is taken later.
const RAYS: (usize, usize) = (12, 150_000);
/// Fewest rays from a place.
const FEWEST: usize = 4;
/// Cosine of half the angle of the cone that they fill: 50°.
const CONE: f32 = 0.642_787_6;
/// The golden angle, radians: directions along a spiral of it fill a cone evenly.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// What is left within this way is left at once, radii of the skin.
const AT_ONCE: f32 = 2e-3;

/// A triangle of the skin.
#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [Vec3; 3],
    piece: u32,
}

impl Boundable for Facet {
    fn aabb(&self) -> Aabb {
        let [a, b, c] = self.corners;
        // A flat box must not be missed by rounding.
        let pad = 1e-5;
        Aabb::new((a.min(b).min(c) - pad).into(), (a.max(b).max(c) + pad).into())
    }
}

impl Facet {
    /// How far along the ray it leaves the body through the triangle (Möller and Trumbore 1997); `None` where it enters there, or misses.
    fn leaves(&self, origin: Vec3, way: Vec3) -> Option<f32> {
        let [a, b, c] = self.corners;
        let (e, f) = (b - a, c - a);
        let p = way.cross(f);
        let det = e.dot(p);
        // Below zero the ray comes from the side on which the corners run clockwise.
        if det >= 0.0 {
            return None;
        }
        let from = (origin - a) / det;
        let second = from.dot(p);
        let q = from.cross(e);
        let third = way.dot(q);
        let distance = f.dot(q);
        // Rather twice through an edge than between two triangles.
        let seam = -1e-5;
        (distance > 0.0 && second >= seam && third >= seam && second + third <= 1.0 - seam).then_some(distance)
    }
}

/// Thickness of the body at each place, radii of the skin: the median way of rays from there inwards; `None` where most meet nothing, as on
/// an open sheet. Where there are several pieces a ray goes to the far side of its own.
pub(super) fn thickness(skin: &Skin) -> Vec<Option<f32>> {
    let corners = |face: &[u32; 3]| face.map(|p| skin.positions[p as usize]);
    let facets: Vec<Facet> =
        skin.faces.iter().map(|f| Facet { corners: corners(f), piece: skin.pieces[f[0] as usize] }).collect();
    if facets.is_empty() {
        return vec![None; skin.len()];
    }
    let tree = build_cwbvh(&facets, BvhBuildParams::fast_build(), &mut Duration::default());
    let facets: Vec<Facet> = tree.primitive_indices.iter().map(|i| facets[*i as usize]).collect();
    let rays = (RAYS.1 / skin.len().max(1)).clamp(FEWEST, RAYS.0);
    let cone = directions(rays);
    (0..skin.len())
        .into_par_iter()
        .map(|place| {
            let normal = skin.normals[place];
            if normal == Vec3::ZERO {
                return None;
            }
            let (along, across) = (-normal).any_orthonormal_pair();
            let origin = skin.positions[place] - normal * 1e-5;
            let ways = cone.iter().map(|d| along * d.x + across * d.y - normal * d.z);
            let mut found: Vec<f32> =
                ways.map(|way| far_side(&tree, &facets, origin, way, skin.pieces[place])).collect();
            found.sort_unstable_by(f32::total_cmp);
            // On a sharp edge some rays leave where they start: they say nothing, unless most do, as in an ear of a leaf's thickness.
            let first = found.partition_point(|distance| *distance < AT_ONCE);
            if 3 * (found.len() - first) >= found.len() {
                found.drain(..first);
            }
            let middle = found.len() / 2;
            let upper = found.get(middle).copied()?;
            let median = if found.len() % 2 == 1 { upper } else { (upper + found[middle - 1]) / 2.0 };
            median.is_finite().then_some(median)
        })
        .collect()
}

/// How far a ray goes until it leaves the piece that it starts in; where it does not, until it leaves any; infinite where it meets nothing.
fn far_side(tree: &CwBvh, facets: &[Facet], origin: Vec3, way: Vec3, piece: u32) -> f32 {
    let (mut own, mut any) = (f32::INFINITY, f32::INFINITY);
    let ray = Ray::new(origin.into(), way.into(), 0.0, f32::INFINITY);
    tree.ray_traverse(ray, &mut RayHit::none(), |_, id| {
        let Some(distance) = facets[id].leaves(origin, way) else { return f32::INFINITY };
        any = any.min(distance);
        if facets[id].piece != piece {
            return f32::INFINITY;
        }
        own = own.min(distance);
        distance
    });
    if own.is_finite() { own } else { any }
}

/// Unit directions in a cone about z, of equal solid angles.
fn directions(count: usize) -> Vec<Vec3> {
    let direction = |i: usize| {
        let z = 1.0 - (1.0 - CONE) * (i as f32 + 0.5) / count as f32;
        let (sin, cos) = libm::sincosf(GOLDEN_ANGLE * i as f32);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    };
    (0..count).map(direction).collect()
}
