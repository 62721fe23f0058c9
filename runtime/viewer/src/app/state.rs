//! State of a window, and operations that all changes share.

use crate::events::Events;
use crate::knobs::{Edits, Knobs, Search};
use crate::lights::Lights;
use crate::show::Show;
use crate::truth::ReferencePane;
use crate::worker::Workers;
use crate::workshop::Progress;
use egui::Rect;
use pelage_stage::{FrameTimes, Look};
use serde_json::json;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Display time of a message.
const MESSAGE_DURATION: Duration = Duration::from_secs(6);

/// State of the application, without the window itself.
pub struct App {
    /// Stage and camera.
    pub show: Show,
    pub(super) workers: Workers,
    /// Event log for scripts and tests.
    pub events: Events,
    /// Folder for saved pictures.
    pub(super) folder: PathBuf,
    /// File opened last.
    pub(super) opened: Option<PathBuf>,
    pub(super) look_base: Look,
    /// Changes of the look.
    pub look_edits: Edits,
    pub look_search: Search,
    pub(super) recipe_base: Option<Box<dyn Knobs>>,
    /// Changes of the recipe.
    pub recipe_edits: Edits,
    pub recipe_search: Search,
    /// Whether the last change was in the recipe rather than the look. Undo applies to the one changed last.
    pub(super) recipe_last: bool,
    /// Whether the recipe's file was changed outside the window after the last change in the window.
    pub(super) changed_outside: bool,
    /// Whether the window has written the recipe's file, so that its next change is not one from outside.
    pub(super) wrote_recipe: bool,
    /// Progress of the content that is being made.
    pub working: Option<Progress>,
    /// Current error, shown until it is fixed.
    pub failure: Option<String>,
    /// Notes of the bake.
    pub notes: Vec<String>,
    /// Whether the content is new, and no whole picture of it was drawn yet.
    pub(super) is_new: bool,
    /// Stages of the last bake, with their times in seconds.
    pub stages: Vec<(String, f64)>,
    /// Measured pass times of the current view; cleared when the view changes.
    pub times: Option<FrameTimes>,
    /// Description of the device.
    pub adapter: String,
    pub(super) said: Option<(String, Instant)>,
    pub playing: bool,
    /// Playback speed, seconds of the clip per second.
    pub speed: f32,
    pub(super) played_at: Option<Instant>,
    pub(super) moved_at: Option<Instant>,
    pub truth: ReferencePane,
    pub panels: bool,
    /// Cache of environment maps.
    pub(crate) lights: Lights,
    pub help: bool,
    /// Size of the picture area in the window, physical pixels.
    pub(super) area: (u32, u32),
    /// Whether the size changed in this frame. Drawing is then skipped once, because the size may change again.
    pub(super) settles: bool,
    pub(super) sequence: Option<Sequence>,
    /// Whether the next frame saves a screenshot of the window.
    pub(super) wants_window: bool,
}

/// Sequence that is being saved, one picture per frame of the window.
pub(super) struct Sequence {
    pub(super) stem: String,
    pub(super) next: u32,
    pub(super) count: u32,
    /// Time of the animation before saving started, seconds; restored afterwards.
    pub(super) time_s: f32,
}

impl App {
    /// Creates the state of an empty window.
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
            changed_outside: false,
            wrote_recipe: false,
            working: None,
            failure: None,
            notes: Vec::new(),
            is_new: false,
            stages: Vec::new(),
            times: None,
            said: None,
            playing: false,
            speed: 1.0,
            played_at: None,
            moved_at: None,
            truth: ReferencePane::default(),
            panels: true,
            lights: Lights::default(),
            help: false,
            area: (1, 1),
            settles: false,
            sequence: None,
            wants_window: false,
        }
    }

    /// Invalidates results that depend on the content or the view.
    pub(super) fn changed(&mut self) {
        self.times = None;
        if self.truth.outdated() {
            self.workers.stop_tracing();
        }
    }

    pub(super) fn fail(&mut self, reason: String) {
        self.events.log("failure", json!({ "reason": reason }));
        self.failure = Some(reason);
    }

    pub(super) fn clear_failure(&mut self) {
        if self.failure.take().is_some() {
            self.events.log("mended", json!({}));
        }
    }

    pub(super) fn say(&mut self, text: String) {
        self.said = Some((text, Instant::now()));
    }

    /// Returns the last message, as long as it is displayed.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().filter(|(_, when)| when.elapsed() < MESSAGE_DURATION).map(|(text, _)| text.as_str())
    }

    pub(super) fn moved(&mut self) {
        self.moved_at = Some(Instant::now());
        self.changed();
    }

    /// Sets the picture's rectangle in the window, points. `pixels` is the number of physical pixels per point.
    pub fn set_area(&mut self, rect: Rect, pixels: f32) {
        let side = |points: f32| (points * pixels).round().clamp(1.0, 8192.0) as u32;
        let area = (side(rect.width()), side(rect.height()));
        self.settles = area != self.area;
        if self.settles {
            self.area = area;
            self.changed();
        }
    }

    /// Returns the memory used on the device, mebibytes.
    pub fn gpu_mib(&self) -> f64 {
        self.show.gpu_bytes() as f64 / f64::from(1 << 20)
    }
}
