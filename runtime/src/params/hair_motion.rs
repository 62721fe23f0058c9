//! Motion of guided hair and fur.

use crate::error::RuntimeError;
use glam::Vec3;
pub use pelage_formats::meaning::hair_motion::Wind;

/// Parameters of hair motion. Fur leans, and guided hair swings if the package enables it, until all hair comes to
/// rest.
///
/// Hair advances from the time of an owner's last frame to that of the current one ([`crate::FrameParams::time_s`]), by
/// at most 2/15 s. The rest of a longer gap is skipped; time that runs backwards counts as zero. If no time passes,
/// hair keeps its shape and follows the surface.
///
/// Hair is reset to its groomed state in the first frame with these parameters, and whenever
/// [`crate::Instance::hair_revision`] changes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct HairMotionParams {
    /// Gravitational acceleration, m/s² (default: that of the earth, downwards).
    pub gravity: Vec3,
    /// Wind in world space (default: none).
    pub wind: Wind,
    /// Strength of the fur's lean in wind and movement, 0..=4 (default 1, natural; 0 turns it off). Fur less than a
    /// pixel high does not lean.
    pub fur: f32,
}

impl Default for HairMotionParams {
    fn default() -> Self {
        let gravity = Vec3::NEG_Y * pelage_formats::meaning::hair_motion::GRAVITY;
        Self { gravity, wind: Wind::default(), fur: 1.0 }
    }
}

impl HairMotionParams {
    /// Returns the parameters with changes.
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
