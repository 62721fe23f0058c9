//! Tests the doctor's recommendations: draws the picture with and without each change, and compares both with the
//! reference image.

use super::exit::Failure;
use super::output::Output;
use super::stages::{pixels, stage_of};
use super::truth::ReferenceTracer;
use super::view::PictureView;
use pelage_bake::picture::Picture;
use pelage_bake::recipe::Recipe;
use pelage_bake::reslice::reslice;
use pelage_stage::{Gpu, LookScattering, NamedPackage};
use pelage_truth::doctor::{Advice, ErrorChange, is_harmless};
use pelage_truth::likeness::Likeness;

/// Maximum number of rays for all pixels of the reference image, which takes seconds on any machine. All comparisons
/// use the same picture, so its noise is the same for all.
const RAYS: u64 = 1 << 22;

/// Tests each recommendation by drawing, and drops those that make the picture worse. The recommendations that were
/// kept stay applied for the next test, in the order of `advice`. Hair is lit without light between fibres, which the
/// changes do not affect and which takes most of the time of tracing.
///
/// Returns `advice` untested if nothing can be drawn: without an adapter, for a picture of more than [`RAYS`] pixels,
/// or if the package cannot be resliced.
///
/// Fails with errors of drawing, if there is an adapter.
pub fn try_advice(
    file: &NamedPackage<'static>,
    view: &PictureView,
    advice: Vec<Advice>,
    output: &mut Output,
) -> Result<Vec<Advice>, Failure> {
    let (width, height) = view.size();
    let samples = RAYS / (u64::from(width) * u64::from(height)).max(1);
    if samples == 0 || !advice.iter().any(|a| a.can_be_tried) {
        return Ok(advice);
    }
    let Ok(gpu) = Gpu::open() else { return Ok(advice) };
    let package = file.open()?;
    let mut recipe = Recipe::parse_recorded(&file.name, &package.manifest().recipe)?;
    let mut view = view.clone();
    if view.look.fur.scattering == LookScattering::Multiple {
        view.look.fur.scattering = LookScattering::Single;
    }
    let view = &view;
    let truth = ReferenceTracer::new(file, view)?;
    // The recipe's judge uses this many samples; more would not improve the comparison.
    let samples = samples.min(u64::from(recipe.judge.samples)) as u32;
    let mut show =
        |done: u64, all: u64| output.progress_of(done as usize, all as usize, "pixels of the reference image");
    let traced = Picture::from(&truth.encode(&truth.picture(view, samples, &mut show), view));
    let fur_px = truth.fur_px(view);
    let error = |file: &NamedPackage<'static>| -> Result<f64, Failure> {
        let mut stage = stage_of(file, view, || Ok(gpu.clone()))?;
        stage.draw()?;
        Ok(Likeness::of(&Picture::from(&pixels(&stage)?), &traced, fur_px)?.error)
    };
    let before = error(file)?;
    let mut kept = Vec::new();
    for mut advice in advice {
        if advice.can_be_tried {
            output.progress(&format!("trying {}", advice.change));
            let mut changed = recipe.clone();
            advice.change.split(" --set ").try_for_each(|set| changed.set(set))?;
            if let Ok(bytes) = reslice(&file.name, &package, &changed) {
                let after = error(&NamedPackage { name: file.name.clone(), bytes: bytes.into() })?;
                if !is_harmless(before, after) {
                    continue;
                }
                advice.measured = Some(ErrorChange { before, after });
                recipe = changed;
            }
        }
        kept.push(advice);
    }
    Ok(kept)
}
