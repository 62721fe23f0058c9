//! What moves hair on guides, and fur.

use crate::error::RuntimeError;
use glam::Vec3;
pub use pelage_formats::meaning::hair_motion::Wind;

/// What moves hair: fur leans, and hair on guides swings where packages say how, and all comes to rest.
///
/// Hair lives from the moment of an owner's last frame to that of this one ([`crate::FrameParams::time_s`]), through at most 2/15 s: a second that is missed
/// is not made up for, and time that goes backwards is none. Without time it holds still, but goes with the skin. It begins as it was groomed in the first
/// frame that has it, and where [`crate::Instance::cut`] is another number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HairMotionParams {
    /// Acceleration of everything, metres a second squared (default the earth's, downwards).
    pub gravity: Vec3,
    /// The air, in world space (default still).
    pub wind: Wind,
    /// How far fur leans in wind and stride, 0..=4; 1 as it would, 0 not at all (default 1). Fur of less than a pixel's height does not.
    pub fur: f32,
}

impl Default for HairMotionParams {
    fn default() -> Self {
        let gravity = Vec3::NEG_Y * pelage_formats::meaning::hair_motion::GRAVITY;
        Self { gravity, wind: Wind::default(), fur: 1.0 }
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
        if !(0.0..=4.0).contains(&self.fur) {
            return fail("HairMotionParams::fur", self.fur.to_string(), "0..=4");
        }
        let Wind { velocity, gust, gust_s, turbulence, eddy_m } = self.wind;
        let least = [gust, turbulence].iter().all(|x| (0.0..=100.0).contains(x));
        let positive = [gust_s, eddy_m].iter().all(|x| *x > 0.0 && x.is_finite());
        if within(velocity) && least && positive {
            return Ok(());
        }
        let expected = "a velocity of at most 10000 m/s, gust and turbulence 0..=100, gust_s and eddy_m above 0";
        fail("HairMotionParams::wind", format!("{:?}", self.wind), expected)
    }
}
