//! Event log of a window for scripts and tests, as lines of JSON.

use serde_json::Value;
use std::io::Write;
use std::time::Instant;

/// Event log, one line of JSON per event: `{"ms": 812.5, "event": "made", …}`.
pub struct Events {
    began: Instant,
    to: Option<Box<dyn Write + Send>>,
}

impl Events {
    /// Creates a log that writes to `to`, or discards all events. `began` is the start time of the program.
    pub fn new(began: Instant, to: Option<Box<dyn Write + Send>>) -> Self {
        Self { began, to }
    }

    /// Logs an event with its data, a JSON object.
    pub fn log(&mut self, event: &str, mut with: Value) {
        let Some(to) = &mut self.to else { return };
        if let Some(with) = with.as_object_mut() {
            with.insert("event".into(), event.into());
            with.insert("ms".into(), (1e3 * self.began.elapsed().as_secs_f64()).into());
        }
        if writeln!(to, "{with}").and_then(|()| to.flush()).is_err() {
            // The reader has closed its end; the window continues without the log.
            self.to = None;
        }
    }
}
