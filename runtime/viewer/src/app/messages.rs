//! Handling of messages from the window's threads.

use super::state::App;
use crate::worker::WorkerMessage;
use crate::workshop::WindowContent;
use egui::Context;
use serde_json::json;
use std::time::Duration;

impl App {
    /// Handles a message from a thread.
    pub fn handle_message(&mut self, told: WorkerMessage, ctx: &Context) {
        match told {
            WorkerMessage::Working(progress) => self.working = Some(progress),
            WorkerMessage::Made(made, took) => self.made(*made, took),
            WorkerMessage::Failed(reason) => {
                self.working = None;
                self.fail(reason);
            }
            WorkerMessage::Saved(saved) => {
                // The file now contains the edits and is watched.
                let saved = saved.inspect(|_| {
                    self.recipe_edits.forget();
                    self.wrote_recipe = true;
                });
                self.tell_saved("recipe", saved);
            }
            WorkerMessage::Tracing(progress) => self.truth.progressed(progress),
            WorkerMessage::Truth(truth) => {
                let flip = truth.flip.as_ref().map(|(mean, _)| *mean);
                let (samples, of_samples) = (truth.samples, truth.of_samples);
                self.events.log("truth", json!({ "samples": samples, "of_samples": of_samples, "flip": flip }));
                self.truth.take(ctx, *truth);
            }
            WorkerMessage::NoTruth(reason) => {
                self.events.log("no truth", json!({ "reason": reason }));
                self.truth.failed(reason);
            }
        }
    }

    fn made(&mut self, made: WindowContent, took: Duration) {
        let WindowContent { subject, look, recipe, notes, stages } = made;
        self.working = None;
        let name = subject.name().to_owned();
        let is_same = self.show.subject().is_some_and(|before| before.name() == name);
        if let Some(look) = look.filter(|_| !is_same) {
            self.look_base = look;
            self.look_edits.forget();
        }
        let shown = self.show.set_look(self.look_now(), self.area).and_then(|()| self.show.show(subject, self.area));
        if let Err(error) = shown {
            return self.fail(error.to_string());
        }
        self.clear_failure();
        let own = std::mem::take(&mut self.wrote_recipe);
        if let (Some(before), Some(after)) = (&self.recipe_base, &recipe)
            && !before.equals(&**after)
        {
            self.changed_outside = is_same && !own;
        }
        (self.recipe_base, self.notes, self.stages) = (recipe, notes, stages);
        self.is_new |= !is_same;
        // A software device draws the first picture at reduced size, so that it appears sooner.
        self.moved();
        let stages: Vec<_> = self.stages.iter().map(|(name, s)| json!({ "name": name, "seconds": s })).collect();
        self.events.log("made", json!({ "name": name, "seconds": took.as_secs_f64(), "stages": stages }));
    }
}
