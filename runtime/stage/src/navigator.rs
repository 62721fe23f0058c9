//! Interactive camera.

use crate::Viewpoint;
use glam::{Quat, Vec2, Vec3};
use pelage_formats::meaning::view_from_world;

/// Maximum elevation of the camera above and below its target, degrees. At 90 degrees the azimuth would be undefined.
const HIGHEST_DEG: f32 = 89.0;
/// Minimum and maximum distance to the target, relative to the distance in the view passed to [`Navigator::frame`].
const REACH: [f32; 2] = [1e-3, 1e3];

/// Camera that orbits its target, pans, zooms, or flies through the scene. Plain data, independent of input devices.
///
/// Movements on the screen are in picture heights, right and up, and thus independent of the picture's size. A pan
/// moves points at the target's distance by exactly the movement, so that a grabbed point stays under the cursor. A
/// zoom keeps the point under the cursor in place, if it is at the target's distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigator {
    view: Viewpoint,
    home: Viewpoint,
}

impl Navigator {
    /// Creates a camera at `view`, to which [`Self::reset`] returns.
    pub fn new(view: Viewpoint) -> Self {
        Self { view, home: view }
    }

    /// Returns the current view.
    pub fn view(&self) -> Viewpoint {
        self.view
    }

    /// Moves to `view`, such as one of [`crate::Framing::view`], and makes it the home view.
    pub fn frame(&mut self, view: Viewpoint) {
        *self = Self::new(view);
    }

    /// Moves to `view` without changing the home view.
    pub fn go_to(&mut self, view: Viewpoint) {
        self.view = view;
    }

    /// Returns to the home view.
    pub fn reset(&mut self) {
        self.view = self.home;
    }

    /// Returns whether the camera is at the home view.
    pub fn is_home(&self) -> bool {
        self.view == self.home
    }

    /// Returns the spherical coordinates of the camera relative to the target: azimuth, elevation and distance. Azimuth
    /// is in degrees about the vertical axis from +z towards +x, elevation in degrees above the horizon, distance in
    /// metres.
    pub fn spherical(&self) -> (f32, f32, f32) {
        polar(self.view.eye - self.view.target)
    }

    /// Sets the spherical coordinates of the camera, as returned by [`Self::spherical`]. Clamps elevation and distance
    /// to their ranges.
    pub fn set_spherical(&mut self, azimuth_deg: f32, elevation_deg: f32, distance_m: f32) {
        let towards = towards(azimuth_deg, elevation_deg);
        self.view.eye = self.view.target + towards * self.reachable(distance_m);
    }

    /// Looks at another target from the same direction and distance.
    ///
    /// * `target`: in world space, metres
    pub fn look_at(&mut self, target: Vec3) {
        self.view = Viewpoint { eye: self.view.eye + target - self.view.target, target, ..self.view };
    }

    /// Orbits the target. The model turns with the cursor by half a turn per picture height.
    pub fn orbit(&mut self, moved: Vec2) {
        let (azimuth_deg, elevation_deg, distance_m) = self.spherical();
        self.set_spherical(azimuth_deg - 180.0 * moved.x, elevation_deg - 180.0 * moved.y, distance_m);
    }

    /// Pans the view. Points at the target's distance move with the cursor.
    pub fn pan(&mut self, moved: Vec2) {
        let [right, up] = self.axes();
        let way = -(right * moved.x + up * moved.y) * self.height_m();
        self.shift(way);
    }

    /// Moves closer by `factor`, or away if it is below 1. Keeps the point under the cursor in place.
    ///
    /// * `at`: cursor position in picture heights, right and up from the centre
    pub fn zoom(&mut self, factor: f32, at: Vec2) {
        if !factor.is_finite() || factor <= 0.0 {
            return;
        }
        let [right, up] = self.axes();
        let below = self.view.target + (right * at.x + up * at.y) * self.height_m();
        let distance_m = self.view.eye.distance(self.view.target);
        let kept = self.reachable(distance_m / factor) / distance_m;
        self.view.eye = below + (self.view.eye - below) * kept;
        self.view.target = below + (self.view.target - below) * kept;
    }

    /// Flies through the scene, in metres to the right, up and along the view direction.
    pub fn fly(&mut self, right_m: f32, up_m: f32, ahead_m: f32) {
        let [right, _] = self.axes();
        let ahead = (self.view.target - self.view.eye).normalize_or(Vec3::NEG_Z);
        self.shift(right * right_m + Vec3::Y * up_m + ahead * ahead_m);
    }

    /// Turns the view. The eye stays, and visible points move with the cursor.
    pub fn turn(&mut self, moved: Vec2) {
        let (azimuth_deg, elevation_deg, distance_m) = self.spherical();
        let degrees = self.view.fov_deg;
        let towards = towards(azimuth_deg + degrees * moved.x, elevation_deg + degrees * moved.y);
        self.view.target = self.view.eye - towards * distance_m;
    }

    /// Rotates the camera about the vertical axis through its target.
    pub fn rotate(&mut self, angle_rad: f32) {
        self.view = self.view.turned(angle_rad);
    }

    /// Returns the height of the picture at the target's distance, metres.
    pub fn height_m(&self) -> f32 {
        2.0 * self.view.eye.distance(self.view.target) * (self.view.fov_deg.to_radians() / 2.0).tan()
    }

    fn reachable(&self, distance_m: f32) -> f32 {
        let framed = self.home.eye.distance(self.home.target);
        distance_m.clamp(REACH[0] * framed, REACH[1] * framed)
    }

    fn shift(&mut self, way: Vec3) {
        // If the eye and the target would coincide in floating point, the camera does not move.
        let (eye, target) = (self.view.eye + way, self.view.target + way);
        if eye.is_finite() && target.is_finite() && eye != target {
            self.view = Viewpoint { eye, target, ..self.view };
        }
    }

