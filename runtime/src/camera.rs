//! Camera and key light. World space is right-handed with +Y up, in metres. Clip space is that of WebGPU, with depth
//! 0..=1.

use crate::error::RuntimeError;
use glam::{Mat4, Vec3, Vec4};
use pelage_formats::meaning::environment::Sun;
use pelage_formats::meaning::view_from_world;

/// Returns the elements of a projection on which depth depends, as `ink/distance.wgsl` reads them: depth and w in clip
/// space are linear in the z coordinate of the view.
pub(crate) fn depth_rows(clip_from_view: Mat4) -> [f32; 4] {
    let [z, w] = [clip_from_view.z_axis, clip_from_view.w_axis];
    [z.z, w.z, z.w, w.w]
}

/// Camera of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Transform from world to view space: rotation and translation, no scale. The camera looks along −Z of view space,
    /// +Y is up in the picture.
    pub view_from_world: Mat4,
    /// Projection from view space to clip space.
    pub projection: Projection,
}

/// Projection from view space to clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective projection.
    Perspective {
        /// Vertical field of view, radians, above 0 and below π.
        fov_y_rad: f32,
        /// Width of the picture divided by its height.
        aspect: f32,
        /// Distance of the near plane, metres, above 0.
        near_m: f32,
        /// Distance of the far plane, metres, above `near_m`. Infinity is allowed; it costs no precision with reversed
        /// depth.
        far_m: f32,
    },
    /// Parallel projection.
    Orthographic {
        /// Height of the view volume, metres.
        height_m: f32,
        /// Width of the picture divided by its height.
        aspect: f32,
        /// Distance of the near plane, metres; may be negative.
        near_m: f32,
        /// Distance of the far plane, metres, above `near_m`.
        far_m: f32,
    },
    /// Matrix supplied by the application. It must agree with [`crate::RendererOptions::reversed_depth`].
    Custom(
        /// Matrix `clip_from_view`.
        Mat4,
    ),
}

impl Projection {
    /// Returns the matrix `clip_from_view`. With `reversed_depth`, the near plane has depth 1 and the far plane 0.
    pub fn clip_from_view(&self, reversed_depth: bool) -> Mat4 {
        match *self {
            Self::Perspective { fov_y_rad, aspect, near_m, far_m } => {
                let scale_y = 1.0 / (0.5 * fov_y_rad).tan();
                // Depth is (a z + b) / −z with depth 0 at −near and 1 at −far; far may be infinite.
                let (a, b) = if far_m.is_finite() {
                    (far_m / (near_m - far_m), near_m * far_m / (near_m - far_m))
                } else {
                    (-1.0, -near_m)
                };
                // 1 − depth: 1 − (a z + b) / −z = ((−1 − a) z − b) / −z.
                let (a, b) = if reversed_depth { (-1.0 - a, -b) } else { (a, b) };
                Mat4::from_cols(
                    Vec4::new(scale_y / aspect, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, scale_y, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, a, -1.0),
                    Vec4::new(0.0, 0.0, b, 0.0),
                )
            }
            Self::Orthographic { height_m, aspect, near_m, far_m } => {
                let depth = 1.0 / (near_m - far_m);
                let (a, b) = if reversed_depth { (-depth, 1.0 - near_m * depth) } else { (depth, near_m * depth) };
                Mat4::from_cols(
                    Vec4::new(2.0 / (height_m * aspect), 0.0, 0.0, 0.0),
                    Vec4::new(0.0, 2.0 / height_m, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, a, 0.0),
                    Vec4::new(0.0, 0.0, b, 1.0),
                )
            }
            Self::Custom(matrix) => matrix,
        }
    }
}

impl Camera {
    /// Creates a camera at `eye` that looks at `target`. Up is +Y, or −Z if the view is straight up or down.
    pub fn look_at(eye: Vec3, target: Vec3, projection: Projection) -> Self {
        Self { view_from_world: view_from_world(eye, target), projection }
    }

