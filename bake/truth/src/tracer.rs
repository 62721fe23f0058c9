//! Ray intersection with strands and mesh surface.

use super::capsules::Capsule;
use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams};
use pelage_bake::strands::Curves;
use pelage_bake::strands::PosedMesh;
use pelage_import::BakeError;
use std::time::Duration;

/// Offset of shadow rays from the mesh surface, in radii of the scene: far above the rounding of f64, far below the
/// width of a hair.
const LIFT: f64 = 1e-7;
/// Tolerance for negative barycentric coordinates, so that no ray passes between adjacent triangles.
const SEAM: f64 = 1e-9;

/// First intersection of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Hit {
    /// A strand: index of the point before the hit, position in the segment after it as a fraction of its length, and
    /// index of the strand.
    Hair { point: usize, share: f64, strand: u32 },
    /// The mesh surface: triangle, barycentric weights, and whether the front was hit.
    Skin { triangle: usize, weights: DVec3, front: bool },
}

/// Origin of a shadow ray: the strand or triangle that the ray ignores.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RayOrigin {
    pub(super) strand: Option<u32>,
    pub(super) triangle: Option<usize>,
}

/// Strands and mesh surface with their acceleration structures.
///
/// The methods accept and return world space. Internally the scene is centred and its radius is the unit of length, so
/// that f32 has full precision for models of a millimetre and of a hundred metres.
pub(super) struct Tracer {
    pub(super) curves: Curves,
    pub(super) skin: PosedMesh,
    /// Strand segments, in the order of the tree's leaves.
    capsules: Vec<Capsule>,
    /// First point and strand of each segment, as indices.
    pieces: Vec<(u32, u32)>,
    hair: Option<CwBvh>,
    /// Triangles, in the order of the tree's leaves.
    facets: Vec<Facet>,
    skin_tree: Option<CwBvh>,
    center: DVec3,
    radius: f64,
}

impl Tracer {
    pub fn new(curves: Curves, skin: PosedMesh) -> Result<Self, BakeError> {
        let places = || {
            let hair = curves.points.iter().map(|p| (p.position_ws.as_dvec3(), f64::from(p.radius_m)));
            hair.chain(skin.vertices.iter().map(|v| (v.position_ws, 0.0)))
        };
        if places().any(|(p, radius)| !p.is_finite() || !radius.is_finite()) {
            return Err(BakeError::Internal("the scene to trace contains positions that are not finite".into()));
        }
        let start = places().next().map_or(DVec3::ZERO, |(p, _)| p);
        let (min, max) = places().fold((start, start), |(min, max), (p, r)| (min.min(p - r), max.max(p + r)));
        let (center, half) = (0.5 * (min + max), 0.5 * (max - min).length());
        let radius = if half > 0.0 { half } else { 1.0 };
        let place = |p: DVec3| (p - center) / radius;

        let mut capsules = Vec::with_capacity(curves.segments());
        let mut pieces = Vec::with_capacity(curves.segments());
        for strand in 0..curves.len() {
            let first = curves.offsets[strand];
            for (i, ends) in curves.strand(strand).windows(2).enumerate() {
                capsules.push(Capsule {
                    from: place(ends[0].position_ws.as_dvec3()).as_vec3(),
                    from_radius: (f64::from(ends[0].radius_m) / radius) as f32,
                    to: place(ends[1].position_ws.as_dvec3()).as_vec3(),
                    to_radius: (f64::from(ends[1].radius_m) / radius) as f32,
                });
                pieces.push((first + i as u32, strand as u32));
            }
        }
        let hair = (!capsules.is_empty())
            .then(|| build_cwbvh(&capsules, BvhBuildParams::fast_build(), &mut Duration::default()));
        if let Some(tree) = &hair {
            // Segments are stored in leaf order, so that neighbours in space are neighbours in memory.
            capsules = tree.primitive_indices.iter().map(|i| capsules[*i as usize]).collect();
            pieces = tree.primitive_indices.iter().map(|i| pieces[*i as usize]).collect();
        }

        let corner = |v: u32| place(skin.vertices[v as usize].position_ws);
        let facets: Vec<Facet> =
            skin.triangles.iter().zip(0..).map(|(t, triangle)| Facet { corners: t.map(corner), triangle }).collect();
        let skin_tree = (!facets.is_empty())
            .then(|| build_cwbvh(&facets, BvhBuildParams::medium_build(), &mut Duration::default()));
        let order = skin_tree.as_ref().map_or(&[][..], |tree| &tree.primitive_indices);
        let facets = order.iter().map(|i| facets[*i as usize]).collect();
        Ok(Self { curves, skin, capsules, pieces, hair, facets, skin_tree, center, radius })
    }

