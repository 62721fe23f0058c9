//! A clip that people play, hold and wind.

use pelage_runtime::Motion;
use pelage_stage::within;

/// Which clip is shown, and at which moment. Without a clip the model stands at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Player {
    /// Index of the clip in its package, and its length in seconds.
    pub clip: Option<(usize, f32)>,
    /// Moment of the clip, seconds, 0 to its length.
    pub time_s: f32,
    /// Seconds of the clip in a second; below 0 it runs backwards.
    pub speed: f32,
    /// Whether time goes on.
    pub playing: bool,
}

impl Player {
    /// A model at rest.
    pub const fn at_rest() -> Self {
        Self { clip: None, time_s: 0.0, speed: 1.0, playing: false }
    }

    /// Shows another moment; clips loop.
    pub fn seek(&mut self, time_s: f32) {
        self.time_s = self.clip.map_or(0.0, |(_, duration_s)| within(time_s, duration_s));
    }

    /// Lets time go on by so many seconds; whether the pose is another one then.
    pub fn advance(&mut self, elapsed_s: f32) -> bool {
        let before = self.time_s;
        if self.playing {
            self.seek(self.time_s + self.speed * elapsed_s);
        }
        self.time_s != before
    }

    /// What the model does.
    pub fn motion(&self) -> Motion {
        match self.clip {
            Some((clip, _)) => Motion::Clip { clip, time_s: self.time_s },
            None => Motion::Rest,
        }
    }
}
