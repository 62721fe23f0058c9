//! Compares settings of a model with its reference images, for `pelage chart shells` and a bake with limits.

use super::exit::Failure;
use super::stages::{pixels, stage_of};
use super::truth::ReferenceTracer;
use super::view::PictureView;
use pelage_bake::picture::Picture;
use pelage_bake::recipe::Recipe;
use pelage_stage::{
    Gpu, LookDetail, LookHair, Meter, NamedPackage, Stage, Viewpoint, count_fragments, fastest, framing,
};
use pelage_truth::compare::{CompareParams, compare_pictures};
use pelage_truth::decide::FrameTime;
use pelage_truth::likeness::Likeness;
use std::time::Instant;

/// Measurements of one setting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SettingMeasurements {
    /// Mean FLIP of all views, 0..=1.
    pub flip: f64,
    /// Mean FLIP of the pixels that are covered in either picture, 0..=1.
    pub flip_covered: f64,
    /// RMSE of the premultiplied linear colours.
    pub rmse: f64,
    /// Mean absolute difference of alpha, 0..=1.
    pub coverage_error: f64,
    /// Time of the fastest frame of the slowest view, milliseconds.
    pub frame_ms: f64,
    /// Number of fragment shader invocations in that frame; `None` if the adapter does not count them.
    pub fragments: Option<u64>,
    /// Number of fur layers drawn in that frame, skin excluded.
    pub layers: u32,
    /// Number of mesh triangles drawn in that frame.
    pub triangles: u32,
    /// Size of the package, bytes.
    pub package_bytes: u64,
    /// GPU memory of textures, buffers and shadow maps, bytes.
    pub gpu_bytes: u64,
    /// Duration of the bake, seconds.
    pub bake_s: f64,
}

/// Bakes or reslices a package with a recipe.
pub type Baker<'a> = Box<dyn Fn(&Recipe) -> Result<NamedPackage<'static>, Failure> + 'a>;

struct ReferenceView {
    view: PictureView,
    picture: Picture,
    /// Height of the fur in the view, pixels.
    fur_px: f64,
}

/// Measures settings of one model: bakes and draws each, and compares the pictures with the reference images.
pub struct ShellJudge<'a> {
    baker: Baker<'a>,
    views: Vec<ReferenceView>,
    /// Level of detail to draw.
    detail: LookDetail,
    gpu: Gpu,
    meter: Meter,
}

impl<'a> ShellJudge<'a> {
    /// Traces the reference images. Their views, size and samples are those of the recipe's `[judge]`. They do not
    /// depend on how strands are sliced.
    ///
    /// * `detail`: level of detail to draw
    /// * `doing`: progress callback
    pub fn new(
        baker: Baker<'a>,
        recipe: &Recipe,
        gpu: &Gpu,
        detail: LookDetail,
        doing: &mut dyn FnMut(&str),
    ) -> Result<Self, Failure> {
        let file = baker(recipe)?;
        let truth = ReferenceTracer::new(&file, &PictureView::default())?;
        let size = (recipe.judge.width, recipe.judge.height);
        let views = cameras(recipe, &truth);
        Ok(Self { detail, ..Self::of_views(baker, &truth, size, &views, recipe.judge.samples, gpu, doing) })
    }

    /// Traces reference images of the given size in pixels, cameras, and number of samples per pixel.
    pub fn of_views(
        baker: Baker<'a>,
        truth: &ReferenceTracer,
        size: (u32, u32),
        cameras: &[Viewpoint],
        samples: u32,
        gpu: &Gpu,
        doing: &mut dyn FnMut(&str),
    ) -> Self {
        let mut views = Vec::new();
        for (i, camera) in cameras.iter().enumerate() {
            let view = PictureView { camera: Some(*camera), ..PictureView::sized(size) };
            let picture = truth.picture(&view, samples, &mut |done, all| {
                doing(&format!("reference image {} of {}, {} %", i + 1, cameras.len(), 100 * done / all.max(1)));
            });
            // The reference image is quantised to 8 bits per channel, like the pictures compared with it.
            let picture = Picture::from(&truth.encode(&picture, &view));
            let fur_px = truth.fur_px(&view);
            views.push(ReferenceView { view, picture, fur_px });
        }
        Self { baker, views, detail: EVERYTHING, gpu: gpu.clone(), meter: Meter::new(gpu) }
    }

    /// Returns the number of layers, skin included, above which pictures with automatic detail no longer change.
    pub fn most_layers(&self, recipe: &Recipe) -> u32 {
        let highest = self.views.iter().map(|view| view.fur_px).fold(0.0, f64::max);
        let gaps = (highest / f64::from(recipe.detail.gap_px)).ceil();
        if recipe.detail.enabled { (gaps as u32).saturating_add(1) } else { u32::MAX }
    }