    /// Creates a perspective camera that frames a sphere, such as a package's bounds with fur. The eye is in direction
    /// `towards_eye` from `center`.
    ///
    /// * `radius` - metres, above 0
    /// * `towards_eye` - any length
    /// * `fov_y_rad`, `aspect` - as in [`Projection::Perspective`]
    pub fn framing(center: Vec3, radius: f32, towards_eye: Vec3, fov_y_rad: f32, aspect: f32) -> Self {
        let half = 0.5 * fov_y_rad;
        // The sphere must fit into the narrower of the two fields of view, horizontal and vertical.
        let narrow = half.tan().min(half.tan() * aspect).atan();
        let distance = radius / narrow.sin();
        let eye = center + towards_eye.try_normalize().unwrap_or(Vec3::Z) * distance;
        let near_m = (distance - radius).max(0.01 * distance) * 0.5;
        let projection = Projection::Perspective { fov_y_rad, aspect, near_m, far_m: (distance + radius) * 2.0 };
        Self::look_at(eye, center, projection)
    }

    /// Returns the eye position with w = 1; for a parallel projection, the direction towards the eye with w = 0.
    pub(crate) fn eye_ws(&self, clip_from_view: Mat4) -> Vec4 {
        let world_from_view = self.view_from_world.inverse();
        // The last row of a parallel projection is (0, 0, 0, 1).
        if clip_from_view.row(3).truncate().length_squared() == 0.0 {
            world_from_view.z_axis.truncate().normalize_or(Vec3::Z).extend(0.0)
        } else {
            world_from_view.w_axis.truncate().extend(1.0)
        }
    }

    pub(crate) fn check(&self, reversed_depth: bool) -> Result<Mat4, RuntimeError> {
        let clip_from_view = self.projection.clip_from_view(reversed_depth);
        let clip_from_world = clip_from_view * self.view_from_world;
        let world_from_view = self.view_from_world.inverse();
        if !clip_from_world.is_finite() || !world_from_view.is_finite() {
            let eye = world_from_view.w_axis;
            return Err(RuntimeError::Params {
                field: "FrameParams::camera",
                found: format!("a camera at {:?}, {:?}, {:?}", eye.x, eye.y, eye.z),
                expected:
                    "finite matrices, an invertible view, and a projection with near != far, aspect and angle above 0"
                        .into(),
            });
        }
        Ok(clip_from_view)
    }
}

/// Key light; a frame has one, as in Yang 2006.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light from one direction, such as the sun.
    Directional {
        /// World direction from the scene towards the light, any length above 0.
        towards_light: Vec3,
        /// Linear RGB, 1 for full light.
        color: Vec3,
    },
    /// Light from one position.
    Point {
        /// World position, metres.
        position: Vec3,
        /// Linear RGB at the receiver. Independent of distance, so a scene keeps its exposure at any scale.
        color: Vec3,
    },
}

impl Default for Light {
    /// Returns white light from above, in front and the left.
    fn default() -> Self {
        Self::Directional { towards_light: Vec3::new(-0.5, 0.8, 0.6), color: Vec3::ONE }
    }
}

impl Light {
    /// Returns the light of an environment's sun, infinitely far away.
    pub fn sun(sun: &Sun) -> Self {
        Self::Directional { towards_light: Vec3::from(sun.towards).normalize_or(Vec3::Y), color: sun.color.into() }
    }

    /// Returns the linear RGB of the light.
    pub fn color(&self) -> Vec3 {
        match *self {
            Self::Directional { color, .. } | Self::Point { color, .. } => color,
        }
    }

    /// Returns the position with w = 1, or the unit direction towards the light with w = 0.
    ///
    /// `field` is the parameter that holds this light, for error messages.
    pub(crate) fn homogeneous(&self, field: &'static str) -> Result<Vec4, RuntimeError> {
        let result = match *self {
            Self::Directional { towards_light, .. } => towards_light.try_normalize().map(|d| d.extend(0.0)),
            Self::Point { position, .. } => position.is_finite().then(|| position.extend(1.0)),
        };
        result.filter(|_| self.color().is_finite()).ok_or_else(|| RuntimeError::Params {
            field,
            found: format!("{self:?}"),
            expected: "finite numbers and a direction that is not zero".into(),
        })
    }
}
