//! Saving of the recipe, the look, pictures and screenshots of the window.

use super::state::{App, Sequence};
use crate::save;
use crate::subject::Subject;
use crate::workshop::Progress;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Frame rate of a saved sequence, pictures per second.
const FPS: f32 = 24.0;

impl App {
    pub(super) fn tell_saved(&mut self, what: &str, saved: Result<PathBuf, String>) {
        match saved {
            Ok(path) => {
                let path = path.display().to_string();
                self.events.log("saved", json!({ "what": what, "file": path }));
                self.say(format!("{what} saved: {path}"));
            }
            Err(reason) => {
                self.events.log("not saved", json!({ "what": what, "reason": reason }));
                self.say(reason);
            }
        }
    }

    /// Saves the recipe with its changes.
    pub fn save_recipe(&mut self) {
        if self.has_recipe() {
            self.workers.save(self.recipe_edits.assignments());
        } else {
            self.say("the open file was not baked here: there is no recipe to save".into());
        }
    }

    /// Saves the look.
    pub fn save_look(&mut self) {
        let mut look = self.look_now();
        (look.picture.size.width, look.picture.size.height) = self.area;
        let path = save::free(&self.folder, &format!("{}-look", self.stem()), "toml");
        let saved = path.and_then(|path| save::write(&path, look.to_toml().as_bytes()).map(|()| path));
        self.tell_saved("look", saved);
    }

    /// Saves the current picture.
    pub fn save_picture(&mut self) {
        let path = save::free(&self.folder, &self.stem(), "png");
        let saved = path.and_then(|path| self.write_picture(&path).map(|()| path));
        if saved.is_ok()
            && let Ok(view) = self.show.view(self.area)
        {
            let (width, height) = self.area;
            let view = json!({
                "camera": view.to_string(),
                "size": format!("{width}x{height}"),
                "time_s": self.show.time_s(),
            });
            self.events.log("pictured", view);
        }
        self.tell_saved("picture", saved);
    }

    fn write_picture(&mut self, path: &Path) -> Result<(), String> {
        let picture = self.show.picture(self.area).map_err(|error| error.to_string())?;
        save::write_png(path, &picture.ok_or("nothing is shown yet")?)
    }

    /// Returns the title of the window.
    pub fn title(&self) -> String {
        self.show.subject().map_or("pelage".into(), |subject| format!("{} - pelage", save::stem(subject.name())))
    }

    fn stem(&self) -> String {
        save::stem(self.show.subject().map_or("", Subject::name))
    }

    /// Saves one cycle of the clip as a sequence of pictures.
    pub fn save_sequence(&mut self) {
        let Some(length_s) = self.length_s() else { return self.say("no animation to save".into()) };
        let count = (length_s * FPS).round().max(1.0) as u32;
        let stem = format!("{}-{}", self.stem(), self.show.clip().map_or("scene", |clip| clip.name.as_str()));
        let stem = stem.replace(['/', '\\', '|', ':'], "-");
        self.playing = false;
        self.sequence = Some(Sequence { stem, next: 0, count, time_s: self.show.time_s() });
    }

    pub(super) fn go_on_saving(&mut self) {
        let Some(Sequence { stem, next, count, time_s }) = self.sequence.take() else { return };
        if next == count {
            self.show.set_time(time_s);
            self.working = None;
            let first = self.folder.join(format!("{stem}.0000.png"));
            return self.tell_saved("sequence", Ok(first));
        }
        if next == 0 {
            self.show.set_time(0.0);
        } else {
            self.show.advance(1.0 / FPS, 1.0);
        }
        let path = self.folder.join(format!("{stem}.{next:04}.png"));
        if let Err(reason) = self.write_picture(&path) {
            self.working = None;
            return self.tell_saved("sequence", Err(reason));
        }
        let share = Some((next + 1) as f32 / count as f32);
        self.working = Some(Progress { doing: format!("{} of {count} pictures", next + 1), share });
        self.sequence = Some(Sequence { stem, next: next + 1, count, time_s });
    }

    /// Requests a screenshot of the window; the next frame saves it.
    pub fn save_window(&mut self) {
        self.wants_window = true;
    }

    /// Returns the path for the screenshot, if one was requested.
    pub fn take_window(&mut self) -> Option<PathBuf> {
        if !std::mem::take(&mut self.wants_window) {
            return None;
        }
        match save::free(&self.folder, "window", "png") {
            Ok(path) => Some(path),
            Err(reason) => {
                self.say(reason);
                None
            }
        }
    }

    /// Reports the result of saving the screenshot.
    pub fn window_saved(&mut self, saved: Result<PathBuf, String>) {
        self.tell_saved("window", saved);
    }
}
