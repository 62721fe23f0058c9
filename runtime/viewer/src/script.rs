//! What scripts and tests are told while a window is open, as lines of JSON.

use serde_json::Value;
use std::io::Write;
use std::time::Instant;

/// Where what happens is written, a line of JSON each: `{"ms": 812.5, "event": "made", …}`.
pub struct Events {
    began: Instant,
    to: Option<Box<dyn Write + Send>>,
}

impl Events {
    /// To a writer, or to nobody. `began` is when the program did.
    pub fn new(began: Instant, to: Option<Box<dyn Write + Send>>) -> Self {
        Self { began, to }
    }

    /// Tells of something, with what there is to say of it: an object.
    pub fn tell(&mut self, event: &str, mut with: Value) {
        let Some(to) = &mut self.to else { return };
        if let Some(with) = with.as_object_mut() {
            with.insert("event".into(), event.into());
            with.insert("ms".into(), (1e3 * self.began.elapsed().as_secs_f64()).into());
        }
        if writeln!(to, "{with}").and_then(|()| to.flush()).is_err() {
            // Whoever listened is gone; the window stays.
            self.to = None;
        }
    }
}
