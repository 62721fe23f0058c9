//! Thickness of a body at its welded vertices, by the shape diameter function (Shapira, Shamir and Cohen-Or 2008).

use super::welded_mesh::WeldedMesh;
use glam::Vec3;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};
use rayon::prelude::*;
use std::time::Duration;

/// Maximum number of rays per vertex, and of all vertices together. Few rays suffice, because vertices are close to
/// each other and the result is smoothed later.
const RAYS: (usize, usize) = (12, 150_000);
/// Minimum number of rays per vertex.
const FEWEST: usize = 4;
/// Cosine of the half angle of the cone of rays, 50°.
const CONE: f32 = 0.642_787_6;
/// Golden angle, radians. Directions along a spiral with steps of this angle fill a cone evenly.
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Distance below which a ray counts as leaving the body immediately, in mesh radii.
const AT_ONCE: f32 = 2e-3;

/// Triangle of the mesh.
#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [Vec3; 3],
    piece: u32,
}

impl Boundable for Facet {
    fn aabb(&self) -> Aabb {
        let [a, b, c] = self.corners;
        // The padding keeps rays from missing a flat box due to rounding.
        let pad = 1e-5;
        Aabb::new((a.min(b).min(c) - pad).into(), (a.max(b).max(c) + pad).into())
    }
}

impl Facet {
    /// Returns the distance at which a ray leaves the body through the triangle (Möller and Trumbore 1997). Returns
    /// `None` if the ray misses the triangle, or enters the body through it.
    fn exit_distance(&self, origin: Vec3, way: Vec3) -> Option<f32> {
        let [a, b, c] = self.corners;
        let (e, f) = (b - a, c - a);
        let p = way.cross(f);
        let det = e.dot(p);
        // A non-negative determinant means that the ray enters or is parallel. If it is negative, the corners are
        // clockwise as seen from the ray's origin.
        if det >= 0.0 {
            return None;
        }
        let from = (origin - a) / det;
        let second = from.dot(p);
        let q = from.cross(e);
        let third = way.dot(q);
        let distance = f.dot(q);
        // Enlarge the triangle, because hitting an edge twice is better than passing between two triangles.
        let seam = -1e-5;
        (distance > 0.0 && second >= seam && third >= seam && second + third <= 1.0 - seam).then_some(distance)
    }
}

/// Returns the thickness of the body at each welded vertex, in mesh radii: the median length of rays inwards. A ray
/// ends at the far side of its own connected component. The thickness is `None` if most rays hit nothing, for example
/// on an open sheet.
pub(crate) fn thickness(skin: &WeldedMesh) -> Vec<Option<f32>> {
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
                ways.map(|way| distance_to_far_side(&tree, &facets, origin, way, skin.pieces[place])).collect();
            found.sort_unstable_by(f32::total_cmp);
            // On a sharp edge, some rays leave immediately. They are ignored unless most rays do, as in a very thin
            // ear.
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

/// Returns the distance at which a ray leaves `piece`, the connected component where it starts. If it never does,
/// returns the distance at which it leaves any other component; infinite if it hits nothing.
fn distance_to_far_side(tree: &CwBvh, facets: &[Facet], origin: Vec3, way: Vec3, piece: u32) -> f32 {
    let (mut own, mut any) = (f32::INFINITY, f32::INFINITY);
    let ray = Ray::new(origin.into(), way.into(), 0.0, f32::INFINITY);
    tree.ray_traverse(ray, &mut RayHit::none(), |_, id| {
        let Some(distance) = facets[id].exit_distance(origin, way) else { return f32::INFINITY };
        any = any.min(distance);
        if facets[id].piece != piece {
            return f32::INFINITY;
        }
        own = own.min(distance);
        distance
    });
    if own.is_finite() { own } else { any }
}

/// Returns unit directions that fill a cone about z evenly.
fn directions(count: usize) -> Vec<Vec3> {
    let direction = |i: usize| {
        let z = 1.0 - (1.0 - CONE) * (i as f32 + 0.5) / count as f32;
        let (sin, cos) = libm::sincosf(GOLDEN_ANGLE * i as f32);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(radius * cos, radius * sin, z)
    };
    (0..count).map(direction).collect()
}
