//! `pelage chart strands`: single strands and layers at six sizes, compared with the traced picture.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::greys::greys;
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::strands::{
    COLUMNS, DrawMethod, Size, StrandsConfiguration, StrandsMeasures, StrandsSizeFacts, cells, configurations, panels,
};
use crate::compare_motion::{FlickerFrame, flicker};
use crate::mask::Mask;
use pelage_bake::picture::Picture;
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::groom::find_furred_materials;
use pelage_import::mesh::RestPose;
use pelage_stage::{Gpu, LookStrandEdges, Meter, NamedPackage, Samples, Stage, Viewpoint, count_fragments, framing};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::shell_judge::SettingMeasurements;
use pelage_tool::stages::{pixels, stage_of};
use pelage_tool::truth::{ReferenceTracer, true_camera};
use pelage_tool::view::PictureView;
use pelage_truth::SurfaceVisibility;
use pelage_truth::compare::{CompareParams, compare_pictures};
use std::time::Instant;

/// Number of turns in which the methods of a group are timed, each turn with `FRAMES` frames of each method. The
/// fastest counts, because other load only adds time.
const TURNS: usize = 5;
/// Minimum number of turns if frames are slow.
const FEWEST_TURNS: usize = 2;
/// Duration after which no further turn begins, seconds.
const MOST_SECONDS: f64 = 30.0;
/// Number of frames of each method per turn.
const FRAMES: usize = 3;

/// Degrees by which the camera turns between two pictures for flicker. The model then moves by about a pixel at the
/// size of the recipe's `[judge]`.
const TURN_DEG: f32 = 0.25;

/// Topic `strands`.
pub struct StrandsTopic<'a> {
    subject: &'a Subject,
    /// Recipes without and with strands.
    recipes: [Recipe; 2],
    ways: Vec<DrawMethod>,
    configurations: Vec<StrandsConfiguration>,
    gpu: Gpu,
    meter: Meter,
    shared: Option<Shared>,
    sizes: [Option<(Picture, StrandsSizeFacts, PictureView)>; Size::ALL.len()],
    /// Results of all methods, by size and number of samples.
    groups: Vec<((usize, u32), Vec<StrandsMeasures>)>,
}

/// Data shared by all sizes.
struct Shared {
    /// Packages without and with strands.
    packages: [NamedPackage<'static>; 2],
    truth: ReferenceTracer,
    sight: SurfaceVisibility,
    camera: Viewpoint,
    /// Mean width over the strands' points, metres.
    width_m: f64,
}

impl<'a> StrandsTopic<'a> {
    /// Lists the configurations and opens the adapter. Packages with and without strands are baked, regardless of the
    /// recipe.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let with = |enabled| {
            let mut recipe = subject.recipe.clone();
            recipe.strands.enabled = enabled;
            recipe
        };
        let (gpu, ways) = (Gpu::open()?, draw_methods(subject));
        Ok(Self {
            subject,
            recipes: [with(false), with(true)],
            configurations: configurations(ways.len()),
            ways,
            meter: Meter::new(&gpu),
            gpu,
            shared: None,
            sizes: [const { None }; Size::ALL.len()],
            groups: Vec::new(),
        })
    }
}

impl Topic for StrandsTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |c: &StrandsConfiguration| PlannedRow {
            series: self.ways[c.way].series.clone(),
            label: if c.samples == 1 { "1 sample".into() } else { format!("{} samples", c.samples) },
            default: c.is_default(),
            command: None,
        };
        let judge = &self.recipes[0].judge;
        Plan {
            topic: "strands",
            title: format!(
                "{}, in close-up and at 2 to 1/8 times {}x{} pixels: strands and layers against the true strands",
                self.subject.name, judge.width, judge.height
            ),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: panels(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = self.configurations[index];
        let StrandsConfiguration { size, samples, .. } = configuration;
        let (subject, recipes, gpu, meter) = (self.subject, &self.recipes, &self.gpu, &self.meter);
        let shared = get_or_make(&mut self.shared, || Shared::new(subject, recipes, doing))?;
        let judge = &recipes[0].judge;
        let (picture, seen, view) = get_or_make(&mut self.sizes[size], || {
            shared.reference(Size::ALL[size], (judge.width, judge.height), judge.samples, doing)
        })?;
        let known = self.groups.iter().position(|(group, _)| *group == (size, samples));
        let known = match known {
            Some(known) => known,
            None => {
                doing("drawing");
                let found = group(gpu, meter, shared, &self.ways, (Size::ALL[size], view, picture), samples)?;
                self.groups.push(((size, samples), found));
                self.groups.len() - 1
            }
        };
        Ok(cells(&configuration, seen, &self.groups[known].1, meter.clock().word()))
    }
}

