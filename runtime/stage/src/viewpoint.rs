//! From where a picture is seen, at one moment and over time.

use crate::track::Track;
use glam::Vec3;

/// From where a picture is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// Metres.
    pub eye: Vec3,
    /// Metres; apart from `eye`.
    pub target: Vec3,
    /// Height of the view, degrees, 1..=170.
    pub fov_deg: f32,
}

/// A camera over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Shot {
    /// Metres.
    pub eye: Track<Vec3>,
    /// Metres.
    pub target: Track<Vec3>,
    /// Height of the view, degrees.
    pub fov_deg: Track<f32>,
}

impl Shot {
    /// The same at all times.
    pub fn fixed(view: Viewpoint) -> Self {
        Self { eye: Track::fixed(view.eye), target: Track::fixed(view.target), fov_deg: Track::fixed(view.fov_deg) }
    }

    /// The view at `time_s`.
    pub fn at(&self, time_s: f32) -> Viewpoint {
        // A cubic may swing past its keys.
        let fov_deg = self.fov_deg.at(time_s).clamp(1.0, 170.0);
        Viewpoint { eye: self.eye.at(time_s), target: self.target.at(time_s), fov_deg }
    }
}
