//! The scene as the key light sees it: where the shadow maps lie.

use crate::{Camera, Light, Projection};
use glam::{Mat4, Vec3, Vec4};

/// A sphere in world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub center: Vec3,
    /// Its radius, at least 0.
    pub radius: f32,
}

impl Sphere {
    /// A sphere that holds all of them: about the box that does. `None` of none.
    pub(crate) fn around(spheres: impl IntoIterator<Item = Self>) -> Option<Self> {
        let mut spheres = spheres.into_iter();
        let first = spheres.next()?;
        let (mut min, mut max) = (first.center - first.radius, first.center + first.radius);
        let mut only = true;
        for sphere in spheres {
            only = false;
            min = min.min(sphere.center - sphere.radius);
            max = max.max(sphere.center + sphere.radius);
        }
        Some(if only { first } else { Self { center: 0.5 * (min + max), radius: 0.5 * (max - min).length() } })
    }
}

/// The widest view of a point light's maps, radians: beyond, their texels are more about the border than the middle.
const MAX_FOV_RAD: f32 = 2.4;

/// A point light this many radii away is seen as a distant one: its rays differ by less than a texel, and distances from it would have
/// no digits left for the scene.
const DISTANT: f32 = 500.0;

/// Where the shadow maps of a light lie. They cover a sphere about what casts and receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightView {
    /// World to the clip space that the maps are drawn in; depth 0 is nearest to the light, not reversed.
    pub clip_from_world: Mat4,
    /// World to (u·w, v·w, z, w): u, v are coordinates in the maps, 0..=1 from the top left; z is the depth, 0..=1 and linear; w is the
    /// distance from a point light along its axis in metres, 1 for a distant light.
    pub map_from_world: Mat4,
    /// Metres from depth 0 to depth 1.
    pub range_m: f32,
    /// Size of a map, metres at distance 1 from a point light, metres everywhere for a distant one.
    pub extent: f32,
    /// Distance of depth 0 from a point light, metres; `None` for a distant light.
    pub near_m: Option<f32>,
    /// What the maps cover.
    pub sphere: Sphere,
}

impl LightView {
    /// A view of `sphere`, whose light passed [`Light::homogeneous`].
    pub(crate) fn new(light: &Light, sphere: Sphere) -> Self {
        // Rounded up to coarse steps: texels keep their size while an animation moves the bounds a little. The rest of the margin is for
        // the blur, which must find lit texels around everything.
        let step = 2f32.powf(0.125);
        let radius = sphere.radius.max(1e-6) * 1.04;
        let radius = step.powf((radius.ln() / step.ln()).ceil());
        match *light {
            Light::Directional { towards_light, .. } => Self::distant(towards_light, radius, sphere),
            Light::Point { position, .. } if position.distance(sphere.center) < DISTANT * radius => {
                Self::near(position, radius, sphere)
            }
            Light::Point { position, .. } => Self::distant(position - sphere.center, radius, sphere),
        }
    }

    fn distant(towards_light: Vec3, radius: f32, sphere: Sphere) -> Self {
        let eye = sphere.center + towards_light.normalize_or(Vec3::Y) * radius;
        let range_m = 2.0 * radius;
        let projection = Projection::Orthographic { height_m: range_m, aspect: 1.0, near_m: 0.0, far_m: range_m };
        let camera = Camera::look_at(eye, sphere.center, projection);
        let clip_from_world = projection.clip_from_view(false) * camera.view_from_world;
        // Depth of a parallel projection is linear already.
        let map_from_world = map_from_clip() * clip_from_world;
        Self { clip_from_world, map_from_world, range_m, extent: range_m, near_m: None, sphere }
    }

    fn near(position: Vec3, radius: f32, sphere: Sphere) -> Self {
        let distance = position.distance(sphere.center);
        let fov_y_rad = (2.0 * (radius / distance.max(1e-6)).min(1.0).asin()).min(MAX_FOV_RAD);
        let near_m = (distance - radius).max(0.02 * radius);
        let far_m = distance + radius;
        let projection = Projection::Perspective { fov_y_rad, aspect: 1.0, near_m, far_m };
        // A light in the very centre may look anywhere.
        let target = if distance > 1e-6 * radius { sphere.center } else { position - Vec3::Y };
        let camera = Camera::look_at(position, target, projection);
        let clip_from_world = projection.clip_from_view(false) * camera.view_from_world;
        let mut map_from_world = map_from_clip() * clip_from_world;
        // Depth of a perspective projection is not linear: the distance along the axis is, and it is in w.
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

/// Clip coordinates to texture coordinates from the top left, times w.
fn map_from_clip() -> Mat4 {
    Mat4::from_cols(
        Vec4::new(0.5, 0.0, 0.0, 0.0),
        Vec4::new(0.0, -0.5, 0.0, 0.0),
        Vec4::Z,
        Vec4::new(0.5, 0.5, 0.0, 1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn project(view: &LightView, point: Vec3) -> (Vec3, f32) {
        let p = view.map_from_world * point.extend(1.0);
        (Vec3::new(p.x / p.w, p.y / p.w, p.z), p.w)
    }

    #[test]
    fn the_sphere_is_inside_the_maps() {
        let sphere = Sphere { center: Vec3::new(1.0, 2.0, -3.0), radius: 0.4 };
        for direction in [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::new(-1.0, 2.0, 0.3), Vec3::new(1e-3, -1.0, 0.0)] {
            let distant = Light::Directional { towards_light: direction, color: Vec3::ONE };
            let near = Light::Point { position: sphere.center + direction.normalize() * 0.7, color: Vec3::ONE };
            for light in [distant, near] {
                let view = LightView::new(&light, sphere);
                for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
                    let (p, w) = project(&view, sphere.center + axis * sphere.radius);
                    assert!(p.cmpge(Vec3::ZERO).all() && p.cmple(Vec3::ONE).all(), "{light:?} {axis}: {p}");
                    let clip = view.clip_from_world * (sphere.center + axis * sphere.radius).extend(1.0);
                    let uv = Vec3::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w, p.z);
                    assert!((uv - p).length() < 1e-4, "{uv} {p}");
                    if let (Light::Point { position, .. }, Some(near_m)) = (light, view.near_m) {
                        let along = (sphere.center - position).normalize();
                        let distance = (sphere.center + axis * sphere.radius - position).dot(along);
                        assert!((w - distance).abs() < 1e-4 && (p.z * view.range_m + near_m - distance).abs() < 1e-4);
                    } else {
                        assert!((w - 1.0).abs() < 1e-6);
                    }
                }
                // The light's side is nearer.
                let towards = direction.normalize() * sphere.radius;
                let (front, back) = (project(&view, sphere.center + towards), project(&view, sphere.center - towards));
                let along = (back.0.z - front.0.z) * view.range_m;
                assert!((along - 2.0 * sphere.radius).abs() < 1e-3, "{along}");
            }
        }
    }

    #[test]
    fn a_light_inside_the_scene_gives_finite_maps() {
        let sphere = Sphere { center: Vec3::ONE, radius: 1.0 };
        for position in [Vec3::ONE, Vec3::new(1.0, 1.5, 1.0), Vec3::new(1.0, 1.0, 2.0)] {
            let view = LightView::new(&Light::Point { position, color: Vec3::ONE }, sphere);
            assert!(view.clip_from_world.is_finite() && view.map_from_world.is_finite() && view.range_m > 0.0);
        }
        let dot = Sphere { center: Vec3::ZERO, radius: 0.0 };
        assert!(LightView::new(&Light::default(), dot).map_from_world.is_finite());
    }
}
