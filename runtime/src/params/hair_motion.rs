//! What moves hair on guides.

use crate::error::RuntimeError;
use glam::Vec3;
pub use pelage_formats::meaning::hair_motion::Wind;

/// What moves hair on guides, where packages say how it moves: manes and tails swing, and come to rest.
///
/// Frames say how much time passes ([`crate::FrameParams::time_step_s`]), of which hair lives through at most 2/15 s: a second that is missed is not made up
/// for. Without time it holds still, but goes with the skin. An owner's hair begins as it was groomed in the first frame that has it, and where
/// [`crate::Instance::cut`] is another number.
///
/// Two frames of one moment, for two cameras say, take their time once: let the second have a time step of 0.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HairMotionParams {
    /// Acceleration of everything, metres a second squared (default the earth's, downwards).
    pub gravity: Vec3,
    /// The air, in world space (default still).
    pub wind: Wind,
}

impl Default for HairMotionParams {
    fn default() -> Self {
        let gravity = Vec3::NEG_Y * pelage_formats::meaning::hair_motion::GRAVITY;
        Self { gravity, wind: Wind::default() }
    }
}

impl HairMotionParams {
    /// The same with changes.
    pub fn with(mut self, change: impl FnOnce(&mut Self)) -> Self {
        change(&mut self);
        self
    }

    pub(super) fn check(&self) -> Result<(), RuntimeError> {
        let fail = |field, found: String, expected: &str| {
            Err(RuntimeError::Params { field, found, expected: expected.into() })
        };
        const MOST: f32 = 1e4;
        let within = |v: Vec3| v.is_finite() && v.length() <= MOST;
        if !within(self.gravity) {
            return fail("HairMotionParams::gravity", self.gravity.to_string(), "finite, at most 10000 m/s²");
        }
        let Wind { velocity, gust, gust_s, turbulence, eddy_m, time_s } = self.wind;
        let least = [gust, turbulence].iter().all(|x| (0.0..=100.0).contains(x));
        let positive = [gust_s, eddy_m].iter().all(|x| *x > 0.0 && x.is_finite());
        if within(velocity) && least && positive && time_s.is_finite() {
            return Ok(());
        }
        let expected =
            "a velocity of at most 10000 m/s, gust and turbulence 0..=100, gust_s and eddy_m above 0, a finite time";
        fail("HairMotionParams::wind", format!("{:?}", self.wind), expected)
    }
}
