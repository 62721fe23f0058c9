//! Disc light: its visible share from a point of a mesh, by rays. The truth for soft shadows.
//!
//! The size of the light is given as a `penumbra`, for which soft-shadow methods with a single ray have a constant: the
//! width of a penumbra over the distance between occluder and receiver. A disc seen under the angle ρ, from its centre
//! to its rim, has penumbrae of the width 2 · tan ρ at distance 1. The value is 1/C_scale of Kirsch and Döllner 2003
//! and Yang 2006.

use glam::{DVec3, Vec3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use pelage_import::BakeError;
use pelage_truth::{disc, seed_of, stratified};
use std::time::Duration;

/// Distance above the mesh surface at which rays start, radii of the mesh: a hundred times the rounding of f32
/// coordinates.
const LIFT: f64 = 1e-5;

/// Light with an extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscLight {
    /// Light so far away that its centre is in the same direction from everywhere.
    Directional {
        /// Direction towards the light, of any length above zero.
        towards_light_ws: DVec3,
        /// Width of a penumbra over the distance from the occluder, 0..: 0 is a point light; the sun has 0.0093.
        penumbra: f64,
    },
    /// Light at a position. The disc always faces the shaded point, so that in effect it is a sphere.
    Point {
        /// Centre of the light, metres.
        position_ws: DVec3,
        /// Same ratio as for a distant light: the radius of the disc is half of it times the distance from the point.
        penumbra: f64,
    },
}

/// Triangles that cast shadows, from both sides.
pub struct Occluder {
    /// Triangles in the order of the tree's leaves, in radii of the mesh about its centre, where f32 is most precise.
    triangles: Vec<Triangle>,
    /// Acceleration tree; `None` without triangles.
    tree: Option<Bvh2>,
    center: DVec3,
    radius: f64,
}

impl Occluder {
    /// Builds a mesh of `triangles`, indices into `positions_ws`, which are in metres. Triangles without area cast no
    /// shadow.
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
        // The medium build leaves triangles whole: with split ones the leaves would list some twice.
        let params = BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() };
        let tree = build_bvh2_from_tris(&triangles, params, &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|i| triangles[*i as usize]).collect();
        Ok(Self { triangles, tree: Some(tree), center, radius })
    }

    /// Returns the share of the light's disc that is visible from a point, 0..=1: 1 in full light, 0 in the umbra.
    ///
    /// * `point_ws`: the point, metres
    /// * `normal_ws`: unit normal of the mesh surface there; rays start slightly along it, to avoid hitting that
    ///   surface
    /// * `samples`: number of rays, rounded up to a square number: one to each of as many parts of the disc of equal
    ///   area
    ///
    /// A part of the disc below the point's horizon is hidden only if the mesh itself hides it. The result is
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
            // Rays are not of unit length: at 1 along each is the plane of a disc at distance 1.
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
