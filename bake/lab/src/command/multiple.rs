//! `pelage chart multiple`: fur whose hairs scatter light to each other, compared with path tracing.

use super::driver::{Plan, PlannedRow, Topic, get_or_make};
use super::subject::Subject;
use crate::chart::Cell;
use crate::chart::multiple::{
    AMBIENT, COATS, COLUMNS, FORMS, LIGHTS, MultipleConfiguration, PANELS, SAMPLES, SIZE, Squares, cells,
    configurations,
};
use pelage_bake::recipe::{Recipe, ShadingModel};
use pelage_formats::Shading;
use pelage_stage::{Gpu, LookHair, Meter, NamedPackage, Samples, Viewpoint, framing};
use pelage_tool::exit::Failure;
use pelage_tool::machine::measured_on;
use pelage_tool::stages::{pixels, stage_of};
use pelage_tool::truth::ReferenceTracer;
use pelage_tool::view::PictureView;
use pelage_truth::TrueScattering;

/// Number of timed frames, of which the fastest counts.
const FRAMES: usize = 6;

/// Topic `multiple`.
pub struct MultipleTopic<'a> {
    subject: &'a Subject,
    configurations: Vec<MultipleConfiguration>,
    gpu: Gpu,
    meter: Meter,
    coats: [Option<FurWithTruths>; COATS.len()],
}

/// Package of one fur colour with its reference images.
struct FurWithTruths {
    package: NamedPackage<'static>,
    camera: Viewpoint,
    /// Reference image under each light, linear and premultiplied.
    truths: Vec<Vec<[f32; 4]>>,
}

impl<'a> MultipleTopic<'a> {
    /// Lists the configurations and opens the adapter.
    pub fn new(subject: &'a Subject) -> Result<Self, Failure> {
        let gpu = Gpu::open()?;
        let meter = Meter::new(&gpu);
        Ok(Self { subject, configurations: configurations(), meter, gpu, coats: [const { None }; COATS.len()] })
    }
}

impl Topic for MultipleTopic<'_> {
    fn plan(&self) -> Plan {
        let row = |c: &MultipleConfiguration| PlannedRow {
            series: c.form.name.into(),
            label: format!("{}, {}", COATS[c.coat].0, if c.strands { "strands" } else { "layers" }),
            default: c.form == FORMS[0],
            command: None,
        };
        Plan {
            topic: "multiple",
            title: format!(
                "{}: fibres in three lights, {SIZE}x{SIZE} pixels, against paths of {} bounces, {SAMPLES} per pixel",
                self.subject.name,
                TrueScattering::BOUNCES
            ),
            adapter: measured_on(&self.gpu.info.name),
            columns: COLUMNS.to_vec(),
            panels: PANELS.to_vec(),
            rows: self.configurations.iter().map(row).collect(),
        }
    }

    fn measure(&mut self, index: usize, doing: &mut dyn FnMut(&str)) -> Result<Vec<Cell>, Failure> {
        let configuration = self.configurations[index];
        let subject = self.subject;
        let coat = get_or_make(&mut self.coats[configuration.coat], || {
            FurWithTruths::new(subject, configuration.coat, doing)
        })?;
        doing("drawing");
        let (mut squares, mut frame_ms) = ([const { None }; LIGHTS.len()], f64::INFINITY);
        for (light, found) in squares.iter_mut().enumerate() {
            let mut stage = stage_of(&coat.package, &coat.view(&configuration, light), || Ok(self.gpu.clone()))?;
            let ambient = if configuration.form.ambient { [AMBIENT; 3] } else { [0.0; 3] };
            stage.params.shading = Some(Shading { ambient, ..stage.model().manifest().shading });
            stage.draw()?;
            *found = Some(Squares::new(&coat.truths[light], pixels(&stage)?.as_raw(), SIZE));
            if light == 0 {
                for _ in 0..FRAMES {
                    frame_ms = frame_ms.min(self.meter.frame(&mut stage)?);
                }
            }
        }
        Ok(cells(&configuration, &squares.map(Option::unwrap_or_default), frame_ms))
    }
}

impl FurWithTruths {
    fn new(subject: &Subject, coat: usize, doing: &mut dyn FnMut(&str)) -> Result<Self, Failure> {
        let (name, eumelanin) = COATS[coat];
        doing(&format!("baking the {name} coat"));
        let mut recipe: Recipe = subject.recipe.clone();
        recipe.shading.model = ShadingModel::Marschner;
        recipe.shading.ambient = [0.0; 3];
        recipe.fibre.eumelanin = Some(eumelanin);
        (recipe.color.root, recipe.color.tip, recipe.color.gain) = (None, None, None);
        recipe.color.base_color = false;
        let package = subject.bake(&recipe)?;
        let mut truth = ReferenceTracer::new(&package, &PictureView::default())?;
        truth.scatter(TrueScattering::BOUNCES)?;
        let camera = truth.framed(&PictureView::sized((SIZE, SIZE)), framing::TOWARDS_CAMERA);
        let mut made = Self { package, camera, truths: Vec::new() };
        for (light, (name, _)) in LIGHTS.iter().enumerate() {
            let view = made.lit(light);
            let picture = truth.picture(&view, SAMPLES, &mut |done, all| {
                doing(&format!("paths, light {name}, {} %", 100 * done / all.max(1)));
            });
            made.truths.push(picture.pixels);
        }
        Ok(made)
    }

    fn lit(&self, light: usize) -> PictureView {
        let view = PictureView { camera: Some(self.camera), ..PictureView::sized((SIZE, SIZE)) };
        view.with(|look| look.light.direction = LIGHTS[light].1)
    }

    /// Returns the view in which the runtime draws a configuration.
    fn view(&self, configuration: &MultipleConfiguration, light: usize) -> PictureView {
        self.lit(light).with(|look| {
            look.fur.scattering = configuration.form.scattering;
            look.fur.hair = if configuration.strands { LookHair::Strands } else { LookHair::Shells };
            look.picture.samples = Samples(if configuration.strands { 4 } else { 1 });
        })
    }
}
