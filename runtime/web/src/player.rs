//! Playback of a clip: playing, pausing and seeking.

use pelage_runtime::Motion;
use pelage_stage::wrap_time;

/// Current clip and its playback state. Without a clip the model is at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Player {
    /// Index of the clip in its package, and its duration in seconds.
    pub clip: Option<(usize, f32)>,
    /// Time in the clip, seconds, 0 to its duration.
    pub time_s: f32,
    /// Playback speed, clip seconds per second; below 0 the clip runs backwards.
    pub speed: f32,
    /// Whether the clip is playing.
    pub playing: bool,
}

impl Player {
    /// Returns the state of a model at rest.
    pub const fn at_rest() -> Self {
        Self { clip: None, time_s: 0.0, speed: 1.0, playing: false }
    }

    /// Moves to another time; clips loop.
    pub fn seek(&mut self, time_s: f32) {
        self.time_s = self.clip.map_or(0.0, |(_, duration_s)| wrap_time(time_s, duration_s));
    }

    /// Advances time by `elapsed_s` seconds. Returns whether the pose has changed.
    pub fn advance(&mut self, elapsed_s: f32) -> bool {
        let before = self.time_s;
        if self.playing {
            self.seek(self.time_s + self.speed * elapsed_s);
        }
        self.time_s != before
    }

    /// Returns the model's motion.
    pub fn motion(&self) -> Motion {
        match self.clip {
            Some((clip, _)) => Motion::Clip { clip, time_s: self.time_s },
            None => Motion::Rest,
        }
    }
}
