//! Progressive reference images for the window, and their difference from the drawn picture.

use crate::environment::Sky;
use crate::truth::ReferenceTracer as TrueView;
use crate::view::PictureView;
use pelage_stage::LookStyle;
use pelage_truth::compare::{CompareParams, compare};
use pelage_truth::{Portion, TracedPicture};
use pelage_viewer::{Outcome, Progress, ReferencePicture, ReferenceRequest, ReferenceSource};
use std::ops::ControlFlow;
use std::sync::Arc;

/// Samples per pixel after each pass. The first pass gives a quick preview; the last equals the default of `pelage
/// reference`.
const PASSES: [u32; 4] = [1, 4, 16, 64];

/// Tracer that keeps the grown strands, to reuse them for the next view of the same pose.
#[derive(Default)]
pub struct Tracer {
    grown: Option<(ReferenceRequest, TrueView)>,
}

impl ReferenceSource for Tracer {
    fn trace(
        &mut self,
        asked: &ReferenceRequest,
        show: &mut dyn FnMut(ReferencePicture),
        progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
    ) -> Outcome<()> {
        if asked.look.picture.style == LookStyle::Ink {
            return Err("found ink, which has no reference image; expected fur or bare skin".into());
        }
        let sky = Sky::of(&asked.look).map_err(|failure| failure.to_string())?;
        let view = PictureView {
            look: asked.look.clone(),
            sky: sky.map(Arc::new),
            camera: Some(asked.camera),
            clip: asked.clip.clone(),
            time_s: asked.time_s,
            ..PictureView::default()
        };
        let kept = self.grown.as_ref().is_some_and(|(before, _)| same_strands(before, asked));
        if !kept {
            self.grown = None;
            if progress(Progress { doing: "growing strands".into(), share: None }).is_break() {
                return Ok(());
            }
            let grown = TrueView::new(&asked.file, &view).map_err(|failure| failure.to_string())?;
            self.grown = Some((asked.clone(), grown));
        }
        let Some((_, truth)) = &self.grown else { return Ok(()) };
        let mut picture: Option<TracedPicture> = None;
        let mut before = 0;
        for samples in PASSES {
            let mut tell = |done: u64, total: u64| {
                let share = Some(done as f32 / total.max(1) as f32);
                progress(Progress { doing: format!("{samples} samples"), share })
            };
            let Some(more) = truth.portion(&view, &Portion::of_samples(before..samples), &mut tell) else {
                return Ok(());
            };
            let share = before as f32 / samples as f32;
            match &mut picture {
                Some(picture) => picture.mix(&more, [share, 1.0 - share]),
                None => picture = Some(more),
            }
            let Some(traced) = &picture else { continue };
            let background = asked.look.background();
            let encoded = truth.encode(traced, &view);
            let flip = compare(&asked.drawn, &encoded, background.unwrap_or(CompareParams::default().over));
            let flip = flip.ok().map(|(figures, map)| (figures.flip.mean, map.magma()));
            show(ReferencePicture { picture: encoded, samples, of_samples: PASSES[PASSES.len() - 1], flip });
            before = samples;
        }
        Ok(())
    }
}

/// Returns true if two requests have the same strands in the same pose. Camera, light and picture may differ.
fn same_strands(a: &ReferenceRequest, b: &ReferenceRequest) -> bool {
    let pose = |asked: &ReferenceRequest| (asked.clip.clone(), asked.time_s, asked.look.picture.style);
    Arc::ptr_eq(&a.file, &b.file) && pose(a) == pose(b)
}
