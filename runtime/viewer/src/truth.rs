//! Reference image beside the rendered one: when it is traced, and its state.

use crate::workshop::{Progress, ReferencePicture};
use egui::{ColorImage, Context, TextureHandle, TextureId, TextureOptions};
use std::time::{Duration, Instant};

/// Time for which the view must be still before its reference image is traced.
const STILL: Duration = Duration::from_millis(300);

/// State of the reference image.
#[derive(Default)]
pub struct ReferencePane {
    asked: bool,
    /// Time since which the view has been still.
    still_since: Option<Instant>,
    /// Whether the reference image of the current view is finished or in progress.
    is_traced: bool,
    latest: Option<ReferencePicture>,
    progress: Option<Progress>,
    failure: Option<String>,
    picture: Option<TextureHandle>,
    map: Option<TextureHandle>,
}

impl ReferencePane {
    /// Returns whether the reference image is shown.
    pub fn is_shown(&self) -> bool {
        self.asked
    }

    /// Shows or hides the reference image.
    pub fn toggle(&mut self) {
        *self = Self { asked: !self.asked, ..Self::default() };
    }

    /// Marks the reference image as outdated, because the view has changed. Returns whether it was finished or in
    /// progress.
    pub fn outdated(&mut self) -> bool {
        self.still_since = Some(Instant::now());
        self.progress = None;
        std::mem::take(&mut self.is_traced)
    }

    /// Returns whether tracing should start now; if so, marks it as started.
    pub fn is_due(&mut self) -> bool {
        let still = self.still_since.get_or_insert_with(Instant::now).elapsed() >= STILL;
        let due = self.asked && !self.is_traced && still;
        self.is_traced |= due;
        due
    }

    /// Returns whether tracing waits until the view is still.
    pub fn waits(&self) -> bool {
        self.asked && !self.is_traced
    }

    /// Stores a refined reference image, with more samples than before.
    pub fn take(&mut self, ctx: &Context, truth: ReferencePicture) {
        let (width, height) = truth.picture.dimensions();
        let size = [width as usize, height as usize];
        let picture = ColorImage::from_rgba_unmultiplied(size, truth.picture.as_raw());
        self.picture = Some(ctx.load_texture("truth", picture, TextureOptions::LINEAR));
        if let Some((_, map)) = &truth.flip {
            let size = [map.width() as usize, map.height() as usize];
            self.map = Some(ctx.load_texture("flip", ColorImage::from_rgb(size, map.as_raw()), TextureOptions::LINEAR));
        }
        self.failure = None;
        self.latest = Some(truth);
    }

    /// Stores the progress of tracing.
    pub fn progressed(&mut self, progress: Progress) {
        self.progress = Some(progress);
    }

    /// Stores the reason for a missing reference image.
    pub fn failed(&mut self, reason: String) {
        (self.failure, self.progress) = (Some(reason), None);
    }

    /// Returns the texture of the reference image, and that of its FLIP map.
    pub fn textures(&self) -> Option<(TextureId, Option<TextureId>)> {
        Some((self.picture.as_ref()?.id(), self.map.as_ref().map(TextureHandle::id)))
    }

    /// Returns a description of the reference image's state.
    pub fn status_text(&self) -> String {
        if let Some(reason) = &self.failure {
            return format!("no reference image: {reason}");
        }
        let samples = self.latest.as_ref().map(|t| format!("traced, {} of {} samples", t.samples, t.of_samples));
        let doing = self.progress.as_ref().filter(|_| !self.is_whole());
        let doing = doing.map(|p| match p.share {
            Some(share) => format!("{} {:.0} %", p.doing, 100.0 * share),
            None => p.doing.clone(),
        });
        let words: Vec<String> = samples.into_iter().chain(doing).collect();
        if words.is_empty() { "tracing starts when the view stops moving".into() } else { words.join("; ") }
    }

    fn is_whole(&self) -> bool {
        self.latest.as_ref().is_some_and(|truth| truth.samples >= truth.of_samples)
    }

    /// Returns a description of the FLIP result.
    pub fn flip_text(&self) -> String {
        let flip = self.latest.as_ref().and_then(|truth| truth.flip.as_ref());
        flip.map_or_else(|| "FLIP".into(), |(mean, _)| format!("FLIP, mean {mean:.4}"))
    }
}
