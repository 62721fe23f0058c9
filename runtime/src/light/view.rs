//! Projection of the shadow maps: the scene as seen by the key light.

use crate::bounds::{Hull, Sphere};
use crate::camera::{Camera, Light, Projection};
use glam::{Mat4, Vec3, Vec4};

/// Ratio of the maps' size to the size of their contents: the blur needs lit texels around all objects.
const MARGIN: f32 = 1.03;

/// Rounds a length up to coarse steps, so that the texel size stays constant while an animation changes the bounds
/// slightly.
fn round_up_coarsely(length: f32) -> f32 {
    let step = 2f32.powf(1.0 / 16.0);
    step.powf((length.max(1e-6).ln() / step.ln()).ceil())
}

/// Maximum field of view of a point light's maps, radians. With a wider one, most texels would be near the border.
const MAX_FOV_RAD: f32 = 2.4;

/// Distance of a point light, in radii of the scene, from which it is treated as a distant light. There, its rays
/// differ from parallel rays by less than a texel, and distances from the light would leave too few digits for the
/// scene.
const DISTANT_RADII: f32 = 500.0;

/// Projection of a light's shadow maps. They cover the instances of the frame with their fur, and
/// [`crate::Casters::bounds`]. A point light sees at most 137°; if it is inside the scene, its maps face the centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightView {
    /// Transform from world space to the clip space of the maps, for the vertex shader of a caster. Depth 0 is nearest
    /// to the light, regardless of [`crate::RendererOptions::reversed_depth`].
    pub clip_from_world: Mat4,
    /// Transform from world space to (u·w, v·w, z, w), for the shader of a receiver:
    ///
    /// * u, v: coordinates in the maps after division by w, 0..=1 from the top left
    /// * z: linear depth, 0..=1, not divided
    /// * w: distance from a point light along its axis, metres; 1 for a distant light
    pub map_from_world: Mat4,
    /// Distance between depth 0 and depth 1, metres.
    pub range_m: f32,
    /// Width and height that a map covers: metres for a distant light, metres at 1 m from a point light.
    pub extent: f32,
    /// Distance from a point light to depth 0, metres; `None` for a distant light.
    pub near_m: Option<f32>,
    /// Sphere that contains all objects that the maps must cover.
    pub sphere: Sphere,
}

impl LightView {
    /// Returns the texel size of maps with `map_size` texels along each edge, metres; for a point light, in the middle
    /// of its range.
    pub(crate) fn texel_m(&self, map_size: u32) -> f32 {
        let distance = self.near_m.map_or(1.0, |near| near + 0.5 * self.range_m);
        self.extent / map_size as f32 * distance
    }

    /// Creates the view of `hull`, whose bounding sphere is `sphere`, from a light that [`Light::homogeneous`] has
    /// checked.
    pub(crate) fn new(light: &Light, hull: &Hull, sphere: Sphere) -> Self {
        match *light {
            Light::Directional { towards_light, .. } => Self::distant(towards_light, hull, sphere),
            Light::Point { position, .. } if position.distance(sphere.center) < DISTANT_RADII * sphere.radius => {
                Self::near(position, hull, sphere)
            }
            Light::Point { position, .. } => Self::distant(position - sphere.center, hull, sphere),
        }
    }

    fn distant(towards_light: Vec3, hull: &Hull, sphere: Sphere) -> Self {
        let towards = towards_light.normalize_or(Vec3::Y);
        let looking = Camera::look_at(sphere.center + towards, sphere.center, Projection::Custom(Mat4::IDENTITY));
        let axis = |row: Vec4| row.truncate();
        let view = looking.view_from_world;
        let [x, y, z] = [view.row(0), view.row(1), view.row(2)].map(|row| hull.range(sphere.center, axis(row)));
        let extent = round_up_coarsely(MARGIN * (x.1 - x.0).max(y.1 - y.0));
        let range_m = round_up_coarsely(MARGIN * (z.1 - z.0));
        // Centre the maps on the hull.
        let middle = |range: (f32, f32), row: Vec4| 0.5 * (range.0 + range.1) * axis(row);
        let center = sphere.center + middle(x, view.row(0)) + middle(y, view.row(1)) + middle(z, view.row(2));
        let projection = Projection::Orthographic { height_m: extent, aspect: 1.0, near_m: 0.0, far_m: range_m };
        let camera = Camera::look_at(center + 0.5 * range_m * towards, center, projection);
        let clip_from_world = projection.clip_from_view(false) * camera.view_from_world;
        // The depth of a parallel projection is already linear.
        let map_from_world = map_from_clip() * clip_from_world;
        Self { clip_from_world, map_from_world, range_m, extent, near_m: None, sphere }
    }

