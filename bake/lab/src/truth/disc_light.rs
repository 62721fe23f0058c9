//! Disc light: the fraction visible from a point of a mesh, computed by ray casting. This is the truth for soft
//! shadows.
//!
//! The size of the light is given as a `penumbra`: the width of a penumbra divided by the distance between occluder and
//! receiver. Soft-shadow methods with a single ray have such a constant. For a disc of angular radius ρ, it is 2 · tan
//! ρ. The value is 1/C_scale of Kirsch and Döllner 2003 and Yang 2006.

use glam::{DVec3, Vec3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use pelage_import::BakeError;
use pelage_truth::{disc, seed_of, stratified};
use std::time::Duration;

/// Distance above the mesh surface at which rays start, as a fraction of the mesh's radius: a hundred times the
/// rounding error of f32 coordinates.
const LIFT: f64 = 1e-5;

/// Light with an extent, in the shape of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscLight {
    /// Light so far away that its centre is in the same direction from every point.
    Directional {
        /// Direction towards the light, of any length above zero.
        towards_light_ws: DVec3,
        /// Penumbra width divided by the distance between occluder and receiver, 0.. (0: point light; sun: 0.0093).
        penumbra: f64,
    },
    /// Light at a position. The disc always faces the shaded point, so the light acts as a sphere.
    Point {
        /// Centre of the light, metres.
        position_ws: DVec3,
        /// Penumbra width divided by the distance between occluder and receiver, as for a distant light. The disc's
        /// radius is half of this value times the distance from the point.
        penumbra: f64,
    },
}

/// Triangles that cast shadows; both sides block light.
pub struct Occluder {
    /// Triangles in the order of the tree's leaves. Coordinates are relative to the mesh's centre and divided by its
    /// radius, so that f32 is most precise.
    triangles: Vec<Triangle>,
    /// Acceleration tree; `None` without triangles.
    tree: Option<Bvh2>,
    center: DVec3,
    radius: f64,
}

impl Occluder {
    /// Builds an occluder from `triangles`, which are indices into `positions_ws` (metres). Triangles without area cast
    /// no shadow.
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] for an index out of range or a position that is not finite.
    pub fn new(positions_ws: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, BakeError> {
        let fail = |reason: &str| Err(BakeError::Internal(format!("occluder: {reason}")));
        if triangles.iter().flatten().any(|i| *i as usize >= positions_ws.len()) {
            return fail("a triangle names a vertex that does not exist");
        }
        if !positions_ws.iter().all(|p| p.is_finite()) {
            return fail("a position is not finite");
        }
        let mut points = positions_ws.iter().map(|p| p.as_dvec3());
        let first = points.next().unwrap_or_default();
        let (min, max) = points.fold((first, first), |(min, max), p| (min.min(p), max.max(p)));
        let (center, radius) = (0.5 * (min + max), (0.5 * (max - min).length()).max(f64::MIN_POSITIVE));
        let place = |i: u32| ((positions_ws[i as usize].as_dvec3() - center) / radius).as_vec3a();
        let triangles: Vec<Triangle> = triangles
            .iter()
            .map(|t| Triangle { v0: place(t[0]), v1: place(t[1]), v2: place(t[2]) })
            .filter(|t| (t.v1 - t.v0).cross(t.v2 - t.v0).length_squared() > 0.0)
            .collect();
        if triangles.is_empty() {
            return Ok(Self { triangles, tree: None, center, radius });
        }
        // Disables splitting of triangles, because split ones would occur in several leaves.
        let params = BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() };
        let tree = build_bvh2_from_tris(&triangles, params, &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|i| triangles[*i as usize]).collect();
        Ok(Self { triangles, tree: Some(tree), center, radius })
    }

    /// Returns the fraction of the light's disc that is visible from a point: 1 in full light, 0 in the umbra.
    ///
    /// * `point_ws`: position of the point, metres
    /// * `normal_ws`: unit normal of the mesh surface at the point; ray origins are offset along it, to avoid hitting
    ///   that surface
    /// * `samples`: number of rays, rounded up to a square number; the disc is divided into that many parts of equal
    ///   area, with one ray to each
    ///
    /// A part of the disc below the point's horizon counts as hidden only if the mesh itself hides it. The result is
    /// deterministic.
    pub fn visible_share(&self, point_ws: DVec3, normal_ws: DVec3, light: &DiscLight, samples: u32) -> f64 {
        let Some(tree) = &self.tree else { return 1.0 };
        let (towards, penumbra) = match *light {
            DiscLight::Directional { towards_light_ws, penumbra } => (towards_light_ws.normalize_or_zero(), penumbra),
            DiscLight::Point { position_ws, penumbra } => ((position_ws - point_ws) / self.radius, penumbra),
        };
        let distance = towards.length();
        let Some(axis) = towards.try_normalize() else { return 1.0 };
        let origin = (point_ws - self.center) / self.radius + normal_ws * LIFT;
        let reach = if matches!(light, DiscLight::Point { .. }) { distance } else { f64::INFINITY };
        let (side, up) = axis.any_orthonormal_pair();
        let rays = stratified(seed_of(&point_ws.to_array()), samples);
        let count = rays.len();
        let seen = rays.filter(|square| {
            let on_disc = disc(*square) * (0.5 * penumbra);
            let way = axis + side * on_disc.x + up * on_disc.y;
            // Ray directions are not normalised: parameter 1 is on the plane of a disc at distance 1.
            self.is_free(tree, origin, way, reach)
        });
        seen.count() as f64 / count as f64
    }

    fn is_free(&self, tree: &Bvh2, origin: DVec3, way: DVec3, reach: f64) -> bool {
        let ray = Ray::new(origin.as_vec3a(), way.as_vec3a(), 0.0, reach as f32);
        tree.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
    }
}

#[cfg(test)]
#[path = "disc_light_tests.rs"]
mod tests;