/// Returns the methods of drawing the subject's hair: its fur, or guided hair if it has no fur.
fn draw_methods(subject: &Subject) -> Vec<DrawMethod> {
    let recipe = &subject.recipe;
    let rest = RestPose::of(&subject.model.mesh, subject.model.animation.as_ref());
    let furred = find_furred_materials(&subject.model, &rest, recipe.model.bare.as_deref(), &mut Vec::new()).furred;
    match recipe.strands.group.first().filter(|_| !furred.contains(&true)) {
        Some(group) => DrawMethod::all(group.points() - 1, false),
        None => DrawMethod::all(recipe.strands.points - 1, true),
    }
}

impl Shared {
    fn new(subject: &Subject, recipes: &[Recipe; 2], doing: &mut dyn FnMut(&str)) -> Result<Self, Failure> {
        doing("baking");
        let packages = [subject.bake(&recipes[0])?, subject.bake(&recipes[1])?];
        let size = (recipes[0].judge.width, recipes[0].judge.height);
        let truth = ReferenceTracer::new(&packages[1], &PictureView::default())?;
        let framed = || truth.framed(&PictureView::sized(size), framing::TOWARDS_CAMERA);
        let camera = recipes[0].judge.views.first().copied().unwrap_or_else(framed);
        let points = &truth.scene.curves().points;
        let width_m = 2.0 * points.iter().map(|p| f64::from(p.radius_m)).sum::<f64>() / points.len().max(1) as f64;
        let sight = SurfaceVisibility::new(truth.scene.skin().clone())?;
        Ok(Self { packages, truth, sight, camera, width_m })
    }

    /// Returns the reference image of a size, the values shared by its methods, and its view.
    fn reference(
        &self,
        size: Size,
        judged: (u32, u32),
        samples: u32,
        doing: &mut dyn FnMut(&str),
    ) -> Result<(Picture, StrandsSizeFacts, PictureView), Failure> {
        let pixels = size.pixels(judged);
        let camera = size.camera(self.camera);
        let mut traced = |camera| {
            let view = PictureView { camera: Some(camera), ..PictureView::sized(pixels) };
            let picture = self.truth.picture(&view, samples, &mut |done, all| {
                doing(&format!("reference image, {} %", 100 * done / all.max(1)));
            });
            // The picture is encoded to bytes, like those compared with it.
            (self.truth.encode(&picture, &view), view)
        };
        let ((next, _), (picture, view)) = (traced(camera.turned(TURN_DEG.to_radians())), traced(camera));
        let seen = StrandsSizeFacts {
            pixels,
            true_samples: samples,
            true_flicker: self.flicker(camera, [&picture, &next].map(greys), pixels)?,
            strand_px: self.truth.px_per_m(&view) * self.width_m,
            strands: self.truth.scene.curves().len(),
        };
        Ok((Picture::from(&picture), seen, view))
    }

    /// Returns the flicker between a picture from `camera` and one from a slightly turned camera. This is the mean
    /// change of grey at points of the mesh surface and the hair on them.
    fn flicker(&self, camera: Viewpoint, greys: [Vec<f32>; 2], size: (u32, u32)) -> Result<Option<f64>, Failure> {
        let no_lines = Mask::empty(size.0, size.1);
        let cameras = [camera, camera.turned(TURN_DEG.to_radians())].map(true_camera);
        let moment =
            |i: usize| FlickerFrame { sight: &self.sight, camera: &cameras[i], grey: &greys[i], lines: &no_lines };
        Ok(flicker(&moment(0), &moment(1), size)?.surface.mean())
    }

