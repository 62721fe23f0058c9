//! A model at several settings beside its true pictures: what `pelage chart shells` and a bake with limits measure.

use super::exit::Failure;
use super::staged::{pixels, stage_of};
use super::truth::{self, Truth};
use super::view::View;
use pelage_bake::picture::Picture;
use pelage_bake::pipeline::{self, Told};
use pelage_bake::recipe::Recipe;
use pelage_bake::reslice::{Slicer, reslice};
use pelage_bake::stages::groom::MapImages;
use pelage_import::mesh::Model;
use pelage_stage::{
    Gpu, LookDetail, LookHair, Meter, NamedPackage, Stage, Viewpoint, count_fragments, fastest, framing,
};
use pelage_truth::compare::{CompareParams, compare_pictures};
use pelage_truth::decide::FrameTime;
use pelage_truth::likeness::Likeness;
use std::time::Instant;

/// Measurements of one setting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Mean FLIP of all views, 0..=1.
    pub flip: f64,
    /// Mean FLIP where either picture covers a pixel.
    pub flip_covered: f64,
    /// RMSE of premultiplied linear colour.
    pub rmse: f64,
    /// Mean absolute difference of alpha.
    pub coverage_error: f64,
    /// The fastest frame of the slowest view.
    pub frame_ms: f64,
    /// Fragment shader runs of that frame; `None` where the adapter does not count them.
    pub fragments: Option<u64>,
    /// Layers that frame draws, the skin not counted.
    pub layers: u32,
    /// Triangles of the mesh that frame draws.
    pub triangles: u32,
    /// Size of the package.
    pub package_bytes: u64,
    /// Textures, buffers and shadow maps on the device.
    pub gpu_bytes: u64,
    /// Seconds of the bake.
    pub bake_s: f64,
}

/// What packages are made from.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// A model as it was read.
    Model {
        /// As the user named it.
        file: &'a str,
        /// Its name in the package.
        name: &'a str,
        /// The model.
        model: &'a Model,
        /// The images that the recipe names.
        images: &'a MapImages,
    },
    /// A model that was baked once, to be sliced anew: other layers, tiles and fins of it are quick.
    Baked {
        /// Its name in the package.
        name: &'a str,
        /// The bake.
        slicer: &'a Slicer<'a>,
    },
    /// A package, to be sliced anew.
    Package(&'a NamedPackage<'static>),
}

/// A view with its true picture.
struct TrueView {
    view: View,
    picture: Picture,
    /// Height of the fur in it, pixels.
    fur_px: f64,
}

/// Bakes settings of one model, draws them and compares them with the truth.
pub struct ShellJudge<'a> {
    source: Source<'a>,
    views: Vec<TrueView>,
    /// How much of what a recipe has is drawn.
    detail: LookDetail,
    gpu: Gpu,
    meter: Meter,
}

impl<'a> ShellJudge<'a> {
    /// Traces the true pictures: the views, size and samples of the recipe's `[judge]`. They do not depend on how the strands are sliced.
    ///
    /// * `detail`: how much of what a setting has is drawn
    /// * `doing`: is told what is going on
    pub fn new(
        source: Source<'a>,
        recipe: &Recipe,
        gpu: &Gpu,
        detail: LookDetail,
        doing: &mut dyn FnMut(&str),
    ) -> Result<Self, Failure> {
        let file = source.bake(recipe)?;
        let truth = Truth::new(&file, &View::default())?;
        let size = (recipe.judge.width, recipe.judge.height);
        let views = cameras(recipe, &truth);
        Ok(Self { detail, ..Self::of_views(source, &truth, size, &views, recipe.judge.samples, gpu, doing) })
    }

    /// Traces the true pictures of that size, pixels, from those cameras, with so many samples per pixel.
    pub fn of_views(
        source: Source<'a>,
        truth: &Truth,
        size: (u32, u32),
        cameras: &[Viewpoint],
        samples: u32,
        gpu: &Gpu,
        doing: &mut dyn FnMut(&str),
    ) -> Self {
        let mut views = Vec::new();
        for (i, camera) in cameras.iter().enumerate() {
            let view = View { camera: Some(*camera), ..View::sized(size) };
            let picture = truth.picture(&view, samples, &mut |done, all| {
                doing(&format!("true picture {} of {}, {} %", i + 1, cameras.len(), 100 * done / all.max(1)));
            });
            // Through bytes, as the pictures that it is compared with.
            let picture = Picture::from(&truth::encode(&picture, view.look.background()));
            let fur_px = truth.fur_px(&view);
            views.push(TrueView { view, picture, fur_px });
        }
        Self { source, views, detail: EVERYTHING, gpu: gpu.clone(), meter: Meter::new(gpu) }
    }

    /// Layers, skin counted, beyond which the pictures do not change where as many are drawn as the fur has pixels.
    pub fn most_layers(&self, recipe: &Recipe) -> u32 {
        let highest = self.views.iter().map(|view| view.fur_px).fold(0.0, f64::max);
        let gaps = (highest / f64::from(recipe.detail.gap_px)).ceil();
        if recipe.detail.enabled { (gaps as u32).saturating_add(1) } else { u32::MAX }
    }

