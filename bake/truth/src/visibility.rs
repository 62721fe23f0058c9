//! Visibility of points on a posed mesh surface, computed with rays instead of a rasteriser.

use super::camera::{RayCaster, TrueCamera};
use super::tracer::{Hit, Tracer};
use glam::{DVec2, DVec3};
use pelage_bake::strands::Curves;
use pelage_bake::strands::PosedMesh;
use pelage_import::BakeError;

/// A mesh surface prepared for visibility queries. Back faces are visible only if their material is double-sided.
/// Texels below the alpha cutoff are holes.
pub struct SurfaceVisibility {
    tracer: Tracer,
}

/// A visible point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisiblePoint {
    /// Index of the triangle.
    pub triangle: usize,
    /// Barycentric weights; they add up to 1.
    pub weights: DVec3,
    /// Distance from the eye, metres. In a parallel projection, distance from the plane of the eye.
    pub distance_m: f64,
}

impl SurfaceVisibility {
    /// Builds the acceleration structure.
    ///
    /// Fails with [`BakeError::Internal`] for positions that are not finite.
    pub fn new(skin: PosedMesh) -> Result<Self, BakeError> {
        Ok(Self { tracer: Tracer::new(Curves::default(), skin)? })
    }

    /// Returns the mesh surface.
    pub fn skin(&self) -> &PosedMesh {
        &self.tracer.skin
    }

    /// Returns the position of a point of a triangle, metres in world space.
    pub fn position_ws(&self, triangle: usize, weights: DVec3) -> DVec3 {
        let [a, b, c] = self.skin().corners(triangle).map(|c| c.position_ws);
        a * weights.x + b * weights.y + c * weights.z
    }

    /// Returns the view of a camera with a picture of `size` pixels.
    pub fn view(&self, camera: &TrueCamera, size: (u32, u32)) -> SurfaceView<'_> {
        SurfaceView { sight: self, rays: RayCaster::new(camera, size) }
    }

    /// Returns half the diagonal of the surface's bounding box, metres; 1 if that is zero.
    pub fn radius_m(&self) -> f64 {
        self.tracer.radius()
    }
}

/// A mesh surface seen by a camera.
pub struct SurfaceView<'a> {
    sight: &'a SurfaceVisibility,
    rays: RayCaster,
}

impl SurfaceView<'_> {
    /// Returns the surface point that is visible at point `at_px` of the picture, pixels from its upper left corner.
    /// Centres of pixels have a fraction of one half.
    pub fn at(&self, at_px: DVec2) -> Option<VisiblePoint> {
        let (origin, way) = self.rays.ray(at_px);
        match self.sight.tracer.first_hit(origin, way)? {
            (Hit::Skin { triangle, weights, .. }, distance_m) => Some(VisiblePoint { triangle, weights, distance_m }),
            (Hit::Hair { .. }, _) => None,
        }
    }

    /// Returns the projection of a point, in pixels from the picture's upper left corner; it may be outside of the
    /// picture. `None` for a point that is not in front of the eye.
    pub fn project_px(&self, point_ws: DVec3) -> Option<DVec2> {
        self.rays.project(point_ws).map(|(at, _)| at)
    }

    /// Returns whether a point is visible. Ignores occluders that are at most `slack_m` metres nearer.
    pub fn is_visible(&self, point_ws: DVec3, slack_m: f64) -> bool {
        let (origin, way, distance) = self.rays.ray_to(point_ws);
        distance > 0.0 && self.sight.tracer.first_hit(origin, way).is_none_or(|(_, first)| first >= distance - slack_m)
    }

    /// Returns whether a point is in the picture.
    pub fn contains(&self, at_px: DVec2) -> bool {
        let size = self.rays.size();
        (0.0..size.x).contains(&at_px.x) && (0.0..size.y).contains(&at_px.y)
    }

    /// Returns the unit view direction towards a point.
    pub fn direction_to(&self, point_ws: DVec3) -> DVec3 {
        self.rays.ray_to(point_ws).1
    }

    /// Returns the rays of this view.
    pub fn rays(&self) -> &RayCaster {
        &self.rays
    }
}
