//! Wind.

use glam::Vec3;

/// Wind, with gusts and turbulence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Mean velocity, m/s.
    pub velocity: Vec3,
    /// Amplitude of gusts, as a share of `velocity`, 0 or more (default 0).
    pub gust: f32,
    /// Period of gusts, seconds (default 3).
    pub gust_s: f32,
    /// Amplitude of the spatial variation, as a share of `velocity`, 0 or more (default 0).
    pub turbulence: f32,
    /// Size of eddies, metres (default 0.5).
    pub eddy_m: f32,
}

impl Default for Wind {
    fn default() -> Self {
        Self { velocity: Vec3::ZERO, gust: 0.0, gust_s: 3.0, turbulence: 0.0, eddy_m: 0.5 }
    }
}

/// Approximates the sine of `turns` full turns. It uses basic arithmetic only, so that the result is the same on every
/// machine.
fn wave(turns: f32) -> f32 {
    let part = turns - (turns + 0.5).floor();
    8.0 * part * (1.0 - 2.0 * part.abs())
}

impl Wind {
    /// Whether the wind changes with time.
    pub fn changes(&self) -> bool {
        self.velocity != Vec3::ZERO && (self.gust > 0.0 || self.turbulence > 0.0)
    }

    /// Returns the velocity of the air at a position in world space and a time in seconds, m/s.
    ///
    /// Gusts are two waves with incommensurable periods; eddies are waves carried along by the wind.
    pub fn at(&self, place: Vec3, time_s: f32) -> Vec3 {
        let speed = self.velocity.length();
        let moment = time_s / self.gust_s.max(1e-3);
        let swell = 0.6 * wave(moment) + 0.4 * wave(2.618 * moment + 0.3);
        let carried = (place - self.velocity * time_s) / self.eddy_m.max(1e-3);
        let eddy = Vec3::new(
            wave(carried.dot(Vec3::new(0.31, 0.83, 0.47)) + 0.1) + wave(carried.dot(Vec3::new(-1.1, 0.4, 1.6)) + 0.7),
            wave(carried.dot(Vec3::new(0.79, -0.29, 0.53)) + 0.4) + wave(carried.dot(Vec3::new(0.9, 1.7, -0.6)) + 0.2),
            wave(carried.dot(Vec3::new(-0.41, 0.57, 0.71)) + 0.8) + wave(carried.dot(Vec3::new(1.5, -0.7, 1.0)) + 0.5),
        );
        self.velocity * (1.0 + self.gust * swell) + eddy * (0.5 * self.turbulence * speed)
    }
}