    /// Where the milliseconds come from, as `pelage bench` has it.
    pub fn timing(&self) -> &'static str {
        self.meter.clock().word()
    }

    /// The views, as arguments of `pelage render`.
    pub fn view_words(&self) -> Vec<String> {
        self.views.iter().filter_map(|of| of.view.camera).map(|camera| format!("--camera {camera}")).collect()
    }

    /// Bakes a recipe, draws it from all views, times it and compares it with the truth.
    pub fn measure(&self, recipe: &Recipe) -> Result<(Measured, Likeness), Failure> {
        let begun = Instant::now();
        let file = self.source.bake(recipe)?;
        let bake_s = begun.elapsed().as_secs_f64();
        let (measured, likeness) = self.measure_drawn(&file, self.detail)?;
        Ok((Measured { bake_s, ..measured }, likeness))
    }

    /// Draws so much of a package from all views, times it and compares it with the truth. What a bake takes is not measured.
    pub fn measure_drawn(&self, file: &NamedPackage<'_>, detail: LookDetail) -> Result<(Measured, Likeness), Failure> {
        let mut scene: Option<Stage> = None;
        let (mut sum, mut likenesses) = (Measured::default(), Vec::new());
        for TrueView { view, picture: truth, fur_px } in &self.views {
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
        let measured = Measured {
            flip: sum.flip / count,
            flip_covered: sum.flip_covered / count,
            rmse: (sum.rmse / count).sqrt(),
            coverage_error: sum.coverage_error / count,
            package_bytes: file.bytes.len() as u64,
            ..sum
        };
        Ok((measured, Likeness::mean(&likenesses)))
    }

    /// Times recipes in turns: [`ROUNDS`] times each of them from all views, the slowest view counts.
    pub fn time_in_turns(&self, recipes: &[Recipe]) -> Result<Vec<FrameTime>, Failure> {
        let Some(first) = self.views.first() else { return Ok(vec![FrameTime::default(); recipes.len()]) };
        let stage = |recipe: &Recipe| self.stage(&self.source.bake(recipe)?, &first.view, self.detail);
        let mut stages = recipes.iter().map(stage).collect::<Result<Vec<_>, _>>()?;
        let mut rounds = vec![Vec::new(); recipes.len()];
        for _ in 0..ROUNDS {
            for (stage, times) in stages.iter_mut().zip(&mut rounds) {
                let mut slowest = 0.0_f64;
                for TrueView { view, .. } in &self.views {
                    view.camera.into_iter().for_each(|camera| stage.look_from(camera));
                    // What the frame before left in the caches is another setting's.
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

    /// Height of a package's fur in the first view, pixels, as the runtime goes by: at the nearest point of the model. `None` where the package
    /// has no levels of detail, or the eye is within the model's bounds.
    pub fn fur_px(&self, file: &NamedPackage<'_>) -> Result<Option<f32>, Failure> {
        let Some(TrueView { view, .. }) = self.views.first() else { return Ok(None) };
        let frame = self.stage(file, view, LookDetail::Auto)?.draw()?;
        Ok(frame.report().instances.first().and_then(|drawn| drawn.fur_px).filter(|px| px.is_finite()))
    }

    /// A package with so much of its fur in layers, also where strands would take their place.
    fn stage(&self, file: &NamedPackage<'_>, view: &View, detail: LookDetail) -> Result<Stage, Failure> {
        let view = view.clone().with(|look| (look.fur.detail, look.fur.hair) = (detail, LookHair::Shells));
        Ok(stage_of(file, &view, || Ok(self.gpu.clone()))?)
    }
}

/// All that a setting has is drawn: that is what settings differ in.
const EVERYTHING: LookDetail = LookDetail::Full;

/// Turns in which settings are timed: enough for quartiles.
const ROUNDS: usize = 7;
/// Frames of a view in a turn, of which the fastest counts: what else the machine does only adds.
const FRAMES: usize = 2;

impl Source<'_> {
    /// A package by `recipe`.
    pub fn bake(&self, recipe: &Recipe) -> Result<NamedPackage<'static>, Failure> {
        match *self {
            Self::Model { file, name, model, images } => {
                let baked = pipeline::bake(&Told::new(file, name, recipe, images), model, &mut |_| ())?;
                Ok(NamedPackage { name: name.into(), bytes: baked.package.into() })
            }
            Self::Baked { name, slicer } => Ok(NamedPackage { name: name.into(), bytes: slicer.slice(recipe)?.into() }),
            Self::Package(package) => {
                let bytes = reslice(&package.name, &package.open()?, recipe)?;
                Ok(NamedPackage { name: package.name.clone(), bytes: bytes.into() })
            }
        }
    }
}

/// The recipe's views; left empty, two that frame the model.
pub fn cameras(recipe: &Recipe, truth: &Truth) -> Vec<Viewpoint> {
    if !recipe.judge.views.is_empty() {
        return recipe.judge.views.clone();
    }
    let view = View::sized((recipe.judge.width, recipe.judge.height));
    [framing::TOWARDS_CAMERA, framing::BEHIND].map(|towards| truth.framed(&view, towards)).into()
}
