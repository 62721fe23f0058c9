//! What an eye sees of a posed skin, point by point: by rays, without a rasteriser.

use super::camera::{RayCaster, TrueCamera};
use super::tracer::{Hit, Tracer};
use glam::{DVec2, DVec3};
use pelage_bake::strands::Curves;
use pelage_bake::strands::Skin;
use pelage_import::BakeError;

/// A skin ready to be looked at. Back faces do not show unless their material is double-sided, and what its base colour cuts away is not there.
pub struct Sight {
    tracer: Tracer,
}

/// A point of the skin that is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// The triangle.
    pub triangle: usize,
    /// Weights of its corners; they add up to 1.
    pub weights: DVec3,
    /// From the eye, metres; in a parallel projection from the plane of the eye.
    pub distance_m: f64,
}

impl Sight {
    /// Builds the tree.
    ///
    /// # Errors
    ///
    /// [`BakeError::Internal`] for places that are not finite.
    pub fn new(skin: Skin) -> Result<Self, BakeError> {
        Ok(Self { tracer: Tracer::new(Curves::default(), skin)? })
    }

    /// The skin.
    pub fn skin(&self) -> &Skin {
        &self.tracer.skin
    }

    /// The place of a point of a triangle, metres in world space.
    pub fn place_ws(&self, triangle: usize, weights: DVec3) -> DVec3 {
        let [a, b, c] = self.skin().corners(triangle).map(|c| c.position_ws);
        a * weights.x + b * weights.y + c * weights.z
    }

    /// The skin as a camera sees it in a picture of `size` pixels.
    pub fn from(&self, camera: &TrueCamera, size: (u32, u32)) -> Look<'_> {
        Look { sight: self, rays: RayCaster::new(camera, size) }
    }

    /// Half the diagonal of the box about the skin, metres; 1 where that is nothing.
    pub fn radius_m(&self) -> f64 {
        self.tracer.radius()
    }
}

/// A skin seen from one place.
pub struct Look<'a> {
    sight: &'a Sight,
    rays: RayCaster,
}

impl Look<'_> {
    /// What is seen at a point of the picture, pixels from its upper left corner; a pixel's middle lies at a half.
    pub fn at(&self, at_px: DVec2) -> Option<SeenPoint> {
        let (origin, way) = self.rays.ray(at_px);
        match self.sight.tracer.first(origin, way)? {
            (Hit::Skin { triangle, weights, .. }, distance_m) => Some(SeenPoint { triangle, weights, distance_m }),
            (Hit::Hair { .. }, _) => None,
        }
    }

    /// Where a point lies in the picture, pixels from its upper left corner, which may be outside of it; `None` where it is not before the eye.
    pub fn place_px(&self, point_ws: DVec3) -> Option<DVec2> {
        self.rays.place(point_ws).map(|(at, _)| at)
    }

    /// Whether nothing lies before a point, but what is at most `slack_m` metres nearer.
    pub fn sees(&self, point_ws: DVec3, slack_m: f64) -> bool {
        let (origin, way, distance) = self.rays.ray_to(point_ws);
        distance > 0.0 && self.sight.tracer.first(origin, way).is_none_or(|(_, first)| first >= distance - slack_m)
    }

    /// Whether a point lies in the picture.
    pub fn holds(&self, at_px: DVec2) -> bool {
        let size = self.rays.size();
        (0.0..size.x).contains(&at_px.x) && (0.0..size.y).contains(&at_px.y)
    }

    /// Unit direction of the look at a point.
    pub fn way_to(&self, point_ws: DVec3) -> DVec3 {
        self.rays.ray_to(point_ws).1
    }

    /// The rays of this look.
    pub fn rays(&self) -> &RayCaster {
        &self.rays
    }
}
