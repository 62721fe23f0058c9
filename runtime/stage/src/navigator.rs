//! A camera that somebody moves by hand.

use crate::Viewpoint;
use glam::{Quat, Vec2, Vec3};
use pelage_formats::meaning::view_from_world;

/// How far above and below its target the camera goes, degrees: at the pole itself a turn about the vertical axis would have no direction.
const HIGHEST_DEG: f32 = 89.0;
/// Nearest and farthest from the target, in distances of the view that [`Navigator::frame`] gave.
const REACH: [f32; 2] = [1e-3, 1e3];

/// A camera that goes around what it looks at, sideways, nearer, or through the scene; plain data, whatever moves it.
///
/// Movements in the picture are in heights of the picture, right and up, so that they do not depend on its size. What is grabbed stays below the hand:
/// a pan moves what lies as far away as the target by just the movement, and a zoom keeps what lies below the cursor at that distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigator {
    view: Viewpoint,
    home: Viewpoint,
}

impl Navigator {
    /// A camera at `view`, which [`Self::reset`] comes back to.
    pub fn new(view: Viewpoint) -> Self {
        Self { view, home: view }
    }

    /// From where the scene is seen now.
    pub fn view(&self) -> Viewpoint {
        self.view
    }

    /// Goes to `view`, such as one of [`crate::Framing::view`], and is at home there.
    pub fn frame(&mut self, view: Viewpoint) {
        *self = Self::new(view);
    }

    /// Goes to `view`, and still comes home to where it began.
    pub fn go_to(&mut self, view: Viewpoint) {
        self.view = view;
    }

    /// Goes back to where it began.
    pub fn reset(&mut self) {
        self.view = self.home;
    }

    /// Whether it stands where it began.
    pub fn is_home(&self) -> bool {
        self.view == self.home
    }

    /// From the target to the camera: about the vertical axis from +z towards +x, and above the horizon, degrees; metres between them.
    pub fn around(&self) -> (f32, f32, f32) {
        polar(self.view.eye - self.view.target)
    }

    /// Goes to where [`Self::around`] would say so; elevation and distance are brought into their ranges.
    pub fn go_around(&mut self, azimuth_deg: f32, elevation_deg: f32, distance_m: f32) {
        let towards = towards(azimuth_deg, elevation_deg);
        self.view.eye = self.view.target + towards * self.reachable(distance_m);
    }

    /// Looks at another place from the same side and distance, metres.
    pub fn look_at(&mut self, target: Vec3) {
        self.view = Viewpoint { eye: self.view.eye + target - self.view.target, target, ..self.view };
    }

    /// Goes around the target: the thing turns with the hand, half a turn for the height of the picture.
    pub fn orbit(&mut self, moved: Vec2) {
        let (azimuth_deg, elevation_deg, distance_m) = self.around();
        self.go_around(azimuth_deg - 180.0 * moved.x, elevation_deg - 180.0 * moved.y, distance_m);
    }

    /// Goes sideways: what is as far as the target moves with the hand.
    pub fn pan(&mut self, moved: Vec2) {
        let [right, up] = self.axes();
        let way = -(right * moved.x + up * moved.y) * self.height_m();
        self.shift(way);
    }

    /// Goes `factor` times as near, or away below 1, keeping what is at the cursor. `at`: heights of the picture right and up from its middle.
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

    /// Flies through the scene, metres to the right, up and ahead as the camera looks.
    pub fn fly(&mut self, right_m: f32, up_m: f32, ahead_m: f32) {
        let [right, _] = self.axes();
        let ahead = (self.view.target - self.view.eye).normalize_or(Vec3::NEG_Z);
        self.shift(right * right_m + Vec3::Y * up_m + ahead * ahead_m);
    }

    /// Turns the head: the eye stays, and what it sees moves with the hand.
    pub fn turn(&mut self, moved: Vec2) {
        let (azimuth_deg, elevation_deg, distance_m) = self.around();
        let degrees = self.view.fov_deg;
        let towards = towards(azimuth_deg + degrees * moved.x, elevation_deg + degrees * moved.y);
        self.view.target = self.view.eye - towards * distance_m;
    }

    /// The camera carried on about the vertical axis through its target.
    pub fn carry(&mut self, angle_rad: f32) {
        self.view = self.view.turned(angle_rad);
    }

    /// Height of the picture where the target is, metres.
    pub fn height_m(&self) -> f32 {
        2.0 * self.view.eye.distance(self.view.target) * (self.view.fov_deg.to_radians() / 2.0).tan()
    }

    fn reachable(&self, distance_m: f32) -> f32 {
        let framed = self.home.eye.distance(self.home.target);
        distance_m.clamp(REACH[0] * framed, REACH[1] * framed)
    }

    fn shift(&mut self, way: Vec3) {
        // Where numbers are too coarse to keep eye and target apart, it stays where it is.
        let (eye, target) = (self.view.eye + way, self.view.target + way);
        if eye.is_finite() && target.is_finite() && eye != target {
            self.view = Viewpoint { eye, target, ..self.view };
        }
    }

    /// Right and up in the picture.
    fn axes(&self) -> [Vec3; 2] {
        let world = view_from_world(self.view.eye, self.view.target).inverse();
        [world.transform_vector3(Vec3::X), world.transform_vector3(Vec3::Y)]
    }
}

/// Angles about the vertical axis and above the horizon, degrees, and length.
fn polar(way: Vec3) -> (f32, f32, f32) {
    let length = way.length();
    let elevation = (way.y / length.max(f32::MIN_POSITIVE)).clamp(-1.0, 1.0).asin();
    (way.x.atan2(way.z).to_degrees(), elevation.to_degrees(), length)
}

/// The unit vector with those angles, degrees.
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

    /// Where a point is in the picture, heights of it right and up from the middle.
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
        assert!((navigator.around().1 + HIGHEST_DEG).abs() < 0.05, "{:?}", navigator.around());
        navigator.reset();
        assert_eq!(navigator.view(), VIEW);
    }

    #[test]
    fn a_small_orbit_moves_the_front_with_the_hand() {
        let mut navigator = Navigator::new(VIEW);
        let front = VIEW.target + (VIEW.eye - VIEW.target).normalize() * 0.3;
        navigator.orbit(Vec2::new(0.01, 0.01));
        let at = seen(&navigator, front);
        assert!(at.x > 0.0 && at.y > 0.0, "{at}");
    }

    #[test]
    fn what_is_grabbed_stays_below_the_hand() {
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
    fn no_movement_breaks_the_camera() {
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
    fn a_turned_head_keeps_its_place_and_what_it_sees_moves_with_the_hand() {
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
    fn angles_say_where_it_is() {
        let mut navigator = Navigator::new(VIEW);
        navigator.go_around(90.0, 0.0, 3.0);
        let away = navigator.view().eye - navigator.view().target;
        assert!(away.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-5, "{away}");
        let (azimuth_deg, elevation_deg, distance_m) = navigator.around();
        assert!((azimuth_deg - 90.0).abs() < 1e-3 && elevation_deg.abs() < 1e-3 && (distance_m - 3.0).abs() < 1e-5);
        navigator.look_at(Vec3::ZERO);
        assert!(navigator.view().eye.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-5);
    }
}