    /// Returns the name of the clock that measures frame times, as in `pelage bench`.
    pub fn timing(&self) -> &'static str {
        self.meter.clock().word()
    }

    /// Returns the cameras of the views as arguments of `pelage render`.
    pub fn view_words(&self) -> Vec<String> {
        self.views.iter().filter_map(|of| of.view.camera).map(|camera| format!("--camera {camera}")).collect()
    }

    /// Bakes a recipe, draws and times it from all views, and compares the pictures with the reference images.
    pub fn measure(&self, recipe: &Recipe) -> Result<(SettingMeasurements, Likeness), Failure> {
        let begun = Instant::now();
        let file = (self.baker)(recipe)?;
        let bake_s = begun.elapsed().as_secs_f64();
        let (measured, likeness) = self.measure_drawn(&file, self.detail)?;
        Ok((SettingMeasurements { bake_s, ..measured }, likeness))
    }

    /// Draws and times a package from all views at the level of detail `detail`, and compares the pictures with the
    /// reference images. The bake time is not included.
    pub fn measure_drawn(
        &self,
        file: &NamedPackage<'_>,
        detail: LookDetail,
    ) -> Result<(SettingMeasurements, Likeness), Failure> {
        let mut scene: Option<Stage> = None;
        let (mut sum, mut likenesses) = (SettingMeasurements::default(), Vec::new());
        for ReferenceView { view, picture: truth, fur_px } in &self.views {
            let scene = match &mut scene {
                Some(scene) => {
                    view.camera.into_iter().for_each(|camera| scene.look_from(camera));
                    scene
                }
                None => scene.insert(self.stage(file, view, detail)?),
            };
            let frame = scene.draw()?;
            let drawn = Picture::from(&pixels(scene)?);
            let (difference, _) = compare_pictures(&drawn, truth, &CompareParams::default())?;
            likenesses.push(Likeness::of_compared(&difference, &drawn, truth, *fur_px));
            sum.flip += difference.flip.mean;
            sum.flip_covered += difference.flip.covered;
            sum.rmse += difference.rmse.powi(2);
            sum.coverage_error += difference.coverage;
            let frame_ms = fastest(&self.meter, scene)?;
            if frame_ms > sum.frame_ms {
                sum.frame_ms = frame_ms;
                sum.fragments = count_fragments(scene)?.map(|counts| counts.iter().map(|(_, count)| count).sum());
                if let Some(drawn) = frame.report().instances.first() {
                    (sum.layers, sum.triangles) = (drawn.layers, drawn.triangles);
                }
            }
            let model = scene.model();
            sum.gpu_bytes = model.gpu_bytes() + scene.copies_bytes() + scene.shadow_bytes();
        }
        let count = self.views.len() as f64;
        let measured = SettingMeasurements {
            flip: sum.flip / count,
            flip_covered: sum.flip_covered / count,
            rmse: (sum.rmse / count).sqrt(),
            coverage_error: sum.coverage_error / count,
            package_bytes: file.bytes.len() as u64,
            ..sum
        };
        Ok((measured, Likeness::mean(&likenesses)))
    }

    /// Times several recipes alternately, each [`ROUNDS`] times from all views. The time of a recipe is that of its
    /// slowest view.
    pub fn time_in_turns(&self, recipes: &[Recipe]) -> Result<Vec<FrameTime>, Failure> {
        let Some(first) = self.views.first() else { return Ok(vec![FrameTime::default(); recipes.len()]) };
        let stage = |recipe: &Recipe| self.stage(&(self.baker)(recipe)?, &first.view, self.detail);
        let mut stages = recipes.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
        let mut rounds = vec![Vec::new(); recipes.len()];
        for _ in 0..ROUNDS {
            for (stage, times) in stages.iter_mut().zip(&mut rounds) {
                let mut slowest = 0.0_f64;
                for ReferenceView { view, .. } in &self.views {
                    view.camera.into_iter().for_each(|camera| stage.look_from(camera));
                    // Draws one untimed frame: after another setting, the caches contain that setting's data.
                    self.meter.frame(stage)?;
                    let mut fastest = f64::INFINITY;
                    for _ in 0..FRAMES {
                        fastest = fastest.min(self.meter.frame(stage)?);
                    }
                    slowest = slowest.max(fastest);
                }
                times.push(slowest);
            }
        }
        Ok(rounds.into_iter().map(FrameTime::of).collect())
    }

    /// Creates a stage of a package at a level of detail. Fur is always drawn in layers, even where individual strands
    /// would replace them.
    fn stage(&self, file: &NamedPackage<'_>, view: &PictureView, detail: LookDetail) -> Result<Stage, Failure> {
        let view = view.clone().with(|look| (look.fur.detail, look.fur.hair) = (detail, LookHair::Shells));
        Ok(stage_of(file, &view, || Ok(self.gpu.clone()))?)
    }
}

/// Level of detail for comparing settings, which differ only at full detail.
const EVERYTHING: LookDetail = LookDetail::Full;

/// Number of timing rounds per setting; enough to compute quartiles.
const ROUNDS: usize = 7;
/// Number of frames of a view per round. Only the fastest counts, because other load can only add time.
const FRAMES: usize = 2;

/// Returns the views of the recipe. If it has none, returns two that frame the model.
pub fn cameras(recipe: &Recipe, truth: &ReferenceTracer) -> Vec<Viewpoint> {
    if !recipe.judge.views.is_empty() {
        return recipe.judge.views.clone();
    }
    let view = PictureView::sized((recipe.judge.width, recipe.judge.height));
    [framing::TOWARDS_CAMERA, framing::BEHIND].map(|towards| truth.framed(&view, towards)).into()
}
