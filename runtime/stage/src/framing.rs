//! Default camera and light of a picture.

use crate::Viewpoint;
use crate::viewpoint::numbers;
use glam::{Quat, Vec3};
use pelage_formats::meaning::view_from_world;
use std::str::FromStr;

/// Vertical field of view of the default camera, degrees: that of a portrait lens.
pub const FOV_DEG: f32 = 30.0;
/// Direction from the model to the default camera: front left, slightly above. glTF models face +z, so their left side
/// is at +x.
pub const TOWARDS_CAMERA: Vec3 = Vec3::new(0.62, 0.28, 0.73);
/// Direction from the model to a second camera, which shows the opposite side: back right, higher.
pub const BEHIND: Vec3 = Vec3::new(-0.62, 0.5, -0.6);
/// Direction from the model to the default light: high, to the right of the camera, so that the fur's relief is
/// visible.
pub const TOWARDS_LIGHT: Vec3 = Vec3::new(-0.25, 0.75, 0.6);
/// Maximum fraction of the picture that the model fills.
const FILL: f32 = 0.9;

/// Number of directions that are framed for an orbiting camera. Between two of them the model extends up to 0.5 %
/// further: 1 / cos(180° / 32).
const SIDES: u16 = 32;

/// Direction of the camera for framing. As text: `AZ,EL` or `AZ,EL,ZOOM`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Azimuth in degrees about the vertical axis: 0 in front (+z), 90 at the model's left (+x).
    pub azimuth_deg: f32,
    /// Elevation in degrees above the horizon, -90..=90.
    pub elevation_deg: f32,
    /// Magnification of the nearest side, in the range [`Self::ZOOM`]. Above 1 the camera moves closer; below 1 it
    /// moves away.
    pub zoom: f32,
}

impl Orbit {
    /// Minimum and maximum zoom.
    pub const ZOOM: [f32; 2] = [0.01, 100.0];

    /// Returns the unit vector from the model to the camera.
    pub fn towards(&self) -> Vec3 {
        let (sin, cos) = self.azimuth_deg.to_radians().sin_cos();
        let (up, along) = self.elevation_deg.to_radians().sin_cos();
        Vec3::new(sin * along, up, cos * along)
    }
}

impl FromStr for Orbit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (azimuth_deg, elevation_deg, zoom) = match numbers(text).as_deref() {
            Some([azimuth, elevation]) => (*azimuth, *elevation, 1.0),
            Some([azimuth, elevation, zoom]) => (*azimuth, *elevation, *zoom),
            _ => return Err("expected azimuth and elevation in degrees, optionally a zoom, such as 45,20,1.5".into()),
        };
        if !(-90.0..=90.0).contains(&elevation_deg) {
            return Err(format!("elevation: found {elevation_deg}, expected -90 to 90 degrees"));
        }
        let [least, greatest] = Self::ZOOM;
        if !(least..=greatest).contains(&zoom) {
            return Err(format!("zoom: found {zoom}, expected {least} to {greatest}"));
        }
        Ok(Self { azimuth_deg, elevation_deg, zoom })
    }
}

/// Settings for positioning a camera automatically.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Framing {
    /// Camera direction; `None` for [`TOWARDS_CAMERA`].
    pub orbit: Option<Orbit>,
    /// Name of a material or joint whose vertices are framed ([`crate::outline`]). `None` frames everything.
    pub look_at: Option<String>,
    /// Whether the camera orbits. The framed points then stay in the picture from all sides, and the target is on the
    /// vertical axis.
    pub all_around: bool,
}

impl Framing {
    fn towards(&self) -> Vec3 {
        self.orbit.map_or(TOWARDS_CAMERA, |orbit| orbit.towards())
    }

    /// Returns the camera that frames `points`, with `margin_m` of fur around them.
    ///
    /// * `aspect`: width of the picture divided by its height
    pub fn view(&self, points: &[Vec3], margin_m: f32, aspect: f32) -> Viewpoint {
        let zoom = self.orbit.map_or(1.0, |orbit| orbit.zoom);
        if !self.all_around {
            return frame_nearer(points, margin_m, aspect, self.towards(), zoom);
        }
        let (min, max) = points.iter().fold((Vec3::MAX, Vec3::MIN), |(min, max), p| (min.min(*p), max.max(*p)));
        let axis = if points.is_empty() { Vec3::ZERO } else { (min + max) / 2.0 };
        let outer = outermost(points, self.edges(aspect).into_iter());
        let around = |turn: Quat| outer.iter().map(move |i| axis + turn * (points[*i] - axis));
        let all: Vec<Vec3> = turns().flat_map(around).collect();
        let view = frame_nearer(&all, margin_m, aspect, self.towards(), zoom);
        // By symmetry the line of sight crosses the axis; the target is placed there.
        let way = (view.target - view.eye).normalize_or(-self.towards());
        let (flat, off) = (way.with_y(0.0), (axis - view.eye).with_y(0.0));
        let flat_length = flat.length();
        let target = if flat_length > 1e-3 { view.eye + way * (off.length() / flat_length) } else { view.target };
        Viewpoint { target: if target == view.eye { view.target } else { target }, ..view }
    }

