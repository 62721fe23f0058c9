//! Frame loop of the window.

use super::state::App;
use crate::subject::Subject;
use crate::workshop::ReferenceRequest;
use pelage_stage::StageError;
use serde_json::json;
use std::time::{Duration, Instant};

/// Time after the last movement during which a software device draws pictures at reduced size.
const SETTLES: Duration = Duration::from_millis(220);

/// Warning for new content of which nothing is visible.
const EMPTY: &str = "warning: the picture shows nothing: surfaces may be one-sided, transparent, too small or out of \
                     view; drag to look from another side, F frames the model";

/// Result of a frame.
#[derive(Clone, Copy, Debug)]
pub struct FrameOutcome {
    /// Whether the picture was redrawn.
    pub drew: bool,
    /// Time until the picture changes by itself; `None` if only user input can change it.
    pub wait: Option<Duration>,
}

impl App {
    /// Advances time and draws what is visible.
    ///
    /// Fails with [`StageError::Device`] if the device is lost. A look that cannot be drawn is shown as a failure in
    /// the window.
    pub fn next_frame(&mut self) -> Result<FrameOutcome, StageError> {
        let now = Instant::now();
        let since = self.played_at.replace(now).map_or(Duration::ZERO, |before| now - before);
        // After a long pause between frames, the clip continues where it was: the step is clamped.
        let seconds = since.as_secs_f32().min(0.25);
        if self.playing {
            self.show.advance(seconds, self.speed);
            self.changed();
        } else if self.sequence.is_none() {
            self.show.advance(seconds, 0.0);
        }
        if std::mem::take(&mut self.settles) {
            return Ok(FrameOutcome { drew: false, wait: Some(Duration::ZERO) });
        }
        self.go_on_saving();
        let moves = self.playing || self.moved_at.is_some_and(|at| at.elapsed() < SETTLES);
        let small = moves && self.show.is_software() && self.sequence.is_none();
        let (width, height) = self.area;
        let size = if small { (width.div_ceil(2), height.div_ceil(2)) } else { (width, height) };
        let first = self.show.last().is_none();
        let drew = match self.show.draw(size, small) {
            Ok(drew) => drew,
            Err(error @ StageError::Device(_)) => return Err(error),
            Err(error) => {
                let reason = error.to_string();
                if self.failure.as_ref() != Some(&reason) {
                    self.fail(reason);
                }
                false
            }
        };
        if drew {
            let took_ms = self.show.last().map_or(0.0, |last| 1e3 * last.took.as_secs_f64());
            let event = if first { "first picture" } else { "picture" };
            self.events.log(event, json!({ "width": size.0, "height": size.1, "took_ms": took_ms }));
            if !small && std::mem::take(&mut self.is_new) && self.show.is_empty()? {
                self.events.log("empty picture", json!({}));
                self.say(EMPTY.into());
            }
        }
        if !moves && self.truth.is_due() {
            self.trace()?;
        }
        let wait = if self.playing || self.sequence.is_some() || self.show.hair_moves() {
            Some(Duration::ZERO)
        } else if moves || self.truth.waits() {
            Some(Duration::from_millis(60))
        } else {
            self.said().map(|_| Duration::from_secs(1))
        };
        Ok(FrameOutcome { drew, wait })
    }

    fn trace(&mut self) -> Result<(), StageError> {
        let Some(Subject::Package(file)) = self.show.subject().cloned() else {
            self.truth.failed("it needs a single package; a scene has several".into());
            return Ok(());
        };
        let Some(drawn) = self.show.picture(self.area)? else { return Ok(()) };
        let mut look = self.look_now();
        (look.picture.size.width, look.picture.size.height) = self.area;
        let camera = self.show.view(self.area)?;
        let clip = self.show.clip().map(|clip| clip.name.clone());
        self.workers.trace(ReferenceRequest { file, look, camera, clip, time_s: self.show.time_s(), drawn });
        Ok(())
    }
}
