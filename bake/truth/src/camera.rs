//! Camera of a ray-traced picture: rays through pixels, and projection of points into the picture.

use glam::{DVec2, DVec3, Mat4, Vec3};

/// Camera pose and lens. The aspect ratio is that of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueCamera {
    /// Position of the eye in world space, metres.
    pub eye_ws: Vec3,
    /// Point in the middle of the picture; must differ from the eye.
    pub target_ws: Vec3,
    /// Up direction of the picture; must not be parallel to the view.
    pub up_ws: Vec3,
    /// Projection and height of the view.
    pub lens: Lens,
}

/// Projection and height of the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Perspective projection.
    Perspective {
        /// Vertical field of view, radians, above 0 and below π.
        fov_y_rad: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Height of the view, metres.
        height_m: f32,
    },
}

impl TrueCamera {
    /// Returns the camera of a view matrix. The matrix maps world to view space, with y up and −z forward, without
    /// scale.
    pub fn from_view(view_from_world: Mat4, lens: Lens) -> Self {
        let world_from_view = view_from_world.inverse();
        let eye_ws = world_from_view.w_axis.truncate();
        let target_ws = eye_ws - world_from_view.z_axis.truncate();
        Self { eye_ws, target_ws, up_ws: world_from_view.y_axis.truncate(), lens }
    }

    /// Returns the view directions of a picture of `size` pixels.
    pub fn view_directions(&self, size: (u32, u32)) -> ViewDirections {
        ViewDirections(RayCaster::new(self, size))
    }
}

/// View directions of a camera.
pub struct ViewDirections(RayCaster);

impl ViewDirections {
    /// Returns the unit vector from the eye through point `at` of the picture, in pixels from its upper left corner.
    pub fn direction_at(&self, at: DVec2) -> DVec3 {
        self.0.ray(at).1
    }
}

/// Rays of a camera.
pub struct RayCaster {
    origin: DVec3,
    forward: DVec3,
    /// Vectors from the centre of the picture to the middle of its right edge and of its upper edge. In a perspective
    /// projection, the picture is at distance 1 from the eye. In a parallel projection, the vectors are in metres.
    right: DVec3,
    up: DVec3,
    size: DVec2,
    parallel: bool,
}

impl RayCaster {
    /// Prepares the rays of a camera for a picture of `width` by `height` pixels.
    pub fn new(camera: &TrueCamera, (width, height): (u32, u32)) -> Self {
        let origin = camera.eye_ws.as_dvec3();
        let forward = (camera.target_ws.as_dvec3() - origin).normalize_or(DVec3::NEG_Z);
        let right = forward.cross(camera.up_ws.as_dvec3()).normalize_or(DVec3::X);
        let (half, parallel) = match camera.lens {
            Lens::Perspective { fov_y_rad } => ((0.5 * f64::from(fov_y_rad)).tan(), false),
            Lens::Orthographic { height_m } => (0.5 * f64::from(height_m), true),
        };
        let size = DVec2::new(f64::from(width), f64::from(height));
        let aspect = size.x / size.y;
        Self { origin, forward, right: right * half * aspect, up: right.cross(forward) * half, size, parallel }
    }

    /// Returns the ray through point `at` of the picture, in pixels from its upper left corner: origin and unit
    /// direction.
    pub fn ray(&self, at: DVec2) -> (DVec3, DVec3) {
        let at = at / self.size * 2.0 - 1.0;
        let aside = self.right * at.x - self.up * at.y;
        if self.parallel {
            (self.origin + aside, self.forward)
        } else {
            (self.origin, (self.forward + aside).normalize())
        }
    }

    /// Projects a point into the picture. Returns its position, in pixels from the upper left corner, and its depth
    /// along the view, metres. `None` for a point that is not in front of a perspective camera.
    pub fn project(&self, point_ws: DVec3) -> Option<(DVec2, f64)> {
        let from = point_ws - self.origin;
        let depth = self.depth(point_ws);
        let scale = if self.parallel { 1.0 } else { depth };
        if scale <= 0.0 {
            return None;
        }
        let across = |axis: DVec3| from.dot(axis) / (axis.length_squared() * scale);
        let at = DVec2::new(across(self.right), -across(self.up));
        Some(((at + 1.0) * 0.5 * self.size, depth))
    }

    /// Returns the ray from the camera through a point: origin, unit direction, and distance to the point, metres.
    pub fn ray_to(&self, point_ws: DVec3) -> (DVec3, DVec3, f64) {
        let from = point_ws - self.origin;
        if self.parallel {
            let depth = self.depth(point_ws);
            return (point_ws - self.forward * depth, self.forward, depth);
        }
        let distance = from.length();
        (self.origin, from / distance, distance)
    }

    /// Returns the depth of a point along the view, metres; negative behind the eye.
    pub fn depth(&self, point_ws: DVec3) -> f64 {
        (point_ws - self.origin).dot(self.forward)
    }

    /// Returns whether the projection is parallel.
    pub fn is_parallel(&self) -> bool {
        self.parallel
    }

    /// Returns the size of the picture, pixels.
    pub fn size(&self) -> DVec2 {
        self.size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projecting_a_ray_point_gives_its_pixel() {
        for lens in [Lens::Perspective { fov_y_rad: 0.7 }, Lens::Orthographic { height_m: 3.0 }] {
            let (eye_ws, target_ws) = (Vec3::new(2.0, 1.0, 4.0), Vec3::new(0.3, -0.2, 0.1));
            let camera = TrueCamera { eye_ws, target_ws, up_ws: Vec3::Y, lens };
            let rays = RayCaster::new(&camera, (120, 80));
            let (middle, depth) = rays.project(target_ws.as_dvec3()).unwrap();
            assert!(middle.distance(DVec2::new(60.0, 40.0)) < 1e-5, "{lens:?}: {middle}");
            assert!((depth - f64::from(eye_ws.distance(target_ws))).abs() < 1e-6);
            for at in [DVec2::new(0.5, 0.5), DVec2::new(119.0, 3.0), DVec2::new(31.25, 78.0)] {
                let (origin, way) = rays.ray(at);
                let point = origin + way * 3.7;
                assert!(rays.project(point).unwrap().0.distance(at) < 1e-9, "{lens:?} {at}");
                let (from, again, distance) = rays.ray_to(point);
                assert!(again.distance(way) < 1e-12 && from.distance(origin) < 1e-9 && (distance - 3.7).abs() < 1e-9);
            }
            let behind = rays.project(2.0 * eye_ws.as_dvec3() - target_ws.as_dvec3());
            assert_eq!(behind.is_none(), matches!(lens, Lens::Perspective { .. }));
        }
    }
}
