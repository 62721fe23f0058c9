//! Messages from the window's threads.

use super::state::App;
use crate::worker::Told;
use crate::workshop::Made;
use egui::Context;
use serde_json::json;
use std::time::Duration;

impl App {
    /// Handles a message from a thread.
    pub fn hear(&mut self, told: Told, ctx: &Context) {
        match told {
            Told::Working(progress) => self.working = Some(progress),
            Told::Made(made, took) => self.made(*made, took),
            Told::Failed(reason) => {
                self.working = None;
                self.fail(reason);
            }
            Told::Saved(saved) => {
                // The file now contains the edits, and is watched.
                let saved = saved.inspect(|_| self.recipe_edits.forget());
                self.tell_saved("recipe", saved);
            }
            Told::Tracing(progress) => self.truth.progressed(progress),
            Told::Truth(truth) => {
                let flip = truth.flip.as_ref().map(|(mean, _)| *mean);
                let (samples, of_samples) = (truth.samples, truth.of_samples);
                self.events.tell("truth", json!({ "samples": samples, "of_samples": of_samples, "flip": flip }));
                self.truth.take(ctx, *truth);
            }
            Told::NoTruth(reason) => {
                self.events.tell("no truth", json!({ "reason": reason }));
                self.truth.failed(reason);
            }
        }
    }

    fn made(&mut self, made: Made, took: Duration) {
        let Made { subject, look, recipe, notes, stages } = made;
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
        self.mended();
        (self.recipe_base, self.notes, self.stages) = (recipe, notes, stages);
        // On a software device the first picture is small, so that it appears soon.
        self.moved();
        let stages: Vec<_> = self.stages.iter().map(|(name, s)| json!({ "name": name, "seconds": s })).collect();
        self.events.tell("made", json!({ "name": name, "seconds": took.as_secs_f64(), "stages": stages }));
    }
}