    /// Returns world-space directions; the outermost points along them determine [`Self::view`].
    pub(crate) fn edges(&self, aspect: f32) -> Vec<Vec3> {
        let world = view_from_world(Vec3::ZERO, -self.towards().normalize()).inverse();
        let [tan_x, tan_y] = slopes(aspect);
        let edges = [(1.0, 0.0, tan_x), (-1.0, 0.0, tan_x), (0.0, 1.0, tan_y), (0.0, -1.0, tan_y), (0.0, 0.0, 1.0)];
        let edges = edges.map(|edge| world.transform_vector3(Vec3::from(edge)));
        if !self.all_around {
            return edges.to_vec();
        }
        // Rotating the points is equivalent to rotating the edges the other way, so the result includes the edges of a
        // full turn.
        turns().flat_map(|turn| edges.map(|edge| turn * edge)).collect()
    }
}

/// Returns the rotations that divide a full turn about the vertical axis.
fn turns() -> impl Iterator<Item = Quat> {
    (0..SIDES).map(|i| Quat::from_rotation_y(std::f32::consts::TAU * f32::from(i) / f32::from(SIDES)))
}

/// Returns the indices of the outermost points in the given directions, which may have any length. Each index appears
/// once, in ascending order.
pub(crate) fn outermost(points: &[Vec3], directions: impl Iterator<Item = Vec3>) -> Vec<usize> {
    let farthest = |direction: Vec3| {
        let along = points.iter().map(|point| direction.dot(*point)).enumerate();
        along.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(i, _)| i)
    };
    let mut outer: Vec<usize> = directions.filter_map(farthest).collect();
    outer.sort_unstable();
    outer.dedup();
    outer
}

/// Returns the extent of the fillable part of the picture to the right and up, at a distance of one metre from the eye.
fn slopes(aspect: f32) -> [f32; 2] {
    let tan_y = (FOV_DEG.to_radians() / 2.0).tan() * FILL;
    [tan_y * aspect, tan_y]
}

/// Returns the view from direction `towards` that shows all `points`, with `margin_m` of fur around them. `towards` may
/// have any length.
///
/// The model is as large in the picture as possible. Without points, the view looks at the origin from a distance of
/// one metre.
///
/// * `aspect`: width of the picture divided by its height
pub fn frame(points: &[Vec3], margin_m: f32, aspect: f32, towards: Vec3) -> Viewpoint {
    frame_nearer(points, margin_m, aspect, towards, 1.0)
}

fn frame_nearer(points: &[Vec3], margin_m: f32, aspect: f32, towards: Vec3, zoom: f32) -> Viewpoint {
    let (eye, target) = eye_and_target(points, margin_m, aspect, towards, zoom);
    Viewpoint { eye, target, fov_deg: FOV_DEG }
}