    /// Returns the right and up directions of the picture.
    fn axes(&self) -> [Vec3; 2] {
        let world = view_from_world(self.view.eye, self.view.target).inverse();
        [world.transform_vector3(Vec3::X), world.transform_vector3(Vec3::Y)]
    }
}

/// Returns azimuth and elevation, degrees, and the length.
fn polar(way: Vec3) -> (f32, f32, f32) {
    let length = way.length();
    let elevation = (way.y / length.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0).asin();
    (way.x.atan2(way.z).to_degrees(), elevation.to_degrees(), length)
}

/// Returns the unit vector with this azimuth and elevation, degrees.
fn towards(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let elevation = elevation_deg.clamp(-HIGHEST_DEG, HIGHEST_DEG).to_radians();
    let turn = Quat::from_rotation_y(azimuth_deg.to_radians()) * Quat::from_rotation_x(-elevation);
    turn * Vec3::Z
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: Viewpoint =
        Viewpoint { eye: Vec3::new(1.0, 2.0, 5.0), target: Vec3::new(1.0, 1.0, 0.0), fov_deg: 30.0 };

    /// Returns the projection of a point on the screen, in picture heights right and up from the centre.
    fn seen(navigator: &Navigator, point: Vec3) -> Vec2 {
        let Viewpoint { eye, target, fov_deg } = navigator.view();
        let p = view_from_world(eye, target).transform_point3(point);
        Vec2::new(p.x, p.y) / (-p.z * 2.0 * (fov_deg.to_radians() / 2.0).tan())
    }

    #[test]
    fn an_orbit_keeps_target_and_distance_and_stops_below_the_pole() {
        let mut navigator = Navigator::new(VIEW);
        for moved in [Vec2::new(0.3, 0.1), Vec2::new(-2.0, 0.4), Vec2::new(0.0, -9.0), Vec2::new(0.0, 9.0)] {
            navigator.orbit(moved);
            let view = navigator.view();
            assert!((view.eye.distance(view.target) - VIEW.eye.distance(VIEW.target)).abs() < 1e-4);
            assert_eq!(view.target, VIEW.target);
        }
        assert!((navigator.spherical().1 + HIGHEST_DEG).abs() < 0.05, "{:?}", navigator.spherical());
        navigator.reset();
        assert_eq!(navigator.view(), VIEW);
    }

    #[test]
    fn small_orbit_moves_the_front_with_the_pointer() {
        let mut navigator = Navigator::new(VIEW);
        let front = VIEW.target + (VIEW.eye - VIEW.target).normalize() * 0.3;
        navigator.orbit(Vec2::new(0.01, 0.01));
        let at = seen(&navigator, front);
        assert!(at.x > 0.0 && at.y > 0.0, "{at}");
    }

    #[test]
    fn panned_point_stays_under_the_pointer() {
        let mut navigator = Navigator::new(VIEW);
        let before = seen(&navigator, VIEW.target);
        navigator.pan(Vec2::new(0.2, -0.1));
        let moved = seen(&navigator, VIEW.target) - before;
        assert!(moved.distance(Vec2::new(0.2, -0.1)) < 1e-4, "{moved}");

        let at = Vec2::new(-0.3, 0.25);
        let mut navigator = Navigator::new(VIEW);
        let [right, up] = navigator.axes();
        let below = VIEW.target + (right * at.x + up * at.y) * navigator.height_m();
        assert!(seen(&navigator, below).distance(at) < 1e-4);
        navigator.zoom(2.0, at);
        assert!(seen(&navigator, below).distance(at) < 1e-4);
        let distance = |n: &Navigator| n.view().eye.distance(n.view().target);
        assert!((distance(&navigator) * 2.0 / distance(&Navigator::new(VIEW)) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn extreme_movements_keep_the_camera_finite() {
        let mut navigator = Navigator::new(VIEW);
        for factor in [1e30, 1e-30, 0.0, -1.0, f32::NAN, f32::INFINITY] {
            (0..20).for_each(|_| navigator.zoom(factor, Vec2::new(0.4, -0.4)));
            let view = navigator.view();
            assert!(view.eye.is_finite() && view.target.is_finite() && view.eye != view.target, "{factor}: {view}");
            assert!(view.to_string().parse::<Viewpoint>().is_ok());
        }
        navigator.fly(f32::INFINITY, 0.0, 0.0);
        assert!(navigator.view().eye.is_finite());
    }

    #[test]
    fn turning_keeps_the_position_and_moves_the_view_with_the_pointer() {
        let mut navigator = Navigator::new(VIEW);
        let before = seen(&navigator, VIEW.target);
        navigator.turn(Vec2::new(0.05, 0.02));
        assert_eq!(navigator.view().eye, VIEW.eye);
        let moved = seen(&navigator, VIEW.target) - before;
        assert!((moved - Vec2::new(0.05, 0.02)).length() < 0.01, "{moved}");
        navigator.fly(0.0, 0.0, 1.0);
        assert!(navigator.view().eye.distance(VIEW.eye) - 1.0 < 1e-4);
    }

    #[test]
    fn orbit_angles_describe_the_camera_position() {
        let mut navigator = Navigator::new(VIEW);
        navigator.set_spherical(90.0, 0.0, 3.0);
        let away = navigator.view().eye - navigator.view().target;
        assert!(away.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-5, "{away}");
        let (azimuth_deg, elevation_deg, distance_m) = navigator.spherical();
        assert!((azimuth_deg - 90.0).abs() < 1e-3 && elevation_deg.abs() < 1e-3 && (distance_m - 3.0).abs() < 1e-5);
        navigator.look_at(Vec3::ZERO);
        assert!(navigator.view().eye.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-5);
    }
}