    /// Returns half the diagonal of the scene's bounding box, metres; 1 if that is zero.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Returns the memory per strand, bytes: points, segments and tree.
    pub fn bytes_per_strand(&self) -> f64 {
        let tree = self.hair.as_ref().map_or(0, |t| size_of_val(&t.nodes[..]) + size_of_val(&t.primitive_indices[..]));
        let bytes = tree
            + size_of_val(&self.capsules[..])
            + size_of_val(&self.pieces[..])
            + size_of_val(&self.curves.points[..])
            + size_of_val(&self.curves.offsets[..]);
        bytes as f64 / self.curves.len().max(1) as f64
    }

    /// Returns the first intersection of a ray from the eye, and its distance in metres. `way` has unit length.
    pub fn first_hit(&self, origin_ws: DVec3, way: DVec3) -> Option<(Hit, f64)> {
        self.first_hit_from(origin_ws, way, RayOrigin::default())
    }

    /// Returns the first intersection of a ray that continues from `start`. The ray ignores the strand or triangle of
    /// `start`.
    pub fn first_hit_from(&self, origin_ws: DVec3, way: DVec3, start: RayOrigin) -> Option<(Hit, f64)> {
        let (mut origin, skipped) = self.enter_scene(origin_ws, way)?;
        if start.triangle.is_some() {
            origin += way * LIFT;
        }
        let mut best = (None, f64::INFINITY);
        let ray = Ray::new(origin.as_vec3a(), way.as_vec3a(), 0.0, f32::INFINITY);
        if let Some(tree) = &self.skin_tree {
            tree.ray_traverse(ray, &mut RayHit::none(), |_, id| {
                let Some((t, weights, front)) = self.facets[id].intersect(origin, way) else { return f32::INFINITY };
                let triangle = self.facets[id].triangle as usize;
                if start.triangle != Some(triangle)
                    && t < best.1
                    && (front || self.skin.material(triangle).double_sided)
                    && !self.is_cut(triangle, weights)
                {
                    best = (Some(Hit::Skin { triangle, weights, front }), t);
                    return t as f32;
                }
                f32::INFINITY
            });
        }
        if let Some(tree) = &self.hair {
            let ray = Ray { tmax: best.1 as f32, ..ray };
            let mut nearest = None;
            tree.ray_traverse(ray, &mut RayHit::none(), |_, id| {
                let t = self.capsules[id].intersect(origin, way);
                if t < best.1 && start.strand != Some(self.pieces[id].1) {
                    best.1 = t;
                    nearest = Some(id);
                    return t as f32;
                }
                f32::INFINITY
            });
            if let Some(id) = nearest {
                let share = self.capsules[id].axis_fraction(origin + way * best.1);
                let (point, strand) = self.pieces[id];
                best.0 = Some(Hit::Hair { point: point as usize, share, strand });
            }
        }
        best.0.map(|hit| (hit, (skipped + best.1) * self.radius))
    }