fn eye_and_target(points: &[Vec3], margin_m: f32, aspect: f32, towards: Vec3, zoom: f32) -> (Vec3, Vec3) {
    let towards = towards.normalize();
    let view = view_from_world(Vec3::ZERO, -towards);
    let [tan_x, tan_y] = slopes(aspect);
    // A point is inside the right edge of a camera at (x0, y0, z0) if x − x0 <= tan_x (z0 − z). Each edge thus requires
    // a minimum of tan_x z0 ± x0. That minimum depends only on the outermost point along the normal of the edge's
    // plane.
    let mut need = [f32::NEG_INFINITY; 4];
    let in_view: Vec<Vec3> = points.iter().map(|p| view.transform_point3(*p)).collect();
    for p in &in_view {
        // A slanted plane touches the sphere of fur around a point before it reaches the point itself. It does so
        // earlier by the margin divided by the cosine of the plane's angle.
        let (mx, my) = (margin_m * (1.0 + tan_x * tan_x).sqrt(), margin_m * (1.0 + tan_y * tan_y).sqrt());
        let edges = [p.z * tan_x + p.x + mx, p.z * tan_x - p.x + mx, p.z * tan_y + p.y + my, p.z * tan_y - p.y + my];
        need = std::array::from_fn(|i| need[i].max(edges[i]));
    }
    let Some(nearest) = in_view.iter().map(|p| p.z).reduce(f32::max) else { return (towards, Vec3::ZERO) };
    let [right, left, top, bottom] = need;
    let mut z0 = ((right + left) / (2.0 * tan_x)).max((top + bottom) / (2.0 * tan_y));
    if z0 - nearest <= 1e-6 * (1.0 + z0.abs()) {
        // All points coincide and have no fur, so any distance will do.
        z0 = nearest + 1.0;
    }
    if zoom != 1.0 {
        // The camera moves towards the nearest hair, but never into it.
        let front = (nearest + margin_m).min(z0);
        let front = if z0 - front > 1e-6 * (1.0 + z0.abs()) { front } else { nearest };
        z0 = front + (z0 - front) / zoom;
    }
    let eye = Vec3::new((right - left) / 2.0, (top - bottom) / 2.0, z0);
    let middle = in_view.iter().map(|p| p.z).sum::<f32>() / in_view.len() as f32;
    // The mean of many equal numbers may be rounded up, beyond the nearest point.
    let target = Vec3::new(eye.x, eye.y, middle.min(nearest));
    let world = view.inverse();
    (world.transform_point3(eye), world.transform_point3(target))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framed_points_fill_the_picture() {
        let points: Vec<Vec3> = (0..500)
            .map(|i| {
                let t = i as f32;
                Vec3::new(2.0 * (t * 0.7).sin(), 1.0 + (t * 1.3).cos(), 5.0 * (t * 0.31).sin())
            })
            .collect();
        for (aspect, towards) in [(0.5, TOWARDS_CAMERA), (1.0, BEHIND), (2.0, TOWARDS_CAMERA), (1.0, Vec3::X)] {
            for margin in [0.0, 0.2] {
                let Viewpoint { eye, target, fov_deg } = frame(&points, margin, aspect, towards);
                let view = view_from_world(eye, target);
                let tan_y = (fov_deg.to_radians() / 2.0).tan();
                let on_picture = |p: Vec3| {
                    let p = view.transform_point3(p);
                    (p.x / (tan_y * aspect)).abs().max((p.y / tan_y).abs()) / -p.z
                };
                // Points on the surface of the fur sphere around each point.
                let directions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
                let ball = points.iter().flat_map(|p| directions.map(|d| *p + d * margin));
                let widest = ball.map(on_picture).fold(0.0, f32::max);
                assert!(widest <= FILL + 1e-3, "aspect {aspect}, margin {margin}: the outermost point is at {widest}");
                assert!(
                    widest > FILL - 0.05,
                    "aspect {aspect}, margin {margin}: the outermost point is only at {widest}"
                );
            }
        }
    }

    #[test]
    fn orbiting_camera_keeps_all_points_in_view() {
        let points: Vec<Vec3> = (0..200)
            .map(|i| Vec3::new(3.0 + (i as f32).sin(), (i as f32 * 0.7).cos(), 2.0 * (i as f32 * 1.9).sin()))
            .collect();
        for (elevation_deg, aspect) in [(0.0, 1.0), (40.0, 2.0), (-20.0, 0.5), (90.0, 1.0)] {
            let orbit = Some(Orbit { azimuth_deg: 30.0, elevation_deg, zoom: 1.0 });
            let framing = Framing { orbit, look_at: None, all_around: true };
            let Viewpoint { eye, target, fov_deg } = framing.view(&points, 0.1, aspect);
            let tan_y = (fov_deg.to_radians() / 2.0).tan();
            let mut widest = 0.0_f32;
            for step in 0..90 {
                let turned = target + Quat::from_rotation_y((4.0 * step as f32).to_radians()) * (eye - target);
                let view = view_from_world(turned, target);
                for point in &points {
                    let p = view.transform_point3(*point);
                    widest = widest.max((p.x / (tan_y * aspect)).abs().max((p.y / tan_y).abs()) / -p.z);
                }
            }
            assert!((0.7..0.93).contains(&widest), "elevation {elevation_deg}: the outermost point is at {widest}");
        }
    }

    #[test]
    fn zoom_moves_closer_and_never_past_the_nearest_point() {
        let points = [Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0), Vec3::new(-1.0, 0.5, 0.0)];
        let view = |zoom| {
            let orbit = Some(Orbit { azimuth_deg: 0.0, elevation_deg: 0.0, zoom });
            Framing { orbit, ..Framing::default() }.view(&points, 0.0, 1.0)
        };
        let distance = |zoom| view(zoom).eye.z - 3.0;
        for zoom in [0.01, 0.5, 2.0, 100.0] {
            assert!((distance(zoom) * zoom / distance(1.0) - 1.0).abs() < 1e-2, "zoom {zoom}: {}", distance(zoom));
        }
        assert!(distance(100.0) > 0.0);
        assert_eq!(view(1.0), frame(&points, 0.0, 1.0, Vec3::Z), "zoom 1 must not change the camera");
    }

    #[test]
    fn outermost_points_give_the_same_framing_as_all_points() {
        let points: Vec<Vec3> =
            (0..500).map(|i| Vec3::new((i as f32).sin(), (i as f32 * 0.7).cos(), (i as f32 * 1.9).sin())).collect();
        let framing = Framing::default();
        let outer: Vec<Vec3> = outermost(&points, framing.edges(1.5).into_iter()).iter().map(|i| points[*i]).collect();
        assert!(outer.len() <= 5);
        let (few, all) = (framing.view(&outer, 0.1, 1.5), framing.view(&points, 0.1, 1.5));
        assert!(few.eye.distance(all.eye) < 1e-4, "found {}, expected {}", few.eye, all.eye);
    }

    #[test]
    fn empty_and_single_points_are_framed() {
        for points in [&[][..], &[Vec3::ONE]] {
            let Viewpoint { eye, target, .. } = frame(points, 0.0, 1.0, TOWARDS_CAMERA);
            assert!(eye.is_finite() && target.is_finite() && eye != target);
        }
    }
}