    fn near(position: Vec3, hull: &Hull, sphere: Sphere) -> Self {
        // A light exactly in the centre of the scene may face any direction.
        let apart = position.distance(sphere.center) > 1e-6 * sphere.radius;
        let target = if apart { sphere.center } else { position - Vec3::Y };
        let looking = Camera::look_at(position, target, Projection::Custom(Mat4::IDENTITY));
        let mut tangent = 0.0f32;
        for (point, margin) in &hull.0 {
            let p = looking.view_from_world.transform_point3(*point);
            let ahead = -p.z - margin;
            let aside = p.x.abs().max(p.y.abs()) + margin;
            tangent = tangent.max(if ahead > 0.0 { aside / ahead } else { f32::INFINITY });
        }
        let fov_y_rad = (2.0 * round_up_coarsely(MARGIN * tangent).atan()).min(MAX_FOV_RAD);
        let (least, most) = hull.range(position, (target - position).normalize());
        let far_m = round_up_coarsely(MARGIN * most.max(1e-6));
        let near_m = (least / MARGIN).max(0.01 * far_m);
        let projection = Projection::Perspective { fov_y_rad, aspect: 1.0, near_m, far_m };
        let camera = Camera { projection, ..looking };
        let clip_from_world = projection.clip_from_view(false) * camera.view_from_world;
        let mut map_from_world = map_from_clip() * clip_from_world;
        // The depth of a perspective projection is not linear; the distance along the axis, stored in w, is.
        let range_m = far_m - near_m;
        let distance_row = clip_from_world.row(3);
        let depth_row = (distance_row - Vec4::W * near_m) / range_m;
        for (column, value) in depth_row.to_array().into_iter().enumerate() {
            map_from_world.col_mut(column).z = value;
        }
        let extent = 2.0 * (0.5 * fov_y_rad).tan();
        Self { clip_from_world, map_from_world, range_m, extent, near_m: Some(near_m), sphere }
    }
}

/// Returns the matrix from clip space to texture coordinates from the top left, times w.
fn map_from_clip() -> Mat4 {
    Mat4::from_cols(
        Vec4::new(0.5, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -0.5, 0.0, 0.0),
        Vec4::Z,
        Vec4::new(0.5, 0.5, 0.0, 1.0),
    )
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn project(view: &LightView, point: Vec3) -> (Vec3, f32) {
        let p = view.map_from_world * point.extend(1.0);
        (Vec3::new(p.x / p.w, p.y / p.w, p.z), p.w)
    }

    #[test]
    fn light_maps_contain_the_hull_and_fit_it_tightly() {
        let center = Vec3::new(1.0, 2.0, -3.0);
        let spheres = Hull(vec![(center, 0.4)]);
        let stick = Hull(vec![(center - 0.7 * Vec3::Y, 0.05), (center + 0.7 * Vec3::Y, 0.05)]);
        for hull in [spheres, stick] {
            let sphere = hull.sphere().unwrap();
            for direction in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(-1.0, 2.0, 0.3), Vec3::new(1e-3, -1.0, 0.0)] {
                let distant = Light::Directional { towards_light: direction, color: Vec3::ONE };
                let near = Light::Point { position: center + direction.normalize() * 1.7, color: Vec3::ONE };
                let far = Light::Point { position: center + direction.normalize() * 1e5, color: Vec3::ONE };
                for light in [distant, near, far] {
                    check(&LightView::new(&light, &hull, sphere), &hull, &light, direction);
                }
            }
        }
    }

    fn check(view: &LightView, hull: &Hull, light: &Light, direction: Vec3) {
        let mut widest = 0.0f32;
        for (point, margin) in &hull.0 {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
                let (p, w) = project(view, *point + axis * *margin);
                assert!(p.cmpge(Vec3::ZERO).all() && p.cmple(Vec3::ONE).all(), "{light:?} {axis}: {p}");
                widest = widest.max((p.x - 0.5).abs()).max((p.y - 0.5).abs());
                let clip = view.clip_from_world * (*point + axis * *margin).extend(1.0);
                let uv = Vec3::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w, p.z);
                assert!((uv - p).length() < 1e-4, "{uv} {p}");
                let Some(near_m) = view.near_m else {
                    assert!((w - 1.0).abs() < 1e-6);
                    continue;
                };
                assert!((p.z * view.range_m + near_m - w).abs() < 1e-3, "{} {w}", p.z * view.range_m + near_m);
            }
        }
        assert!(widest > 0.3, "{light:?}: the outermost is {widest} from the middle");
        // Moving a point towards the light reduces its distance from the light by the length of the move.
        let towards = direction.normalize() * 0.1;
        let center = hull.sphere().unwrap().center;
        let (front, back) = (project(view, center + towards), project(view, center - towards));
        let along = (back.0.z - front.0.z) * view.range_m;
        assert!((along - 0.2).abs() < 1e-3, "{along}");
    }

    #[test]
    fn a_light_inside_the_scene_gives_finite_maps() {
        let hull = Hull(vec![(Vec3::ONE, 1.0)]);
        let sphere = hull.sphere().unwrap();
        for position in [Vec3::ONE, Vec3::new(1.0, 1.5, 1.0), Vec3::new(1.0, 1.0, 2.0)] {
            let view = LightView::new(&Light::Point { position, color: Vec3::ONE }, &hull, sphere);
            assert!(view.clip_from_world.is_finite() && view.map_from_world.is_finite() && view.range_m > 0.0);
        }
        let dot = Hull(vec![(Vec3::ZERO, 0.0)]);
        let view = LightView::new(&Light::default(), &dot, dot.sphere().unwrap());
        assert!(view.map_from_world.is_finite());
        assert_eq!(Hull::default().sphere(), None);
    }
}