    /// Returns whether a ray reaches the light. `way` has unit length; `reach_m` is infinite for a distant light.
    ///
    /// The surface occludes from both sides. A strand does not occlude itself: the sine in the lighting equation
    /// accounts for the lit fraction of a thin hair's circumference, including the half that the eye does not see.
    pub fn is_lit(&self, origin_ws: DVec3, way: DVec3, reach_m: f64, start: RayOrigin, past: (bool, bool)) -> bool {
        let (past_hair, past_skin) = past;
        let mut origin = (origin_ws - self.center) / self.radius;
        if start.triangle.is_some() {
            origin += way * LIFT;
        }
        let reach = reach_m / self.radius;
        let ray = Ray::new(origin.as_vec3a(), way.as_vec3a(), 0.0, reach as f32);
        if let Some(tree) = self.skin_tree.as_ref().filter(|_| past_skin) {
            let free = tree.ray_traverse_miss(ray, |_, id| {
                let triangle = self.facets[id].triangle as usize;
                let met = self.facets[id]
                    .intersect(origin, way)
                    .filter(|(t, ..)| *t < reach && start.triangle != Some(triangle));
                match met {
                    Some((_, weights, _)) if !self.is_cut(triangle, weights) => 0.0,
                    _ => f32::INFINITY,
                }
            });
            if !free {
                return false;
            }
        }
        self.hair.as_ref().filter(|_| past_hair).is_none_or(|tree| {
            tree.ray_traverse_miss(ray, |_, id| {
                let hidden =
                    start.strand != Some(self.pieces[id].1) && self.capsules[id].intersect(origin, way) < reach;
                if hidden { 0.0 } else { f32::INFINITY }
            })
        })
    }

    /// Moves the ray's origin to the sphere around the scene. Returns the new origin and the distance moved; `None` if
    /// the ray misses the sphere.
    fn enter_scene(&self, origin_ws: DVec3, way: DVec3) -> Option<(DVec3, f64)> {
        let origin = (origin_ws - self.center) / self.radius;
        let middle = -origin.dot(way);
        // The radius of the sphere is 1, half the diagonal of the scene's box; it is enlarged slightly to allow for
        // rounding.
        let rest = 1.001 - (origin + way * middle).length_squared();
        if rest < 0.0 {
            return None;
        }
        let skip = (middle - rest.sqrt()).max(0.0);
        Some((origin + way * skip, skip))
    }

    fn is_cut(&self, triangle: usize, weights: DVec3) -> bool {
        self.skin.material(triangle).alpha_cutoff.is_some()
            && self.skin.is_cut(triangle, self.skin.base_color(triangle, weights).w)
    }
}

/// A triangle of the mesh surface.
#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [DVec3; 3],
    triangle: u32,
}

impl Boundable for Facet {
    fn aabb(&self) -> Aabb {
        let [a, b, c] = self.corners;
        // Rays and boxes are f32. The padding keeps their rounding from missing a flat box.
        let pad = 1e-6;
        Aabb::new((a.min(b).min(c) - pad).as_vec3a(), (a.max(b).max(c) + pad).as_vec3a())
    }
}

impl Facet {
    /// Returns the distance of the hit, the barycentric weights, and whether the front was hit (Möller and Trumbore
    /// 1997).
    fn intersect(&self, origin: DVec3, way: DVec3) -> Option<(f64, DVec3, bool)> {
        let [a, b, c] = self.corners;
        let (e, f) = (b - a, c - a);
        let p = way.cross(f);
        let det = e.dot(p);
        if det == 0.0 {
            return None;
        }
        let from = (origin - a) / det;
        let second = from.dot(p);
        let q = from.cross(e);
        let third = way.dot(q);
        let t = f.dot(q);
        let weights = DVec3::new(1.0 - second - third, second, third);
        // With a positive determinant the ray hits the side from which the corners are counter-clockwise.
        (t > 0.0 && weights.min_element() >= -SEAM).then_some((t, weights, det > 0.0))
    }
}
