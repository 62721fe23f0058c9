//! What a window is about, and what all that is done to it has in common.

use crate::knobs::{Edits, Knobs, Search};
use crate::lights::Lights;
use crate::script::Events;
use crate::show::Show;
use crate::truth::TruthBeside;
use crate::worker::Workers;
use crate::workshop::Progress;
use egui::Rect;
use pelage_stage::{FrameTimes, Look};
use serde_json::json;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// So long something that was said stands there.
const SAID: Duration = Duration::from_secs(6);

/// Everything but the window itself.
pub struct App {
    /// What is shown.
    pub show: Show,
    pub(super) workers: Workers,
    /// Of scripts and tests.
    pub events: Events,
    /// Where pictures are saved.
    pub(super) folder: PathBuf,
    /// The file that was opened last.
    pub(super) opened: Option<PathBuf>,
    pub(super) look_base: Look,
    /// Changes of the look.
    pub look_edits: Edits,
    pub look_search: Search,
    pub(super) recipe_base: Option<Box<dyn Knobs>>,
    /// Changes of the recipe.
    pub recipe_edits: Edits,
    pub recipe_search: Search,
    /// Whether the recipe's edits were the last to be changed: what an undo is about.
    pub(super) recipe_last: bool,
    /// What is being made.
    pub working: Option<Progress>,
    /// What is wrong; it stands there until it is mended.
    pub failure: Option<String>,
    /// What the bake had to say.
    pub notes: Vec<String>,
    /// Stages of the last bake with their seconds.
    pub stages: Vec<(String, f64)>,
    /// Passes of the view as it was measured, until it changes.
    pub times: Option<FrameTimes>,
    /// The device, in words.
    pub adapter: String,
    pub(super) said: Option<(String, Instant)>,
    pub playing: bool,
    /// Seconds of the clip in a second.
    pub speed: f32,
    pub(super) played_at: Option<Instant>,
    pub(super) moved_at: Option<Instant>,
    pub truth: TruthBeside,
    pub panels: bool,
    /// Files of light from all around.
    pub(crate) lights: Lights,
    pub help: bool,
    /// The picture in the window, physical pixels.
    pub(super) area: (u32, u32),
    /// The area was another one a frame ago: a picture of it may be of no use in the next.
    pub(super) settles: bool,
    pub(super) sequence: Option<Sequence>,
    /// The window is to be saved with the next frame.
    pub(super) wants_window: bool,
}

/// Pictures that are being saved, one with each frame of the window.
pub(super) struct Sequence {
    pub(super) stem: String,
    pub(super) next: u32,
    pub(super) count: u32,
    /// Where the time was before.
    pub(super) time_s: f32,
}

impl App {
    /// Nothing is shown yet.
    pub fn new(show: Show, workers: Workers, events: Events, folder: PathBuf, look: Look) -> Self {
        Self {
            adapter: String::new(),
            show,
            workers,
            events,
            folder,
            opened: None,
            look_base: look,
            look_edits: Edits::default(),
            look_search: Search::default(),
            recipe_base: None,
            recipe_edits: Edits::default(),
            recipe_search: Search::default(),
            recipe_last: false,
            working: None,
            failure: None,
            notes: Vec::new(),
            stages: Vec::new(),
            times: None,
            said: None,
            playing: false,
            speed: 1.0,
            played_at: None,
            moved_at: None,
            truth: TruthBeside::default(),
            panels: true,
            lights: Lights::default(),
            help: false,
            area: (1, 1),
            settles: false,
            sequence: None,
            wants_window: false,
        }
    }

    /// What is shown is another thing, or seen otherwise.
    pub(super) fn changed(&mut self) {
        self.times = None;
        if self.truth.outdated() {
            self.workers.stop_tracing();
        }
    }

    pub(super) fn fail(&mut self, reason: String) {
        self.events.tell("failure", json!({ "reason": reason }));
        self.failure = Some(reason);
    }

    pub(super) fn mended(&mut self) {
        if self.failure.take().is_some() {
            self.events.tell("mended", json!({}));
        }
    }

    pub(super) fn say(&mut self, text: String) {
        self.said = Some((text, Instant::now()));
    }

    /// What was said last, for a while.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().filter(|(_, when)| when.elapsed() < SAID).map(|(text, _)| text.as_str())
    }

    pub(super) fn moved(&mut self) {
        self.moved_at = Some(Instant::now());
        self.changed();
    }

    /// Where the picture stands in the window, points, with pixels in a point.
    pub fn set_area(&mut self, rect: Rect, pixels: f32) {
        let side = |points: f32| (points * pixels).round().clamp(1.0, 8192.0) as u32;
        let area = (side(rect.width()), side(rect.height()));
        self.settles = area != self.area;
        if self.settles {
            self.area = area;
            self.changed();
        }
    }

    /// Mebibytes on the device.
    pub fn gpu_mib(&self) -> f64 {
        self.show.gpu_bytes() as f64 / f64::from(1 << 20)
    }
}