    /// Returns the flicker of a stage's pictures. Afterwards, the stage's camera is `camera`.
    fn drawn_flicker(&self, stage: &mut Stage, camera: Viewpoint, size: (u32, u32)) -> Result<Option<f64>, Failure> {
        let mut seen_from = |camera| -> Result<_, Failure> {
            stage.look_from(camera);
            stage.draw()?;
            Ok(greys(&pixels(stage)?))
        };
        let (next, now) = (seen_from(camera.turned(TURN_DEG.to_radians()))?, seen_from(camera)?);
        self.flicker(camera, [now, next], size)
    }
}

/// Draws all methods of a size with the given number of samples, compares them with the truth, and times them in turns.
fn group(
    gpu: &Gpu,
    meter: &Meter,
    shared: &Shared,
    ways: &[DrawMethod],
    (size, view, truth): (Size, &PictureView, &Picture),
    samples: u32,
) -> Result<Vec<StrandsMeasures>, Failure> {
    let (mut stages, mut all) = (Vec::new(), Vec::new());
    for way in ways {
        let file = &shared.packages[usize::from(!way.needs_no_strands())];
        let view = view.clone().with(|look| {
            (look.fur.hair, look.fur.strand_edges, look.fur.detail) = (way.hair, way.edges, way.detail);
            look.picture.samples = Samples(samples);
        });
        let mut stage = stage_of(file, &view, || Ok(gpu.clone()))?;
        stage.params.study.strand_pieces = way.pieces;
        let mut found =
            StrandsMeasures { blended: way.edges == LookStrandEdges::Blended, ..draw_once(&mut stage, file, truth)? };
        found.flicker = shared.drawn_flicker(&mut stage, size.camera(shared.camera), view.size())?;
        all.push(found);
        stages.push(stage);
    }
    let begun = Instant::now();
    for turn in 0..TURNS {
        if turn >= FEWEST_TURNS && begun.elapsed().as_secs_f64() > MOST_SECONDS {
            break;
        }
        for (stage, found) in stages.iter_mut().zip(&mut all) {
            let ms = &mut found.measured.frame_ms;
            // This frame is not timed, because the caches still hold data of another method.
            meter.frame(stage)?;
            for _ in 0..FRAMES {
                *ms = ms.min(meter.frame(stage)?);
            }
            found.anew_ms = found.anew_ms.min(meter.uncached_frame(stage)?);
        }
    }
    Ok(all)
}

/// Draws with one method once, without timing.
fn draw_once(stage: &mut Stage, file: &NamedPackage<'_>, truth: &Picture) -> Result<StrandsMeasures, Failure> {
    let frame = stage.draw()?;
    let drawn = Picture::from(&pixels(stage)?);
    let (difference, _) = compare_pictures(&drawn, truth, &CompareParams::default())?;
    let detail = frame.report().instances.first().copied();
    let of = |value: fn(&pelage_runtime::InstanceDetail) -> u32| detail.as_ref().map_or(0, value);
    let (layers, triangles, pieces) = (of(|d| d.layers), of(|d| d.triangles), of(|d| d.strand_pieces));
    let lists = frame.report().target_bytes;
    drop(frame);
    let measured = SettingMeasurements {
        flip: difference.flip.mean,
        flip_covered: difference.flip.covered,
        rmse: difference.rmse,
        coverage_error: difference.coverage,
        frame_ms: f64::INFINITY,
        fragments: count_fragments(stage)?.map(|counts| counts.iter().map(|(_, count)| count).sum()),
        layers,
        triangles,
        package_bytes: file.bytes.len() as u64,
        gpu_bytes: stage.model().gpu_bytes() + stage.copies_bytes() + stage.shadow_bytes() + lists,
        bake_s: 0.0,
    };
    let strands = detail.map_or(0.0, |d| d.strands);
    Ok(StrandsMeasures { measured, anew_ms: f64::INFINITY, strands, pieces, ..StrandsMeasures::default() })
}
